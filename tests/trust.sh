#!/usr/bin/env bash
# trust.sh [--quick] [--seed N]: what runs trust. Commands are killed and given again; files of jobs, checkpoints and editable
# results are damaged; inputs are replaced or touched between any two steps, and within them. A run that says it has
# succeeded must have left the bytes of a run that nothing disturbed. Prints a table; ends with 1 if anything wrong went through.
#   --quick    a few kills, damages and replacements of each kind; all of them are part of .ci/nightly
#   --seed N   other moments and places [1]
set -euo pipefail
export LC_ALL=C
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
program=${GPVC:-$root/build/release/app/gpvc}
kills=15 damages=12 moments=4 seed=1
while [ $# -gt 0 ]; do
  case $1 in
    --quick) kills=1 damages=2 moments=1 ;;
    --seed) seed=${2:-1}; shift ;;
    *) echo "trust.sh: there is no option '$1'" >&2; exit 2 ;;
  esac
  shift
done
[ -x "$program" ] || { echo "trust.sh: $program is not built: run tests/run.sh or app/quickstart.sh first" >&2; exit 2; }
RANDOM=$seed
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
g++ -O1 -std=c++20 -o damage "$root/tests/support/damage.cpp"
g++ -O1 -fPIC -shared -o kill.so "$root/tests/support/kill_at_rename.cpp"

failures=0
fail() {
  failures=$((failures + 1))
  echo "trust.sh: $*" >&2
}
row() { printf '%-38s %6s %6s %8s   %s\n' "$@"; }
now() { date +%s.%N; }
since() { awk "BEGIN { print $(now) - $1 }"; }
moment_of() { awk "BEGIN { printf \"%.3f\", 0.02 + 0.98 * $1 * $RANDOM / 32768 }"; }
# Lines about files that differ. Times are told by run.json and by pages for readers, and kept by files of units; what counts of
# a job is its result.
differences() { diff -rq -x run.json -x '*.html' -x '*.md' -x evaluate.json -x report.json -x '.*' "$1" "$2" 2>&1; }
is_same() { [ -z "$(differences "$1" "$2")" ]; }

# Judges a run that was disturbed: verdict is same, refused or wrong.
judge() { # STATUS OUT WHAT WHOLE...
  local status=$1 out=$2 what=$3 whole
  shift 3
  verdict=wrong
  if [ "$status" = 0 ]; then
    for whole in "$@"; do
      if [ -d "$whole" ] && is_same "$whole" "$out"; then verdict=same; fi
    done
    [ "$verdict" = same ] || fail "$what: exit status 0 with other bytes: $(differences "$1" "$out" | head -n 2 | tr '\n' ';')"
  elif [ "$status" = 1 ] && [ "$(grep -c '^gpvc: error: ' log)" = 1 ] && [ "$(wc -c <log)" -lt 3000 ] &&
    ! grep -qE '\[json|std::|bad_alloc|terminate' log; then
    verdict=refused
  else
    fail "$what: exit status $status without one sentence that tells why: $(tail -c 300 log)"
  fi
}
count() { # counts the verdict
  tried=$((tried + 1))
  case $verdict in
    same) same=$((same + 1)) ;;
    refused) refused=$((refused + 1)) ;;
  esac
}
start_row() { tried=0 same=0 refused=0; }

