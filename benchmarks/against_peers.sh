#!/usr/bin/env bash
# against_peers.sh [OPTION]... SCENE MESH -o DIR   gpvc beside other programs that texture meshes, on the same scene
#
#   --runs N           runs of every program [3]
#   --hold-out K|LIST  photos that are kept from every program and then judge the results: every K-th, or names or globs
#                      separated by commas [6]
#   --images DIR       folder of the photos [where the scene says, or 'images' beside it]
#   --gpvc FILE        the gpvc to run [build/release/app/gpvc, which is built first]
#
# Beside gpvc run texrecon (mvs-texturing), TextureMesh (OpenMVS) and colmap mesh_texturer (COLMAP), as far as they are
# on PATH. MESH is a PLY file, as texrecon and COLMAP read no other. Each program textures with its default options; the
# exceptions are named below the table. The programs run in turns, so that a slow minute of the machine meets them all,
# and their results are scored by gpvc evaluate. The undistorted photos that the others need are written by gpvc convert
# beforehand, and neither this nor the scoring counts as their time.
#
# DIR/peers.md is the table that is printed: medians, and the median ratio to gpvc's run of the same turn. DIR/runs.csv
# has the figures of every run; DIR also keeps the last model of each program, its log and its scores view by view.
set -euo pipefail
export LC_ALL=C
source "$(dirname "${BASH_SOURCE[0]}")/common.sh"

runs=3
hold_out=6
images=
gpvc=
o=
read_arguments "runs hold-out images gpvc o" "$@"
[ ${#places[@]} = 2 ] || usage "expected SCENE and MESH, got ${#places[@]} arguments"
[ -n "$o" ] || usage "-o DIR is missing"
out=$o
[[ $runs =~ ^[1-9][0-9]?$ ]] || usage "--runs takes a number from 1 to 99, got '$runs'"
[ -e "${places[0]}" ] || fail "the scene ${places[0]} does not exist"
[ -f "${places[1]}" ] || fail "the mesh ${places[1]} does not exist"
# TextureMesh works in another folder, so that paths need to be absolute.
scene=$(realpath "${places[0]}")
mesh=$(realpath "${places[1]}")
[ "$(head -c 3 "$mesh")" = ply ] || fail "$mesh is no PLY file, and texrecon and COLMAP read no other meshes"
from=()
if [ -n "$images" ]; then
  [ -d "$images" ] || fail "the folder of photos $images does not exist"
  from=(--images "$(realpath "$images")")
fi

find_gpvc
gnu_time=$(type -P time) || fail "GNU time, which measures the programs, is missing; it is Debian's package 'time'"

mkdir -p "$out"
out=$(cd "$out" && pwd)
[ -f "$out/runs.csv" ] || [ -z "$(ls "$out")" ] || fail "$out holds other files; give another folder, or empty that one"
rm -rf "$out"/{inputs,gpvc,texrecon,TextureMesh,mesh_texturer,peers.md,runs.csv}
echo "turn,program,outcome,wall_s,cpu_s,peak_bytes,patches,pages,completeness,psnr_db,ssim,one_minus_ncc" >"$out/runs.csv"

# --- what runs, and on what -----------------------------------------------------------------------------------------

programs=(gpvc)
missing=()
has_mesh_texturer() { colmap help 2>/dev/null | grep -q mesh_texturer; }
for peer in texrecon TextureMesh; do
  if type -P $peer >/dev/null; then programs+=("$peer"); else missing+=("$peer"); fi
done
if has_mesh_texturer; then programs+=(mesh_texturer)
elif type -P colmap >/dev/null; then missing+=("mesh_texturer (the colmap on PATH has none)")
else missing+=(mesh_texturer); fi

echo "== inputs"
inputs=$out/inputs
mkdir "$inputs"
# A small texture resolves --hold-out to names: views.json has a view's name before the line that says it is held out.
"$gpvc" texture "$scene" "$mesh" "${from[@]}" --hold-out "$hold_out" --downscale 16 -o "$inputs/small" -q >/dev/null
awk -F'"' '/^   "name": / { name = $4 } /^   "held_out": true/ { print name }' "$inputs/small/views.json" >"$inputs/held_out.txt"
rm -r "$inputs/small"
[ -s "$inputs/held_out.txt" ] || fail "views.json of $gpvc names no view that is held out"

# input FORMAT: the scene without the held-out photos, undistorted, as FORMAT.
input() { "$gpvc" convert "$scene" "${from[@]}" --exclude-views "@$inputs/held_out.txt" --undistort --format "$1" -o "$inputs/$1" -q >/dev/null; }
for program in "${programs[@]}"; do
  case $program in
    texrecon) input cam ;;
    TextureMesh) input mvs ;;
    mesh_texturer) input colmap ;;
  esac
