#!/usr/bin/env bash
# cross_validation.sh [OPTION]... SCENE MESH IMAGES [SCENE MESH IMAGES]... -o DIR
#                          sets of options of gpvc texture side by side, judged by photos that were left out
#
#   --set NAME="OPTIONS"  options of gpvc texture; may be given several times, and differences are to the first
#                         [--set default="": gpvc's own]
#   --folds K[,K]...      folds of each scene, or of all scenes: fold n leaves out the n-th photo and every K-th after it,
#                         so that each photo is left out once [4]
#   --downscale N         a cheaper run: textures from photos of 1/N of their size; scores are on whole photos all the same [1]
#   --gpvc FILE           the gpvc to run [build/release/app/gpvc, which is built first]
#
# IMAGES is the folder of the photos, or - where the scene says where they are. For each fold and set the mesh is textured
# without the fold's photos, and gpvc evaluate compares renders of the model with them. A scene is called what the folder of
# its mesh is called.
#
# DIR/cross_validation.md is the table that is printed: means over the folds, lower is better for 1 - NCC and dE2000.
# Colours are compared after one gain per channel, as photos differ in exposure and a model has but one. DIR/runs.csv has the
# figures of every fold; DIR/SCENE/SET/N.json has the scores of fold N photo by photo, N.log what gpvc said. Models are not kept.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

sets=()
declare -A options=()
# add_set NAME=OPTIONS
add_set() {
  local name=${1%%=*}
  [[ $1 == *=* && $name =~ ^[A-Za-z0-9_.+-]+$ ]] || usage "--set takes NAME=\"OPTIONS\" with a name of letters, digits and ._+-, got '$1'"
  [ -z "${options[$name]+set}" ] || usage "--set $name is given twice"
  sets+=("$name")
  options[$name]=${1#*=}
}

folds=4
downscale=1
gpvc=
out=
places=()
while [ $# -gt 0 ]; do
  case $1 in
    --set | --folds | --downscale | --gpvc | -o)
      [ $# -ge 2 ] || usage "$1 takes a value"
      case $1 in
        --set) add_set "$2" ;;
        --folds) folds=$2 ;;
        --downscale) downscale=$2 ;;
        --gpvc) gpvc=$2 ;;
        -o) out=$2 ;;
      esac
      shift ;;
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    -?*) usage "there is no option '$1'" ;;
    *) places+=("$1") ;;
  esac
  shift
