#!/usr/bin/env bash
# right_scenes.sh [OPTION]... -o DIR
#                      whether gpvc texture refuses or warns of scenes that are right: synthetic cities of all sizes
#
#   --seeds N          cities of each kind, 60 scenes for each [4]
#   --gpvc FILE        the gpvc to run [build/release/app/gpvc, which is built first]
#
# A kind is a number of photos (6, 15, 40), their size (160x120 to 1200x800), a number of faces (1000, 8000) and a lens (with distortion
# or without). DIR/right_scenes.md is the table that is printed, by number and size of the photos; DIR/said.txt what was said.
# Scenes are removed after their run.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

seeds=4
gpvc=
o=
read_arguments "seeds gpvc o" "$@"
[ ${#places[@]} = 0 ] || usage "expected no arguments beside options, got '${places[0]}'"
[ -n "$o" ] || usage "-o DIR is missing"
out=$o
find_gpvc
mkdir -p "$out"
: >"$out/said.txt"

{
  echo "| photos | size | scenes | refused | warned of |"
  echo "|---|---|---|---|---|"
} >"$out/right_scenes.md"
all=0 all_refused=0 all_warned=0
for photos in 6 15 40; do
  for size in 160x120 240x160 400x300 640x480 1200x800; do
    scenes=0 refused=0 warned=0
    for ((seed = 1; seed <= seeds; ++seed)); do
      for faces in 1000 8000; do
        for lens in opencv pinhole; do
          "$gpvc" synth city -o "$out/scene" --force --photos $photos --photo-size $size --faces $faces --lens $lens --seed $seed --no-ids --quiet >"$out/log"
          scenes=$((scenes + 1))
          "$gpvc" texture "$out/scene/colmap" "$out/scene/mesh.ply" -o "$out/textured" --force --quiet >"$out/log" 2>&1 || refused=$((refused + 1))
          if grep -E '^gpvc: (warning|error)' "$out/log" | sed "s/^/$photos x $size, $faces faces, $lens, seed $seed: /" >>"$out/said.txt"; then
            warned=$((warned + 1))
          fi
        done
      done
    done
    echo "| $photos | $size | $scenes | $refused | $((warned - refused)) |" >>"$out/right_scenes.md"
    all=$((all + scenes)) all_refused=$((all_refused + refused)) all_warned=$((all_warned + warned - refused))
  done
done
echo "| all | | $all | $all_refused | $all_warned |" >>"$out/right_scenes.md"
rm -rf "$out/scene" "$out/textured" "$out/log"
cat "$out/right_scenes.md"
