#!/usr/bin/env bash
# web.sh [OPTION]... SCENE MESH IMAGES -o DIR
#                     a model for the web beside the full one: bytes, scores, and how long viewers take to show it
#
#   --hold-out K|LIST  photos that judge the results, as gpvc texture takes them [8]
#   --web OPTIONS      options of the model for the web, as one word [--target web]
#   --mbit N           megabits a second of the line that viewers load over [50]
#   --modules DIR      npm's packages three and cesium [build/node/node_modules, which tests/run.sh makes]
#   --gpvc FILE        the gpvc to run [build/release/app/gpvc, which is built first]
#
# IMAGES is the folder of the photos, or - where the scene says where they are. Viewers draw on the CPU, in headless Chromium. A time is
# that from the request until the first picture with all textures is there: what is downloaded, decoded and drawn.
#
# DIR/web.md is the table that is printed. Pictures of the viewers are DIR/full-three.png and the like.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

hold_out=8
web="--target web"
mbit=50
modules=$root/build/node/node_modules
gpvc=
o=
read_arguments "hold-out web mbit modules gpvc o" "$@"
[ ${#places[@]} = 3 ] || usage "expected SCENE, MESH and IMAGES, got ${#places[@]} arguments"
[ -n "$o" ] || usage "-o DIR is missing"
out=$o
[[ $mbit =~ ^[0-9]+$ ]] || usage "--mbit takes a number, got '$mbit'"
[ -d "$modules/three" ] && [ -d "$modules/cesium" ] || fail "$modules holds no three and cesium; tests/run.sh installs them"
images=()
[ "${places[2]}" = - ] || images=(--images "${places[2]}")
find_gpvc
mkdir -p "$out"

# seconds MODEL VIEWER [FLAG]: until the first picture, the median of three.
seconds() {
  for _ in 1 2 3; do
    node "$root/tests/browser/view_model.mjs" "$modules" "$out/$1" model.glb "$out/$1-$2.png" "--measure=$mbit" ${3:+"$3"} |
      sed -n 's/.*"drawn":\([0-9.]*\).*/\1/p'
  done | sort -n | sed -n 2p
}

{
  echo "| model | model.glb | PSNR | SSIM | 1 - NCC | three.js | CesiumJS |"
  echo "|---|---|---|---|---|---|---|"
} >"$out/web.md"
for model in full web; do
  options=()
  [ $model = full ] || read -ra options <<<"$web"
  "$gpvc" texture "${places[0]}" "${places[1]}" "${images[@]}" --hold-out "$hold_out" -o "$out/$model" --force "${options[@]}" \
    >"$out/$model.log" 2>&1 || fail "gpvc texture failed: $(said_last "$out/$model.log")"
  "$gpvc" evaluate "$out/$model/model.glb" "${places[0]}" "${images[@]}" -o "$out/$model-scores" --force >"$out/$model-scores.log" 2>&1 ||
    fail "gpvc evaluate failed: $(said_last "$out/$model-scores.log")"
  scores=$out/$model-scores/evaluate.json
  printf '| %s | %.1f MB | %.1f | %.3f | %.3f | %.1f s | %.1f s |\n' $model "$(stat -c %s "$out/$model/model.glb" | sed 's/$/e-6/')" \
    "$(figure "$scores" psnr_db)" "$(figure "$scores" ssim)" "$(figure "$scores" one_minus_ncc)" "$(seconds $model three)" \
    "$(seconds $model cesium --cesium)" >>"$out/web.md"
done
cat "$out/web.md"