done

# TextureMesh sharpens the texture by default, which every score punishes, and lowers its own priority. Its version 2.3
# crashes when it writes an OBJ with one page, so that it writes a GLB, which takes as long as its default, a PLY.
texture_mesh=(--sharpness-weight 0 --process-priority 0)
masks_left_out=no
if [ -n "$(find "$inputs" -name '*.mask.png' -print -quit)" ]; then
  texture_mesh+=(--ignore-mask-label 0)
  masks_left_out=yes
fi

# The command of a program, into `command`; it writes its model into the folder DIR/PROGRAM.
set_command() {
  local to=$out/$1
  case $1 in
    gpvc) command=("$gpvc" texture "$scene" "$mesh" "${from[@]}" --exclude-views "@$inputs/held_out.txt" -o "$to/model") ;;
    texrecon) command=(texrecon "$inputs/cam" "$mesh" "$to/model/model") ;;
    TextureMesh) command=(TextureMesh -w "$inputs/mvs" -i scene.mvs -m "$mesh" -o "$to/model/model.mvs" --export-type glb "${texture_mesh[@]}") ;;
    mesh_texturer) command=(colmap mesh_texturer --workspace_path "$inputs/colmap" --input_path "$mesh" --output_path "$to/model" --output_type TXT) ;;
  esac
}

# --- one run --------------------------------------------------------------------------------------------------------

# COLMAP's textured PLY (text, texture coordinates per corner) as an OBJ. Faces without a view have zeros alone.
obj_of_ply() {
  awk '
    /^element / { count[$2] = $3 }
    !body { if ($1 == "end_header") body = 1; next }
    vertices < count["vertex"] { ++vertices; print "v", $1, $2, $3; if (vertices == count["vertex"]) print "mtllib model.mtl\nusemtl page"; next }
    !($6 || $7 || $8 || $9 || $10 || $11) { print "f", $2 + 1, $3 + 1, $4 + 1; next }
    { printf "vt %s %s\nvt %s %s\nvt %s %s\nf %d/-3 %d/-2 %d/-1\n", $6, $7, $8, $9, $10, $11, $2 + 1, $3 + 1, $4 + 1 }' \
    "$1/mesh.ply" >"$1/model.obj" &&
    printf 'newmtl page\nmap_Kd texture.png\n' >"$1/model.mtl"
}

# patches PROGRAM: how many connected areas from one photo the program says it made; nothing where it does not say.
patches() {
  local log=$out/$1/log.txt
  case $1 in
    gpvc) sed -n 's/^ *"patches": \([0-9]*\),*$/\1/p' "$out/gpvc/model/run.json" ;;
    texrecon) sed -n 's/^[[:space:]]*\([0-9]*\) texture patches\.$/\1/p' "$log" ;;
    TextureMesh) sed -n 's/.*atlas and image completed: \([0-9]*\) patches.*/\1/p' "$log" ;;
    mesh_texturer) sed -n 's/.*Found \([0-9]*\) regions.*/\1/p' "$log" ;;
  esac | tail -1
}

