#!/usr/bin/env bash
# imperfections.sh [OPTION]... -o DIR
#                      what blurred photos, inexact meshes, exposure, traffic and the like do to the texture of a synthetic city
#
#   --faces N          faces of the city, as gpvc synth takes them [60000]
#   --texture OPTIONS  options of gpvc texture, as one word
#   --cases LIST       some of the cases, separated by commas [all; see the table below]
#   --gpvc FILE        the gpvc to run [build/release/app/gpvc, which is built first]
#
# Every case is the same city, seen by the same 20 photos, every fifth of which judges the result. A pixel covers some 8 cm of it,
# so a mesh noise of 0.081 m is one pixel.
#
# DIR/imperfections.md is the table that is printed: of the area that photos see, the share that is textured and the share that
# has another surface's colour (gpvc evaluate --truth); the step across seams, in grey levels, before and after levelling; and how
# renders differ from the photos held out as they would be without the imperfection. Scenes stay in DIR/scenes and are used again.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

# Thin lens of 0.5 m: some 5 px of blur at the nearest and the farthest; 16 rays a pixel are enough for its disc.
all=(perfect mesh_1px mesh_2px mesh_5px blur exposure traffic trees fences haze)
declare -A imperfection=(
  [perfect]=""
  [mesh_1px]="--mesh-noise 0.081"
  [mesh_2px]="--mesh-noise 0.162"
  [mesh_5px]="--mesh-noise 0.405"
  [blur]="--aperture 0.5 --shake 3 --rays 16"
  [exposure]="--exposure"
  [traffic]="--cars 20 --people 40"
  [trees]="--trees --wires --cars 20 --people 40"
  [fences]="--fences --reflections"
  [haze]="--haze 400"
)

faces=60000
texture=
cases=$(IFS=,; echo "${all[*]}")
gpvc=
o=
read_arguments "faces texture cases gpvc o" "$@"
[ ${#places[@]} = 0 ] || usage "expected no arguments beside options, got '${places[0]}'"
[ -n "$o" ] || usage "-o DIR is missing"
out=$o
IFS=, read -ra cases <<<"$cases"
for name in "${cases[@]}"; do [ -n "${imperfection[$name]+set}" ] || usage "there is no case '$name': ${all[*]}"; done

find_gpvc
mkdir -p "$out/scenes"
out=$(cd "$out" && pwd)

# run COMMAND OPTION...: its output goes to DIR/log.txt.
run() { "$gpvc" "$@" -q >"$out/log.txt" 2>&1 || fail "gpvc $* failed: $(tail -1 "$out/log.txt")"; }

rows=$out/rows.txt
: >"$rows"
read -ra texture_options <<<"$texture"
for name in "${cases[@]}"; do
  scene=$out/scenes/$name-$faces
  read -ra options <<<"${imperfection[$name]}"
  [ -f "$scene/run.json" ] || run synth city -o "$scene" --faces "$faces" "${options[@]}"
  model=$out/$name
  run texture "$scene/colmap" "$scene/mesh.ply" --hold-out 5 --no-resume --force "${texture_options[@]}" -o "$model"
  truth=$("$gpvc" evaluate "$model/model.obj" "$scene/colmap" --mesh "$scene/mesh.ply" --truth "$scene" -q) || fail "$name was not compared with the truth"
  true_photos=$scene/images
  [ ! -d "$scene/clean" ] || true_photos=$scene/clean
  run evaluate "$model/model.obj" "$scene/colmap" --images "$true_photos" --mesh "$scene/mesh.ply" --force -o "$model-scores"
  scores=$model-scores/evaluate.json
  # The first table's "wrong" is the sixth word from the end of a line.
  echo "$name $(awk '
      /^all / && !alls++ { all = $(NF - 5); textured = $(NF - 7) }
      /^seen whole by a view / && !wholes++ { whole = $(NF - 5) }
      END { print textured, all, whole }' <<<"$truth")" \
    "$(figure "$model/run.json" seam_step_before) $(figure "$model/run.json" seam_step_after)" \
    "$(figure "$scores" one_minus_ncc) $(figure "$scores" ssim) $(figure "$scores" psnr_db) $(figure "$scores" ciede2000)" >>"$rows"
done

report() {
  printf '# Imperfections\n\n%s, gpvc texture %s\n\n' "$("$gpvc" --version)" "${texture:-without options}"
  echo "| case | gpvc synth city | textured | wrong | wrong, faces seen whole | seam step | 1 - NCC | SSIM | PSNR, dB | dE2000 |"
  echo "|---|---|---|---|---|---|---|---|---|---|"
  while read -r name rest; do
    awk -v name="$name" -v options="${imperfection[$name]:--}" '{
      printf "| %s | `%s` | %s %% | %s %% | %s %% | %.1f to %.2f | %.4f | %.4f | %.1f | %.2f |\n", name, options, $1, $2, $3, $4, $5, $6, $7, $8, $9
    }' <<<"$rest"
  done <"$rows"
}
report | tee "$out/imperfections.md"
rm -f "$rows" "$out/log.txt"