# --- a small city, and what is done with it
gpvc() { timeout 120 "$program" "$@" --quiet >/dev/null 2>log; }
size=(--faces 6000 --photos 8 --photo-size 480x320)
"$program" synth city -o scene "${size[@]}" --quiet >/dev/null
mapfile -t photos < <(cd scene/images && ls)
# Bytes after a JPEG's end are no part of its picture: with them all photos have one size, which tells nothing.
truncate -s "$(stat -c %s scene/images/* | sort -n | tail -n 1)" scene/images/*
cp -r scene before
printf 'box,-1e9 -1e9 -1e9 1e9 1e9 1e9,forbid,%s\n' "${photos[1]}" >rules.csv
input=(scene/colmap scene/mesh.ply --images scene/images)

texture() { gpvc texture "${input[@]}" --page-size 1024 --editable --resume always -o "$1"; }
change() { gpvc texture "${input[@]}" --page-size 1024 --from "$1" --allow rules.csv --resume always -o "$2"; }
change_whole() { change whole_texture "$1"; }
tileset() { gpvc tileset "${input[@]}" --tile-faces 2500 --resume always -o "$1"; }
tiles() { gpvc tiles "${input[@]}" --tile-faces 2500 -o "$1"; }
# What counts of a job is its result.
units() {
  local status=0
  gpvc unit "$1" --all || status=$?
  rm -rf "$1_result"
  [ "$status" != 0 ] || cp -r "$1/result" "$1_result"
  return "$status"
}
job() {
  # A killed run had begun to publish the job, and this one finishes that, where it is told that there is a result.
  [ -e "$1/job.json" ] || tiles "$1" || grep -q 'already holds a result' log || return
  units "$1"
}
evaluate() { gpvc evaluate whole_texture/model.obj scene/colmap --images scene/images -o "$1"; }
compare() { gpvc compare "${input[@]}" --modes gpvc,none -o "$1"; }
synth() { gpvc synth city "${size[@]}" -o "$1"; }
convert() { gpvc convert scene/colmap --images scene/images -o "$1"; }
# Where COMMAND leaves what counts, if it is told OUT.
result_of() { # COMMAND OUT
  case $1 in job) echo "$2_result" ;; *) echo "$2" ;; esac
}
clean() { rm -rf out out_result; }

for command in texture change_whole tileset job evaluate compare synth; do
  start=$(now)
  $command "whole_$command" || fail "$command, undisturbed: $(cat log)"
  declare "seconds_$command=$(since "$start")"
done
clean
texture out
is_same whole_texture out || fail "two undisturbed runs differ: $(differences whole_texture out)"
row "" tried same refused ""

# --- killed, and the same command again
for command in texture change_whole tileset job evaluate compare synth; do
  whole=$(result_of $command whole_$command) seconds=seconds_$command
  start_row
  for ((i = 0; i < kills; ++i)); do
    clean
    at=$(moment_of "${!seconds}")
    # The shell tells of processes that are killed.
    { $command out & } 2>/dev/null
    sleep "$at"
    pkill -KILL -f "^$program .* -o out( |\$)|^$program unit out " 2>/dev/null || true
    wait $! 2>/dev/null || true
    status=0
    $command out || status=$?
    # It had been quicker than the kill, and no result is replaced unasked.
    if [ "$status" = 1 ] && grep -q 'already holds a result' log; then status=0; fi
    judge "$status" "$(result_of $command out)" "$command, killed after $at s" "$whole"
    [ "$verdict" != refused ] || fail "$command, killed after $at s: it cannot be given again: $(cat log)"
    count
  done
  row "$command, killed" "$tried" "$same" "$refused" ""
done

# --- stored files that are damaged
# A texture with all of its checkpoint, killed before it is published.
clean
{ LD_PRELOAD=$work/kill.so KILL_AT_RENAME=0 texture cut; } 2>/dev/null || true
[ -d cut/.work ] || fail "a killed run left no checkpoint"
rm -rf half
cp -r whole_job half
rm -rf half/result half/units/bake-* half/units/finish

damaged() { # NAME COMMAND FROM FILES: FROM is copied to out, and one of FILES there is damaged
  local name=$1 command=$2 from=$3 files=$4 kind all file what status whole result
  case $command in
    change_out) whole=whole_change_whole result=changed ;;
    *) whole=$(result_of "$command" "whole_$command") result=$(result_of "$command" out) ;;
  esac
  for kind in bytes hash cut; do
    start_row
    for ((i = 0; i < damages; ++i)); do
      clean
      rm -rf changed
      cp -r "$from" out
      mapfile -t all < <(eval "find $files -type f -size +0 ! -name '*lock*'" | sort)
      file=${all[$((RANDOM % ${#all[@]}))]}
      what=$(./damage "$file" $((seed * 1000 + tried)) $kind)
      status=0
      $command out || status=$?
      judge "$status" "$result" "$name, $what" "$whole"
      count
    done
    row "$name, $kind" "$tried" "$same" "$refused" ""
  done
}
change_out() { change "$1" changed; }
damaged "checkpoint damaged" texture cut out/.work
damaged "editable result damaged" change_out whole_texture "out/edit-* out/model_*.jpg"
damaged "finished job damaged" job whole_job out
damaged "unfinished job damaged" job half out

# --- inputs that are replaced, or touched
restore() {
  rm -rf scene
  cp -r --preserve=timestamps before scene
}
# Other bytes in the same file; its size and time of modification are as before.
put() { # NEW FILE
  touch -r "$2" time
  cat "$1" >"$2"
  touch -r time "$2"
}
replace() { # KIND
  case $1 in
    photo) put "before/images/${photos[2]}" "scene/images/${photos[3]}" ;;
    touched) touch scene/images/* scene/colmap/* scene/mesh.ply ;;
    mesh)
      # The height of one vertex in a thousand of its own.
      cp scene/mesh.ply new
      dd if=/dev/zero of=new bs=1 count=1 conv=notrunc seek=$(($(grep -abo end_header new | head -n 1 | cut -d: -f1) + 11 + 12 * 100 + 9)) 2>/dev/null
      put new scene/mesh.ply ;;
    cameras)
      sed 's/ 400 400 / 402 400 /' before/colmap/cameras.txt >new
      put new scene/colmap/cameras.txt ;;
    mask) cp "before/images/${photos[5]}" "scene/images/${photos[4]}.mask.jpg" ;;
    shorter) truncate -s 9000 "scene/images/${photos[6]}" ;;
  esac
}
kinds=(photo touched shorter mesh cameras mask)
for kind in "${kinds[@]}"; do
  restore
  replace "$kind"
  for command in texture tileset job; do
    $command "new_${kind}_$command" || true
    new=$(result_of $command "new_${kind}_$command")
    [ "$kind" = touched ] || [ ! -d "$new" ] || ! is_same "$new" "$(result_of $command whole_$command)" || fail "$command: another ${kind} changes nothing"
  done
  change "new_${kind}_texture" "new_${kind}_change_whole" || true
done

replaced() { # NAME COMMAND BEFORE: runs BEFORE, replaces, runs COMMAND
  local name=$1 command=$2 first=$3 kind status
  start_row
  for kind in "${kinds[@]}"; do
    restore
    clean
    rm -rf changed
    $first
    replace "$kind"
    status=0
    $command out || status=$?
    if [ "$command" = change_out ]; then
      judge "$status" changed "$name: $kind" whole_change_whole "new_${kind}_change_whole"
    else
      judge "$status" "$(result_of "$command" out)" "$name: $kind" "$(result_of "$command" "whole_$command")" "$(result_of "$command" "new_${kind}_$command")"
    fi
    if [ "$kind" = touched ] && [ "$verdict" = refused ]; then fail "$name: files that were only touched are refused: $(cat log)"; fi
    count
  done
  row "$name" "$tried" "$same" "$refused" ""
}
replaced "replaced: tiles, then units" job "tiles out"
first_unit() { tiles out && gpvc unit out see-0-0; }
replaced "replaced: see unit, then the others" job first_unit
half_job() { cp -r half out; }
replaced "replaced: half a job, then the rest" job half_job
done_job() { cp -r whole_job out; }
replaced "replaced: job, then the job again" job done_job
cut_run() { cp -r cut out; }
replaced "replaced: killed texture, then again" texture cut_run
editable() { cp -r whole_texture out; }
replaced "replaced: texture, then --from" change_out editable

# Within a run: it is stopped for as long as the replacement takes.
for command in texture tileset job; do
  seconds=seconds_$command
  start_row
  for kind in "${kinds[@]}"; do
    for ((i = 0; i < moments; ++i)); do
      restore
      clean
      [ $command != job ] || tiles out
      at=$(moment_of "${!seconds}")
      status=0
      $command out &
      sleep "$at"
      pkill -STOP -f "^$program .* -o out( |\$)|^$program unit out " || true
      replace "$kind"
      pkill -CONT -f "^$program .* -o out( |\$)|^$program unit out " || true
      wait $! || status=$?
      judge "$status" "$(result_of $command out)" "$command, $kind replaced after $at s" "$(result_of $command whole_$command)" \
        "$(result_of $command "new_${kind}_$command")"
      if [ "$kind" = touched ] && [ "$verdict" = refused ]; then fail "$command: files that were touched after $at s are refused: $(cat log)"; fi
      count
    done
  done
  row "$command, replaced within" "$tried" "$same" "$refused" ""
done

if [ "$failures" -gt 0 ]; then
  echo "trust.sh: $failures failures" >&2
  exit 1
fi
echo "nothing wrong went through"