# pages PROGRAM: how many images the texture is made of.
pages() {
  local model=$out/$1/model
  case $1 in
    gpvc) sed -n 's/^ *"pages": \([0-9]*\),*$/\1/p' "$model/run.json" ;;
    texrecon | mesh_texturer) sed -n 's/^map_Kd //p' "$model/model.mtl" | sort -u | wc -l ;;
    TextureMesh) find "$model" -name 'model_*.*' | wc -l ;;
  esac
}

declare -A failed_turns=() reasons=()
# failure PROGRAM TURN REASON: what the report says of a run that failed or was not scored.
failure() { failed_turns[$1]+=${failed_turns[$1]:+, }$2; reasons[$1]=$3; }

# run TURN PROGRAM: measures and scores one run, and adds its row to runs.csv.
run() {
  local to=$out/$2 model=$out/$2/model/model.obj command status=0 wall user system kilobytes outcome=complete
  rm -rf "$to"
  mkdir -p "$to/model"
  set_command "$2"
  case $2 in TextureMesh | gpvc) model=$to/model/model.glb ;; esac
  # gpvc makes its folder itself.
  [ "$2" != gpvc ] || rmdir "$to/model"
  "$gnu_time" -f '%e %U %S %M' -o "$to/time.txt" "${command[@]}" >"$to/log.txt" 2>&1 || status=$?
  rm -f "$inputs"/mvs/TextureMesh-*.log
  if [ $status = 0 ] && [ "$2" = mesh_texturer ]; then obj_of_ply "$to/model" || status=$?; fi
  if [ $status != 0 ] || [ ! -s "$model" ]; then
    failure "$2" "$1" "failed with exit status $status; the last line of its output: $(said_last "$to/log.txt")"
    echo "$1,$2,failed,,,,,,,,," >>"$out/runs.csv"
    echo "turn $1 of $runs: $2 failed"
    return 0
  fi
  read -r wall user system kilobytes < <(tail -1 "$to/time.txt")
  local scores=,,,
  if "$gpvc" evaluate "$model" "$scene" "${from[@]}" --mesh "$mesh" --views "@$inputs/held_out.txt" -o "$to/scores" -q >"$to/scores.txt" 2>&1; then
    # The figures of "mean", in the CSV's order.
    scores=$(awk -F'[:,]' '
      /"mean"/ { mean = 1 } /}/ { mean = 0 }
      mean { gsub(/[ "]/, "", $1); value[$1] = $2 + 0 }
      END { printf "%.6f,%.4f,%.6f,%.6f", value["completeness"], value["psnr_db"], value["ssim"], value["one_minus_ncc"] }' "$to/scores/evaluate.json")
  else
    outcome="not scored"
    failure "$2" "$1" "was not scored; gpvc evaluate said: $(said_last "$to/scores.txt")"
  fi
  awk -v row="$1,$2,$outcome,$wall" -v user="$user" -v kernel="$system" -v kilobytes="$kilobytes" \
    -v patches="$(patches "$2")" -v pages="$(pages "$2")" -v scores="$scores" \
    'BEGIN { printf "%s,%.2f,%.0f,%s,%s,%s\n", row, user + kernel, kilobytes * 1024, patches, pages, scores }' >>"$out/runs.csv"
  echo "turn $1 of $runs: $2 $wall s"
}

echo "== runs of ${programs[*]}"
for ((turn = 1; turn <= runs; ++turn)); do
  for program in "${programs[@]}"; do run "$turn" "$program"; done
done

# --- what is said of it ---------------------------------------------------------------------------------------------

# Medians of the runs that have a figure, each with its ratio to gpvc: the median over the turns in which both have it.
table() {
  awk -F, -v programs="${programs[*]}" '
    function median(values, n,   i, j, v) {
      for (i = 2; i <= n; ++i) { v = values[i]; for (j = i - 1; j > 0 && values[j] > v; --j) values[j + 1] = values[j]; values[j + 1] = v }
      return (values[int((n + 1) / 2)] + values[int(n / 2) + 1]) / 2
    }
    # PSNR is a logarithm already: its ratio is a difference.
    function cell(program, name, scale, format,   t, n, m, values, ratios, text) {
      for (t = 1; t <= turns; ++t) {
        if (figure[t, program, name] == "") continue
        values[++n] = figure[t, program, name]
        if (program != "gpvc" && figure[t, "gpvc", name] != "" && (name == "psnr_db" || figure[t, "gpvc", name] != 0))
          ratios[++m] = name == "psnr_db" ? values[n] - figure[t, "gpvc", name] : values[n] / figure[t, "gpvc", name]
      }
      if (!n) return name == "wall_s" ? " failed" : " —"
      text = sprintf(" " format, median(values, n) / scale)
      return m ? text sprintf(name == "psnr_db" ? " (%+.2f dB)" : " (%.2fx)", median(ratios, m)) : text
    }
    NR == 1 { for (i = 4; i <= NF; ++i) name_of[i] = $i; next }
    { turns = $1; for (i = 4; i <= NF; ++i) figure[$1, $2, name_of[i]] = $i }
    END {
      print "| program | wall | CPU | peak memory | patches | pages | completeness | PSNR | SSIM | 1 - NCC |"
      print "|---|---|---|---|---|---|---|---|---|---|"
      for (p = 1; p <= split(programs, list, " "); ++p)
        print "| " list[p] " |" cell(list[p], "wall_s", 1, "%.1f s") " |" cell(list[p], "cpu_s", 1, "%.1f s") " |" \
          cell(list[p], "peak_bytes", 1e9, "%.2f GB") " |" cell(list[p], "patches", 1, "%.0f") " |" \
          cell(list[p], "pages", 1, "%.0f") " |" cell(list[p], "completeness", 0.01, "%.2f %%") " |" \
          cell(list[p], "psnr_db", 1, "%.2f dB") " |" cell(list[p], "ssim", 1, "%.4f") " |" cell(list[p], "one_minus_ncc", 1, "%.4f") " |"
    }' "$out/runs.csv"
}

report() {
  local program plural=s
  [ "$runs" != 1 ] || plural=
  printf '# gpvc beside other programs\n\n'
  printf '%s on %s, %s processors. Scene %s, mesh %s; scored on the photos left out: %s.\n\n' "$("$gpvc" --version)" \
    "$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -1)" "$(nproc)" "$scene" "$mesh" "$(paste -sd' ' "$inputs/held_out.txt")"
  table
  printf '\n- Medians over %s turn%s; in brackets the median ratio to gpvc in the same turn, for PSNR the difference.\n' "$runs" "$plural"
  printf '  Higher is better for completeness, PSNR and SSIM, lower for the others.\n'
  printf -- '- CPU is user and system time. gpvc undistorts the photos within its time; the others got undistorted ones.\n'
  printf -- '- Patches are those that a program says it made; a dash stands where it does not say.\n'
  case " ${programs[*]} " in *' TextureMesh '*) printf -- '- TextureMesh ran with %s, with which it scores better than by default.\n' "${texture_mesh[*]}" ;; esac
  [ $masks_left_out = no ] || printf -- '- The photos have masks, which texrecon and COLMAP do not read.\n'
  for program in "${!failed_turns[@]}"; do
    printf -- '- %s, turn %s: %s\n' "$program" "${failed_turns[$program]}" "${reasons[$program]}"
  done
  [ ${#missing[@]} = 0 ] || printf -- '- Not on PATH, and so not run: %s.\n' "$(printf '%s, ' "${missing[@]}" | sed 's/, $//')"
}
echo
report | tee "$out/peers.md"
grep -q ',gpvc,complete,' "$out/runs.csv" || fail "gpvc has no complete run; see $out/gpvc"
