#!/usr/bin/env bash
# faults.sh [--quick] [SCENE MESH OPTION...]: runs of `gpvc texture` and of jobs that are killed, interrupted, short of disk or memory,
# or beside another run, and what is left of their results. Without a scene it makes a small city. Prints a table; ends
# with 1 if any byte was lost. OPTION goes to gpvc texture. --quick: each fault, but kills at few moments; the whole is part of .ci/nightly.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)
gpvc=${GPVC:-$root/build/release/app/gpvc}
kills=50 terms=20
if [ "${1:-}" = --quick ]; then
  shift
  kills=1 terms=1
fi
[ -x "$gpvc" ] || { echo "faults.sh: $gpvc is not built: run tests/run.sh or app/quickstart.sh first" >&2; exit 2; }

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if [ $# -eq 0 ]; then
  "$gpvc" synth city -o "$work/city" --faces 40000 --photos 10 --photo-size 900x600 --quiet >/dev/null
  set -- "$work/city/colmap" "$work/city/mesh.ply" --images "$work/city/images"
fi
input=("$@")
# More small pages, so that a run can be cut off between them.
options=(--page-size 1024 --quiet)

failures=0
seconds() { date +%s.%N; }
calc() { awk "BEGIN { printf \"%.1f\", $1 }"; }
row() { printf '%-42s %6s %9s   %s\n' "$@"; }
texture() { # OUT OPTION...
  local out=$1
  shift
  "$gpvc" texture "${input[@]}" "${options[@]}" -o "$out" "$@" >/dev/null
}
# The shell reports processes that are killed; those that we kill are no news.
quietly() { { "$@"; } >/dev/null 2>&1; }
# --foreground: else timeout kills itself along with the program and waits for nothing, so that the next run may find the lock of
# one that is still ending.
kill_after() { quietly timeout --foreground -s KILL "$@" || true; } # SECONDS COMMAND...
# Files of a result whose bytes differ; run.json tells times.
lost() { # EXPECTED OUT
  diff -rq -x run.json "$1" "$2" 2>&1 | wc -l
}
fail() {
  failures=$((failures + 1))
  echo "faults.sh: $*" >&2
}
# A failed run says why in one sentence.
expect_sentence() { # LOG WHAT
  [ "$(grep -c '^gpvc: error: ' "$1" || true)" = 1 ] || fail "$2: not one sentence but: $(head -c 300 "$1")"
}
# A run that has ended left the whole result, or a sentence and nothing else.
whole_or_refused() { # STATUS WHAT
  if [ "$1" = 0 ] && [ "$(lost "$work/whole" "$work/out")" = 0 ]; then return 0; fi
  # Where the whole does not fit, tiles may.
  if [ "$1" = 0 ] && [ -f "$work/out/tileset.json" ] && [ -f "$work/out/run.json" ] && [ ! -e "$work/out/.work" ]; then return 0; fi
  if [ "$1" = 1 ] && [ ! -e "$work/out" ]; then
    expect_sentence "$work/log" "$2"
    return 0
  fi
  fail "$2: exit status $1: $(head -c 300 "$work/log")"
  return 1
}

row fault tried survived "lost, seconds"
texture "$work/whole" --resume never
start=$(seconds)
texture "$work/again" --resume never --force
whole_s=$(calc "$(seconds) - $start")
[ "$(lost "$work/whole" "$work/again")" = 0 ] || fail "two undisturbed runs differ"

# --- killed, and the same command again
killed() { # NAME SECONDS...
  local name=$1 tried=0 survived=0 bytes=0 again_s=0 moments=""
  shift
  for moment in "$@"; do
    rm -rf "$work/out"
    kill_after "$moment" "$gpvc" texture "${input[@]}" "${options[@]}" -o "$work/out" --resume always
    start=$(seconds)
    # Where the run was quicker than the kill, its result is complete, and the next run at most clears up.
    if [ ! -f "$work/out/run.json" ]; then
      texture "$work/out" --resume always 2>"$work/log" || { cat "$work/log" >&2; }
    elif ls -A "$work/out" | grep -q '^\.'; then
      if quietly texture "$work/out" --resume always; then fail "$name: a complete result was replaced without --force"; fi
    fi
    again_s=$(calc "$(seconds) - $start")
    moments="$moments $again_s"
    tried=$((tried + 1))
    missing=$(lost "$work/whole" "$work/out") || true
    bytes=$((bytes + missing))
    [ "$missing" = 0 ] && [ ! -e "$work/out/.work" ] && survived=$((survived + 1))
  done
  [ "$survived" = "$tried" ] || fail "$name: $((tried - survived)) of $tried runs did not end in the same bytes"
  row "$name" "$tried" "$survived" "$bytes files; a whole run $whole_s s, the rest of it:$moments"
}
fractions=()
for part in 0.25 0.5 0.75 0.95; do fractions+=("$(calc "$part * $whole_s")"); done
killed "killed at 25, 50, 75, 95 %" "${fractions[@]}"
moments=()
for ((i = 0; i < kills; ++i)); do moments+=("$(calc "0.05 + $whole_s * $RANDOM / 32768")"); done
killed "killed at random moments" "${moments[@]}"

# --- killed at every change of a name while a result is replaced by another
g++ -O1 -fPIC -shared -o "$work/kill.so" "$root/tests/support/kill_at_rename.cpp"
texture "$work/earlier" --resume never --seams none
tried=0 survived=0
step=1
[ "$kills" -lt 50 ] && step=16
for ((at = 0; at < 200; at += step)); do
  rm -rf "$work/out"
  cp -r "$work/earlier" "$work/out"
  if quietly env LD_PRELOAD="$work/kill.so" KILL_AT_RENAME="$at" "$gpvc" texture "${input[@]}" "${options[@]}" \
    -o "$work/out" --resume never --force; then
    break
  fi
  tried=$((tried + 1))
  # The next run finishes what was begun, and refuses to replace a result without --force.
  if texture "$work/out" --resume never 2>"$work/log"; then fail "killed at name $at: a result was replaced without --force"; fi
  grep -q 'already holds a result' "$work/log" || fail "killed at name $at: $(cat "$work/log")"
  if [ "$(lost "$work/earlier" "$work/out")" = 0 ] || [ "$(lost "$work/whole" "$work/out")" = 0 ]; then
    survived=$((survived + 1))
  else
    fail "killed at name $at: neither the earlier result nor the new one is whole"
  fi
done
[ "$tried" -gt 0 ] || fail "no change of a name was seen"
row "killed while publishing, every ${step}th name" "$tried" "$survived" ""

# --- a job, killed between and within its units, and gone on with
make_job() { # JOB
  "$gpvc" tiles "${input[@]}" -o "$1" --tile-faces 12000 --quiet >/dev/null
}
units() { # JOB
  "$gpvc" unit "$1" --all --quiet >/dev/null
}
make_job "$work/job"
start=$(seconds)
units "$work/job"
job_s=$(calc "$(seconds) - $start")
tried=0 survived=0
for ((i = 0; i < kills; ++i)); do
  rm -rf "$work/killed"
  make_job "$work/killed"
  kill_after "$(calc "0.05 + 0.95 * $job_s * $RANDOM / 32768")" "$gpvc" unit "$work/killed" --all
  tried=$((tried + 1))
  units "$work/killed" 2>"$work/log" || cat "$work/log" >&2
  [ "$(lost "$work/job/result" "$work/killed/result")" = 0 ] && survived=$((survived + 1))
done
[ "$survived" = "$tried" ] || fail "a job killed $tried times: $((tried - survived)) did not end in the same bytes"
row "a job killed at random moments" "$tried" "$survived" "a whole run $job_s s"

# --- interrupted
tried=0 survived=0 slowest=0
for ((i = 0; i < terms; ++i)); do
  rm -rf "$work/out"
  texture "$work/out" --resume never >/dev/null 2>&1 &
  process=$!
  sleep "$(calc "0.9 * $whole_s * $RANDOM / 32768")"
  pid=$(pgrep -P "$process" -x gpvc || echo "$process")
  start=$(seconds)
  kill -TERM "$pid" 2>/dev/null || true
  status=0
  wait "$process" || status=$?
  took=$(calc "$(seconds) - $start")
  tried=$((tried + 1))
  # It may have been done just before.
  if { [ "$status" = 130 ] && [ ! -e "$work/out" ]; } || [ "$status" = 0 ] || [ "$status" = 143 ]; then survived=$((survived + 1)); fi
  slowest=$(awk "BEGIN { print ($took > $slowest ? $took : $slowest) }")
done
[ "$survived" = "$tried" ] || fail "SIGTERM: something was left, or another exit status"
row "SIGTERM at random moments" "$tried" "$survived" "slowest answer $slowest s"

# --- full disk, in a file system of its own
disk_section() {
  local disk=$work/disk needs sizes tried=0 survived=0 missing
  mkdir -p "$disk"
  needs=$(du -sk "$work/whole" | cut -f1)
  sizes=(2 10 30 50 70 90)
  for share in "${sizes[@]}"; do
    mount -t tmpfs -o "size=$((needs * share / 100))k" tmpfs "$disk"
    if texture "$disk/out" --resume always 2>"$work/log"; then fail "a disk of $share % of the result holds it"; fi
    expect_sentence "$work/log" "full disk, $share %"
    [ ! -e "$disk/out/run.json" ] || fail "full disk, $share %: run.json without a result"
    mount -o "remount,size=$((needs * 4))k" "$disk"
    texture "$disk/out" --resume always 2>"$work/log" || cat "$work/log" >&2
    missing=$(lost "$work/whole" "$disk/out") || true
    tried=$((tried + 1))
    [ "$missing" = 0 ] && survived=$((survived + 1))
    umount "$disk"
  done
  [ "$survived" = "$tried" ] || fail "full disk: not the same bytes after room was made"
  row "full disk at ${sizes[*]} %" "$tried" "$survived" "then the same command with room"
  tried=0 survived=0
  needs=$(du -sk "$work/job" | cut -f1)
  for share in 40 60 80 95; do
    mount -t tmpfs -o "size=$((needs * share / 100))k" tmpfs "$disk"
    make_job "$disk/job"
    if units "$disk/job" 2>"$work/log"; then fail "a disk of $share % of the job holds it"; fi
    expect_sentence "$work/log" "a job on a full disk, $share %"
    mount -o "remount,size=$((needs * 4))k" "$disk"
    units "$disk/job" 2>"$work/log" || cat "$work/log" >&2
    tried=$((tried + 1))
    [ "$(lost "$work/job/result" "$disk/job/result")" = 0 ] && survived=$((survived + 1))
    umount "$disk"
  done
  [ "$survived" = "$tried" ] || fail "a job on a full disk: not the same bytes after room was made"
  row "a job on a disk of 40 60 80 95 %" "$tried" "$survived" "then the same command with room"
  return "$failures"
}
export -f disk_section texture make_job units lost fail expect_sentence row
if unshare --mount --map-root-user mount -t tmpfs tmpfs /mnt 2>/dev/null; then
  failures_before=$failures
  # Functions and arrays are inherited by a subshell alone: a new process gets them as text.
  unshare --mount --map-root-user bash -c "$(declare -p work gpvc input options); failures=0; set -euo pipefail; disk_section" ||
    failures=$((failures_before + 1))
else
  row "full disk" skipped - "no permission to mount a small file system"
fi

# --- little memory
tried=0 survived=0
for megabytes in 300 500 540 580 620 660 700 800 900 1200 2400; do
  rm -rf "$work/out"
  status=0
  (ulimit -v $((megabytes * 1024)) && texture "$work/out" --resume never) 2>"$work/log" || status=$?
  tried=$((tried + 1))
  # 127: the program itself did not fit.
  if [ "$status" = 127 ] || whole_or_refused "$status" "$megabytes MB of addresses"; then survived=$((survived + 1)); fi
done
row "300 to 2400 MB of address space" "$tried" "$survived" ""
tried=0 survived=0
for size in 1M 50M 150M; do
  rm -rf "$work/out"
  if texture "$work/out" --resume never --memory "$size" 2>"$work/log"; then fail "--memory $size was enough"; fi
  expect_sentence "$work/log" "--memory $size"
  tried=$((tried + 1))
  [ ! -e "$work/out" ] && survived=$((survived + 1))
done
row "--memory below what is needed" "$tried" "$survived" ""

# --- a control group with little memory
group=$(mktemp -d /sys/fs/cgroup/gpvc-faults-XXXX 2>/dev/null || mktemp -d /sys/fs/cgroup/memory/gpvc-faults-XXXX 2>/dev/null || true)
limit=$group/memory.max
[ -n "$group" ] && [ -e "$limit" ] || limit=$group/memory.limit_in_bytes
if [ -n "$group" ] && [ -w "$limit" ]; then
  tried=0 survived=0
  for megabytes in 150 300 600; do
    echo $((megabytes << 20)) >"$limit"
    rm -rf "$work/out"
    status=0
    (echo "$BASHPID" >"$group/cgroup.procs" && texture "$work/out" --resume never) 2>"$work/log" || status=$?
    tried=$((tried + 1))
    if whole_or_refused "$status" "a group with $megabytes MB"; then survived=$((survived + 1)); fi
  done
  row "control group of 150, 300, 600 MB" "$tried" "$survived" ""
else
  row "control group" skipped - "no permission to make one"
fi
[ -z "$group" ] || rmdir "$group"

# --- two runs in one folder
rm -rf "$work/out"
texture "$work/out" --resume never &
process=$!
while [ ! -e "$work/out" ]; do sleep 0.02; done
sleep 0.1
status=0
start=$(seconds)
texture "$work/out" --resume never 2>"$work/log" || status=$?
took=$(calc "$(seconds) - $start")
expect_sentence "$work/log" "two runs in one folder"
[ "$status" = 1 ] || fail "two runs in one folder: the second was not refused"
wait "$process" || fail "two runs in one folder: the first failed"
[ "$(lost "$work/whole" "$work/out")" = 0 ] || fail "two runs in one folder: another result"
row "two runs in one folder" 1 1 "the second refused after $took s"

if [ "$failures" -gt 0 ]; then
  echo "faults.sh: $failures failures" >&2
  exit 1
fi
echo "nothing lost"
