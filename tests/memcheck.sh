#!/usr/bin/env bash
# memcheck.sh: each command under valgrind on a small scene, which it makes. Ends with 1 if a command writes bytes that nobody
# has set, to a file or to the console: such files differ from run to run. What the libraries beneath read and compare is not looked
# at. Some minutes.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
gpvc=${GPVC:-$root/build/release/app/gpvc}
[ -x "$gpvc" ] || { echo "memcheck.sh: $gpvc is not built: run tests/run.sh or app/quickstart.sh first" >&2; exit 2; }
command -v valgrind >/dev/null || { echo "memcheck.sh: valgrind is missing" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
failures=0
run() { # NAME COMMAND OPTION...
  local name=$1 log=$work/$1.log status=0 found
  shift
  valgrind --log-file="$log" --fair-sched=yes "$gpvc" "$@" --quiet >/dev/null 2>"$work/err" || status=$?
  found=$(grep -c 'Syscall param \(p\?write\|pwrite64\|writev\)(.*) points to uninitialised' "$log" || true)
  printf '%-12s exit status %s, %s writes of bytes that nobody has set\n' "$name" "$status" "$found"
  if [ "$status" != 0 ] || [ "$found" != 0 ]; then
    failures=$((failures + 1))
    head -c 2000 "$work/err" >&2
    grep -A 12 'points to uninitialised' "$log" | head -n 40 >&2 || true
  fi
}

scene=$work/city
"$gpvc" synth city -o "$scene" --faces 1000 --size 40 --photos 4 --photo-size 120x80 --quiet >/dev/null
input=("$scene/colmap" "$scene/mesh.ply" --images "$scene/images")
# Software drawing of OpenGL compiles code that valgrind cannot follow.
draw=(--drawing native --threads 2)
echo '{"rules": [{"box": [[-100, -100, -100], [0, 100, 100]], "forbid": "*1.jpg"}]}' >"$work/rules.json"

run synth synth city -o "$work/synth" --faces 1000 --size 40 --photos 3 --photo-size 60x40
run texture texture "${input[@]}" "${draw[@]}" -o "$work/texture" --editable --resume always --texture png --keep-odd-photos --allow-misfit
run from texture "${input[@]}" "${draw[@]}" -o "$work/from" --from "$work/texture" --allow "$work/rules.json" --texture png --keep-odd-photos --allow-misfit
run tileset tileset "${input[@]}" "${draw[@]}" -o "$work/tileset" --compress --resume always --keep-odd-photos --allow-misfit
run ortho ortho --from "$work/texture" -o "$work/ortho" --threads 2
run tiles tiles "${input[@]}" --drawing native -o "$work/job" --tile-faces 300 --keep-odd-photos --allow-misfit
run unit unit "$work/job" --all --threads 2
run plan plan "$work/job"
run visibility visibility "${input[@]}" "${draw[@]}" -o "$work/visibility"
run evaluate evaluate "$work/texture/model.obj" "$scene/colmap" --images "$scene/images" -o "$work/evaluate"
run inspect inspect "${input[@]}" --check
run convert convert "$scene/colmap" --images "$scene/images" -o "$work/convert" --format opensfm

[ "$failures" = 0 ] || { echo "memcheck.sh: $failures commands failed" >&2; exit 1; }
