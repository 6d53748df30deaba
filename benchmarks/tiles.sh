#!/usr/bin/env bash
# tiles.sh [OPTION]... SCENE MESH IMAGES -o DIR
#                         a scene in tiles, beside the same scene undivided, and beside what its plan said
#
#   --tile-faces N[,N]... faces of a tile at most; a job for each [100000]
#   --hold-out K|LIST     photos that judge the results, as gpvc texture takes them [8]
#   --memory SIZE         what each unit may take [what is free]
#   --no-levels           without levels of detail
#   --no-whole            without the undivided run, for scenes that do not fit into memory; nothing is scored then
#   --gpvc FILE           the gpvc to run [build/release/app/gpvc, which is built first]
#
# IMAGES is the folder of the photos, or - where the scene says where they are. Each unit is run by a process of its own, one
# after another, as its peak of memory is wanted.
#
# DIR/tiles.md has the tables that are printed: what units took, stage by stage, beside their plan; and labels, seams and scores
# on the photos held out. DIR/units.csv has the figures of every unit. Jobs stay in DIR/N, models of their tiles put together in
# DIR/N-model.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

tile_faces=100000
hold_out=8
gpvc=
out=
whole=yes
memory=() levels=() places=()
while [ $# -gt 0 ]; do
  case $1 in
    --tile-faces | --hold-out | --memory | --gpvc | -o)
      [ $# -ge 2 ] || usage "$1 takes a value"
      case $1 in
        --tile-faces) tile_faces=$2 ;;
        --hold-out) hold_out=$2 ;;
        --memory) memory=(--memory "$2") ;;
        --gpvc) gpvc=$2 ;;
        -o) out=$2 ;;
      esac
      shift ;;
    --no-levels) levels=(--no-levels) ;;
    --no-whole) whole= ;;
    -h | --help) sed -n '2,/^set /{/^#/s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"; exit 0 ;;
    -?*) usage "there is no option '$1'" ;;
    *) places+=("$1") ;;
  esac
  shift