done
[ ${#places[@]} -gt 0 ] || usage "expected SCENE, MESH and IMAGES"
[ $((${#places[@]} % 3)) = 0 ] || usage "expected SCENE, MESH and IMAGES for each scene, got ${#places[@]} arguments"
[ -n "$out" ] || usage "-o DIR is missing"
[[ $folds =~ ^[0-9]+(,[0-9]+)*$ ]] || usage "--folds takes numbers separated by commas, got '$folds'"
[[ $downscale =~ ^[1-9][0-9]?$ ]] || usage "--downscale takes a number from 1 to 99, got '$downscale'"
[ ${#sets[@]} -gt 0 ] || add_set "default="
scenes=$((${#places[@]} / 3))
IFS=, read -ra folds_of <<<"$folds"
if [ ${#folds_of[@]} = 1 ]; then
  while [ ${#folds_of[@]} -lt $scenes ]; do folds_of+=("${folds_of[0]}"); done
fi
[ ${#folds_of[@]} = $scenes ] || usage "--folds has ${#folds_of[@]} numbers for $scenes scenes"
for k in "${folds_of[@]}"; do [[ $k =~ ^([2-9]|[1-9][0-9]{1,2})$ ]] || usage "--folds takes numbers from 2 to 999, got '$k'"; done

names=()
for ((s = 0; s < scenes; ++s)); do
  [ -e "${places[3 * s]}" ] || fail "the scene ${places[3 * s]} does not exist"
  [ -e "${places[3 * s + 1]}" ] || fail "the mesh ${places[3 * s + 1]} does not exist"
  [ "${places[3 * s + 2]}" = - ] || [ -d "${places[3 * s + 2]}" ] || fail "the folder of photos ${places[3 * s + 2]} does not exist"
  name=$(basename "$(dirname "$(realpath "${places[3 * s + 1]}")")")
  name=${name//,/_}  # a comma ends a column of runs.csv
  for other in "${names[@]}"; do
    [ "$other" != "$name" ] || fail "two meshes lie in folders of the name $name, by which their scenes are called"
  done
  names+=("$name")
done

find_gpvc

mkdir -p "$out"
out=$(cd "$out" && pwd)
[ -f "$out/runs.csv" ] || [ -z "$(ls "$out")" ] || fail "$out holds other files; give another folder, or empty that one"
for name in "${names[@]}"; do rm -rf "${out:?}/$name"; done
echo "scene,set,fold,photos,wall_s,completeness,psnr_db,ssim,one_minus_ncc,ciede2000_with_gain,sharpness,cuts_px,photo_misfit" >"$out/runs.csv"

# --- one fold -------------------------------------------------------------------------------------------------------

# mean FILE: the figures of "mean" in an evaluate.json, in the CSV's order.
mean() {
  awk -F'[:,]' '
    /"mean"/ { mean = 1 } /}/ { mean = 0 }
    mean { gsub(/[ "]/, "", $1); value[$1] = $2 + 0 }
    END { printf "%.6f,%.4f,%.6f,%.6f,%.4f,%.4f", value["completeness"], value["psnr_db"], value["ssim"], value["one_minus_ncc"], value["ciede2000_with_gain"], value["sharpness"] }' "$1"
}
# figure FILE NAME: of a run.json, empty where it has none.
figure() { sed -n "s/^ *\"$2\": \([-0-9.e+]*\),*$/\1/p" "$1" | head -1; }

# run_fold SCENE_NUMBER FOLD SET: textures without the fold's photos, scores, and adds a row to runs.csv.
run_fold() {
  local name=${names[$1]} scene=${places[3 * $1]} mesh=${places[3 * $1 + 1]} from=() extra=()
  local to=$out/$name/$3 list=$out/$name/fold_$2.txt start end
  [ "${places[3 * $1 + 2]}" = - ] || from=(--images "${places[3 * $1 + 2]}")
  read -ra extra <<<"${options[$3]}"
  mkdir -p "$to"
  start=$(date +%s.%N)
  "$gpvc" texture "$scene" "$mesh" "${from[@]}" --downscale "$downscale" --hold-out "@$list" "${extra[@]}" --no-resume -o "$to/model" >"$to/$2.log" 2>&1 ||
    fail "$name, fold $2, set $3: gpvc texture failed: $(said_last "$to/$2.log")"
  end=$(date +%s.%N)
  "$gpvc" evaluate "$to/model/model.glb" "$scene" "${from[@]}" --mesh "$mesh" --views "@$list" -o "$to/scores" -q >>"$to/$2.log" 2>&1 ||
    fail "$name, fold $2, set $3: gpvc evaluate failed: $(said_last "$to/$2.log")"
  mv "$to/scores/evaluate.json" "$to/$2.json"
  local cuts misfit
  cuts=$(figure "$to/model/run.json" median_px)
  misfit=$(figure "$to/model/run.json" photo_misfit_exposed)
  rm -r "$to/scores" "$to/model"
  echo "$name,$3,$2,$(wc -l <"$list"),$(awk "BEGIN { printf \"%.2f\", $end - $start }"),$(mean "$to/$2.json"),${cuts:-0},${misfit:-0}" >>"$out/runs.csv"
  tail -1 "$out/runs.csv"
}

# write_folds SCENE_NUMBER: the photos of each fold. A small texture says which photos there are, and in which order.
write_folds() {
  local name=${names[$1]} from=() k=${folds_of[$1]}
  [ "${places[3 * $1 + 2]}" = - ] || from=(--images "${places[3 * $1 + 2]}")
  mkdir -p "$out/$name"
  "$gpvc" texture "${places[3 * $1]}" "${places[3 * $1 + 1]}" "${from[@]}" --downscale 16 --no-resume -o "$out/$name/small" >"$out/$name/small.log" 2>&1 ||
    fail "$name: gpvc texture failed: $(said_last "$out/$name/small.log")"
  # Views of one photo, as panoramas have, follow each other and stay together.
  awk -F'"' -v k="$k" -v to="$out/$name" '
    /^   "name": / { name = $4 }
    /^   "photo": / { photo = $4 }
    /^   "used": true/ { if (photo != last) fold = n++ % k + 1; last = photo; print name >(to "/fold_" fold ".txt") }' "$out/$name/small/views.json"
  rm -r "$out/$name/small" "$out/$name/small.log"
  [ -s "$out/$name/fold_$k.txt" ] || fail "$name has fewer than $k photos, too few for as many folds"
}

for ((s = 0; s < scenes; ++s)); do
  echo "== ${names[s]}: ${folds_of[s]} folds of ${sets[*]}"
  write_folds $s
  for ((fold = 1; fold <= folds_of[s]; ++fold)); do
    for name in "${sets[@]}"; do run_fold $s $fold "$name"; done
  done
done

# --- the table ------------------------------------------------------------------------------------------------------

lines() { printf '%s\n' "$@"; }

# Means over the folds, and in brackets the mean difference to the first set in the same folds; then over the scenes.
table() {
  sets=$(lines "${sets[@]}") scenes=$(lines "${names[@]}") awk -F, '
    function cell(s, set, f, format,   v) {
      v = mean[s, set, f] / count[s, set]
      return sprintf(" " format, v) (set == first ? "" : sprintf(" (%+" substr(format, 2) ")", v - mean[s, first, f] / count[s, first]))
    }
    function row(s, set) {
      print "| " (set == first ? s : "") " | " set " |" cell(s, set, "one_minus_ncc", "%.4f") " |" cell(s, set, "ssim", "%.4f") " |" \
        cell(s, set, "psnr_db", "%.2f") " |" cell(s, set, "ciede2000_with_gain", "%.2f") " |" cell(s, set, "sharpness", "%.3f") " |" cell(s, set, "cuts_px", "%.2f") " |" cell(s, set, "photo_misfit", "%.2f") " |" cell(s, set, "completeness", "%.4f") " |" cell(s, set, "wall_s", "%.1f") " |"
    }
    NR == 1 { for (i = 5; i <= NF; ++i) field[i] = $i; fields = NF; next }
    { ++count[$1, $2]; for (i = 5; i <= NF; ++i) mean[$1, $2, field[i]] += $i }
    END {
      print "| scene | set | 1 - NCC | SSIM | PSNR, dB | dE2000 with gain | sharpness | cuts, px | photos, dE2000 | completeness | wall, s |"
      print "|---|---|---|---|---|---|---|---|---|---|---|"
      set_count = split(ENVIRON["sets"], set, "\n"); scene_count = split(ENVIRON["scenes"], scene, "\n"); first = set[1]
      for (s = 1; s <= scene_count; ++s)
        for (n = 1; n <= set_count; ++n) {
          row(scene[s], set[n])
          ++count["all scenes", set[n]]
          for (i = 5; i <= fields; ++i) mean["all scenes", set[n], field[i]] += mean[scene[s], set[n], field[i]] / count[scene[s], set[n]]
        }
      if (scene_count > 1) for (n = 1; n <= set_count; ++n) row("all scenes", set[n])
    }' "$out/runs.csv"
}

report() {
  local s
  printf '# Cross-validation\n\n%s on %s, %s processors' "$("$gpvc" --version)" "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)" "$(nproc)"
  [ "$downscale" = 1 ] || printf ', photos of 1/%s of their size' "$downscale"
  printf '.\n\n'
  table
  printf '\n- Means over the folds'
  for ((s = 0; s < scenes; ++s)); do printf '%s %s %s' "$([ $s = 0 ] && echo ':' || echo ',')" "${folds_of[s]}" "${names[s]}"; done
  printf '. In brackets the difference to %s.\n' "${sets[0]}"
  printf -- '- Lower is better for 1 - NCC, dE2000, cuts and wall time, higher for the others. Sharpness is that of the photo where it\n'
  printf -- '  is 1. Cuts: how far the photos on both sides are apart, in the median; photos: how different they are there with their\n'
  printf -- '  exposures corrected; 0 where seams are not levelled.\n'
  for name in "${sets[@]}"; do printf -- '- %s: %s\n' "$name" "${options[$name]:-no options}"; done
}
echo
report | tee "$out/cross_validation.md"
