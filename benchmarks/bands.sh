#!/usr/bin/env bash
# bands.sh [OPTION]... SCENE MESH IMAGES -o DIR
#                     what photos of more bits and bands take: the same photos as 8-bit RGB, 16-bit RGB, 5 bands of 16 bits and 10 of floats
#
#   --rounds N         runs of each, in turns, of which the medians count [3]
#   --percent N        photos are resampled to so many per cent of their width and height [100]
#   --options OPTIONS  of all runs, as one word []
#   --gpvc FILE        the gpvc to run [build/release/app/gpvc, which is built first]
#
# IMAGES is the folder of the photos. They are converted by gdal_translate (Debian's gdal-bin) to TIFFs without compression, in
# DIR/photos-*: bands repeat red, green and blue, so that all runs see the same. Time and memory are those of whole runs.
#
# DIR/bands.md is the table that is printed.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

rounds=3
percent=100
options=
gpvc=
o=
read_arguments "rounds percent options gpvc o" "$@"
[ ${#places[@]} = 3 ] || usage "expected SCENE, MESH and IMAGES, got ${#places[@]} arguments"
[ -n "$o" ] || usage "-o DIR is missing"
out=$o
[[ $rounds =~ ^[1-9][0-9]*$ ]] || usage "--rounds takes a number from 1 on, got '$rounds'"
[[ $percent =~ ^[1-9][0-9]*$ ]] || usage "--percent takes a number from 1 on, got '$percent'"
command -v gdal_translate >/dev/null || fail "gdal_translate is missing: it is in Debian's gdal-bin"
find_gpvc
mkdir -p "$out"
read -ra more <<<"$options"

declare -A how=(
  [8bit-rgb]="-b 1 -b 2 -b 3"
  [16bit-rgb]="-b 1 -b 2 -b 3 -ot UInt16 -scale 0 255 0 65535"
  [5x16bit]="-b 1 -b 2 -b 3 -b 1 -b 2 -ot UInt16 -scale 0 255 0 65535"
  [10xfloat]="-b 1 -b 2 -b 3 -b 1 -b 2 -b 3 -b 1 -b 2 -b 3 -b 1 -ot Float32 -scale 0 255 0 1"
)
kinds=(8bit-rgb 16bit-rgb 5x16bit 10xfloat)

# convert KIND: files keep their names, by which scenes know them; what they are, their first bytes say.
convert() {
  [ "$(cat "$out/photos-$1/percent" 2>/dev/null)" = "$percent" ] && return
  local file name
  while IFS= read -r file; do
    name=$out/photos-$1/${file#"${places[2]}"/}
    mkdir -p "$(dirname "$name")"
    # shellcheck disable=SC2086
    gdal_translate -q -of GTiff -co PROFILE=BASELINE -co ALPHA=NO -r average -outsize "$percent%" "$percent%" ${how[$1]} "$file" "$name"
  done < <(find "${places[2]}" -type f \( -iname '*.jpg' -o -iname '*.jpeg' -o -iname '*.png' -o -iname '*.tif' \))
  echo "$percent" >"$out/photos-$1/percent"
}
for kind in "${kinds[@]}"; do convert "$kind"; done

# measure KIND: appends seconds and KiB of a run.
measure() {
  /usr/bin/time -f '%e %M' -o "$out/time" "$gpvc" texture "${places[0]}" "${places[1]}" --images "$out/photos-$1" -o "$out/$1" --force \
    "${more[@]}" >"$out/$1.log" 2>&1 || fail "gpvc texture failed: $(said_last "$out/$1.log")"
  cat "$out/time" >>"$out/$1.times"
}
rm -f "$out"/*.times
for ((round = 0; round < rounds; ++round)); do
  for kind in "${kinds[@]}"; do measure "$kind"; done
done

# median KIND COLUMN
median() { awk -v column="$2" '{print $column}' "$out/$1.times" | sort -n | awk '{v[NR] = $1} END {print v[int((NR + 1) / 2)]}'; }

base=$(median 8bit-rgb 1)
{
  echo "| photos | s | times 8-bit RGB | GB of memory | decodings a photo | MB of pages |"
  echo "|---|---|---|---|---|---|"
  for kind in "${kinds[@]}"; do
    seconds=$(median "$kind" 1)
    printf '| %s | %.1f | %.2f | %.2f | %s | %.0f |\n' "$kind" "$seconds" "$(echo "$seconds / $base" | bc -l)" \
      "$(echo "$(median "$kind" 2) * 1024 / 10^9" | bc -l)" "$(figure "$out/$kind/run.json" per_photo)" \
      "$(find "$out/$kind" -name 'model_*' -printf '%s\n' | awk '{s += $1} END {print s / 1e6}')"
  done
} >"$out/bands.md"
cat "$out/bands.md"