done
[ ${#places[@]} = 3 ] || usage "expected SCENE, MESH and IMAGES, got ${#places[@]} arguments"
[ -n "$out" ] || usage "-o DIR is missing"
[[ $tile_faces =~ ^[0-9]+(,[0-9]+)*$ ]] || usage "--tile-faces takes numbers separated by commas, got '$tile_faces'"
IFS=, read -ra sizes <<<"$tile_faces"
scene=${places[0]} mesh=${places[1]} from=()
[ -e "$scene" ] || fail "the scene $scene does not exist"
[ -e "$mesh" ] || fail "the mesh $mesh does not exist"
if [ "${places[2]}" != - ]; then
  [ -d "${places[2]}" ] || fail "the folder of photos ${places[2]} does not exist"
  from=(--images "${places[2]}")
fi
gnu_time=$(type -P time) || fail "GNU time is missing: install the package 'time'"

find_gpvc

mkdir -p "$out"
out=$(cd "$out" && pwd)
[ -f "$out/units.csv" ] || [ -z "$(ls "$out")" ] || fail "$out holds other files; give another folder, or empty that one"
[ -z "$whole" ] || from+=(--hold-out "$hold_out")
echo "tile_faces,unit,stage,planned_s,cpu_s,wall_s,planned_mb,peak_mb" >"$out/units.csv"

# measured LOG COMMAND...: runs it, and prints its wall and processor seconds and its peak in megabytes.
measured() {
  local log=$1 wall user system kilobytes
  shift
  "$gnu_time" -f '%e %U %S %M' -o "$out/time.txt" "$@" >"$log" 2>&1 || fail "$* failed: $(tail -1 "$log")"
  read -r wall user system kilobytes < <(tail -1 "$out/time.txt")
  awk "BEGIN { printf \"%.2f %.2f %.0f\", $wall, $user + $system, $kilobytes / 1000 }"
}

# score MODEL: 1 - NCC and SSIM on the photos held out.
score() {
  "$gpvc" evaluate "$1/model.obj" "$scene" "${from[@]:0:$((${#from[@]} - 2))}" --mesh "$mesh" -o "$1-scores" --force -q >"$out/evaluate.log" 2>&1 ||
    fail "gpvc evaluate $1 failed: $(tail -1 "$out/evaluate.log")"
  awk -F'[:,]' '/"mean"/ { mean = 1 } /}/ { mean = 0 } mean { gsub(/[ "]/, "", $1); value[$1] = $2 + 0 }
    END { printf "%.5f %.5f", value["one_minus_ncc"], value["ssim"] }' "$1-scores/evaluate.json"
}

# put_together JOB: the OBJ files of its tiles as one.
put_together() {
  local to=$1-model obj tiles=()
  rm -rf "$to"
  mkdir "$to"
  mapfile -t tiles < <(ls "$1/result/obj" | sort -n)
  for tile in "${tiles[@]}"; do
    obj=$1/result/obj/$tile
    sed "s/^newmtl /&t${tile}_/; s/^map_Kd /&t${tile}_/" "$obj/model.mtl" >>"$to/model.mtl"
    for page in "$obj"/model_*; do ln -s "$page" "$to/t${tile}_$(basename "$page")"; done
  done
  for tile in "${tiles[@]}"; do echo "# tile $tile"; cat "$1/result/obj/$tile/model.obj"; done | awk '
    BEGIN { print "mtllib model.mtl" }
    /^# tile / { tile = $3; v0 += v; t0 += t; v = t = 0 }
    /^v / { ++v; print }
    /^vt / { ++t; print }
    /^usemtl / { print "usemtl t" tile "_" $2 }
    /^f / {
      line = "f"
      for (i = 2; i <= NF; ++i) { split($i, at, "/"); line = line " " (at[1] + v0) (at[2] == "" ? "" : "/" (at[2] + t0)) }
      print line
    }' >"$to/model.obj"
  cp "$1/views.json" "$to/"
  # One for all tiles of a job.
  if [ -f "$1/result/obj/${tiles[0]}/offset.txt" ]; then cp "$1/result/obj/${tiles[0]}/offset.txt" "$to/"; fi
}

# --- runs -----------------------------------------------------------------------------------------------------------

compared=$out/compared.txt
: >"$compared"
if [ -n "$whole" ]; then
  read -r wall cpu peak < <(measured "$out/whole.log" "$gpvc" texture "$scene" "$mesh" "${from[@]}" --no-resume --force -o "$out/whole"; echo)
  counts=$out/whole/run.json
  echo "undivided 1 $(figure "$counts" full) $(figure "$counts" partial) $(figure "$counts" energy) $(figure "$counts" differing_pairs) -" \
    "$(figure "$counts" seam_step_after) $(score "$out/whole") $wall $cpu $peak" >>"$compared"
fi
for size in "${sizes[@]}"; do
  job=$out/$size
  read -r wall cpu peak < <(measured "$out/$size.log" "$gpvc" tiles "$scene" "$mesh" "${from[@]}" "${levels[@]}" "${memory[@]}" --tile-faces "$size" --force -o "$job"; echo)
  # Units of an earlier benchmark would be complete.
  rm -rf "$job/units" "$job/result"
  echo "$size,gpvc tiles,tiles,,$cpu,$wall,,$peak" >>"$out/units.csv"
  awk -F'"' '/"name":/ { name = $4 } /"stage":/ { stage = $4 } /"memory_mb":/ { memory = $3 } /"seconds":/ { gsub(/[^0-9.]/, "", $3); gsub(/[^0-9]/, "", memory); print name, stage, $3, memory }' \
    "$job/plan.json" >"$out/$size.units"
  while read -r unit stage seconds megabytes; do
    read -r wall cpu peak < <(measured "$out/$size.log" "$gpvc" unit "$job" "$unit" "${memory[@]}"; echo)
    echo "$size,$unit,$stage,$seconds,$cpu,$wall,$megabytes,$peak" >>"$out/units.csv"
  done <"$out/$size.units"
  scores="- -"
  if [ -n "$whole" ]; then
    put_together "$job"
    scores=$(score "$job-model")
  fi
  finished=$job/units/finish/done.json
  echo "$size $(ls "$job/result/obj" | wc -l) $(figure "$finished" see.full) $(figure "$finished" see.partial) $(figure "$finished" expose.energy)" \
    "$(figure "$finished" expose.seams) $(figure "$finished" expose.seams_across) $(figure "$finished" seam_step_after) $scores" \
    "$(awk -F, -v size="$size" '$1 == size { wall += $6; cpu += $5; if ($8 > peak) peak = $8 } END { print wall, cpu, peak }' "$out/units.csv")" >>"$compared"
done

# --- the tables -----------------------------------------------------------------------------------------------------

report() {
  printf '# Tiles\n\n%s on %s, %s processors; %s\n\n' "$("$gpvc" --version)" "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)" "$(nproc)" "$mesh"
  echo "| faces of a tile | tiles | seen whole | in parts | energy | seams | across borders | seam step | 1 - NCC | SSIM | wall, s | CPU, s | peak, MB |"
  echo "|---|---|---|---|---|---|---|---|---|---|---|---|---|"
  awk '
    function whole(text) { return text == "-" ? text : sprintf("%.0f", text) }
    {
      printf "| %s | %s | %s | %s | %s | %s | %s | %.3f | %s | %s | %.1f | %.1f | %s |\n", $1, $2, whole($3), whole($4), whole($5), \
        whole($6), whole($7), $8, $9, $10, $11, $12, whole($13)
    }' "$compared"
  for size in "${sizes[@]}"; do
    printf '\nTiles of %s faces at most. The plan and what was measured:\n\n' "$size"
    echo "| stage | units | CPU planned, s | CPU, s | wall, s | largest unit planned, MB | largest unit, MB |"
    echo "|---|---|---|---|---|---|---|"
    awk -F, -v size="$size" '
      function row(name, n, planned, cpu, wall, memory, peak) {
        printf "| %s | %d | %s | %.0f | %.0f | %s | %.0f |\n", name, n, (planned ? sprintf("%.0f", planned) : "-"), cpu, wall, \
          (memory ? memory : "-"), peak
      }
      $1 == size {
        if (!($3 in count)) order[++stages] = $3
        ++count[$3]; planned[$3] += $4; cpu[$3] += $5; wall[$3] += $6
        if ($7 > memory[$3]) memory[$3] = $7
        if ($8 > peak[$3]) peak[$3] = $8
      }
      END {
        for (s = 1; s <= stages; ++s) {
          at = order[s]
          row(at, count[at], planned[at], cpu[at], wall[at], memory[at], peak[at])
          n += count[at]; p += planned[at]; c += cpu[at]; w += wall[at]
          if (memory[at] > m) m = memory[at]
          if (peak[at] > k) k = peak[at]
        }
        row("all", n, p, c, w, m, k)
      }' "$out/units.csv"
    # Seconds of single units are rounded up; hours of all are not.
    printf '\nOn disk %s; the plan said: %s\n' "$(du -sh "$out/$size" | cut -f1)" \
      "$("$gpvc" plan "$out/$size" | awk '/^all / { printf "%s %s, %.0f s of CPU", $(NF - 3), $(NF - 2), 3600 * $(NF - 4) }')"
  done
}
report | tee "$out/tiles.md"
rm -f "$out/time.txt" "$out/evaluate.log" "$compared" "$out"/*.units
