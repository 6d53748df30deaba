#!/usr/bin/env bash
# run.sh GPVC: a job of a small city on a real Slurm with two nodes, by Snakemake's profile. While it runs, one unit is
# killed and one node is drained for a while; the result must be that of `gpvc unit JOB --all`, byte for byte.
# Exit status 77 where packages are missing or Slurm cannot start. With KEEP=1 the folder with scene, jobs and logs is kept.
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)
[ $# = 1 ] || { echo "usage: run.sh GPVC" >&2; exit 2; }
gpvc=$(realpath "$1")
if ! command -v snakemake >/dev/null; then
  echo "run.sh: cannot run: snakemake is missing (Debian package snakemake)" >&2
  exit 77
fi
# All below runs beside the Slurm that with_slurm.sh starts.
if [ -z "${SLURM_TEST_FOLDER:-}" ]; then
  exec "$(dirname "${BASH_SOURCE[0]}")/with_slurm.sh" "${BASH_SOURCE[0]}" "$gpvc"
fi

work=$(mktemp -d)
snakemake=
clean() {
  [ -z "$snakemake" ] || kill "$snakemake" 2>/dev/null || true
  if [ "${KEEP:-}" = 1 ]; then echo "run.sh: kept $work" >&2; else rm -rf "$work"; fi
}
trap clean EXIT
say() { echo "run.sh: $*"; }
fail() {
  say "FAILED: $*" >&2
  if [ -f "$work/snakemake.log" ]; then tail -n 30 "$work/snakemake.log" >&2; fi
  exit 1
}

# A space in the name of the job's folder, since users have such.
job="$work/the job"
expected=$work/expected
"$gpvc" synth city -o "$work/city" --faces 20000 --photos 12 --photo-size 900x600 --quiet >/dev/null
for folder in "$job" "$expected"; do
  "$gpvc" tiles "$work/city/colmap" "$work/city/mesh.ply" --images "$work/city/images" -o "$folder" --tile-faces 12000 --quiet >/dev/null
done
started=$SECONDS
"$gpvc" unit "$expected" --all --quiet >/dev/null
units=$(python3 -c 'import json, sys; print(len(json.load(open(sys.argv[1]))["units"]))' "$job/plan.json")
say "$units units; all of them by \`gpvc unit JOB --all\`: $((SECONDS - started)) s"
[ "$units" -ge 8 ] || fail "too few units to interrupt any"

cd "$work"  # where Snakemake puts its log
# CI=true: Snakemake 7 looks after its jobs every second instead of every ten.
started=$SECONDS
CI=true snakemake --snakefile "$root/app/workflow/Snakefile" --profile "$root/app/workflow/slurm" --jobs 6 --latency-wait 10 \
  --config job="$job" gpvc="$gpvc" >"$work/snakemake.log" 2>&1 &
snakemake=$!
running() { kill -0 "$snakemake" 2>/dev/null; }
complete() { find "$job/units" -name done.json 2>/dev/null | wc -l; }

# Prints the process and name of a unit that runs now. The shells around it hold the same words in one argument.
find_unit() {
  local pid arguments i
  for pid in $(pgrep -f "unit .*--memory" || true); do
    mapfile -d '' -t arguments 2>/dev/null <"/proc/$pid/cmdline" || continue
    for ((i = 0; i + 2 < ${#arguments[@]}; i++)); do
      if [ "${arguments[i]}" = unit ] && [ "${arguments[i + 1]}" = "$job" ]; then
        echo "$pid ${arguments[i + 2]}"
        return 0
      fi
    done
  done
  return 1
}

# Any unit after the first two, so that there is something to go on from. One that was done a moment before its end is no
# loss, so the next one is taken.
killed=
while running && [ -z "$killed" ]; do
  if [ "$(complete)" -ge 2 ] && found=$(find_unit); then
    read -r pid name <<<"$found"
    if kill -KILL "$pid" 2>/dev/null && sleep 0.2 && [ ! -e "$job/units/$name/done.json" ]; then killed=$name; fi
  else
    sleep 0.05
  fi
done
[ -n "$killed" ] || fail "no unit could be killed while the job ran"
say "killed $killed when $(complete) of $units units were complete"

# A node on which something runs or, between two units, any.
drained=
while running && [ -z "$drained" ]; do
  drained=$(squeue --noheader --states=RUNNING --format=%N | head -n 1)
done
running || fail "the job ended before a node could be drained"
scontrol update NodeName="$drained" State=DRAIN Reason="tests/slurm/run.sh"
sleep 1  # for finished_jobs.txt, which has whole seconds
drained_from=$(date +%FT%T)
at=$(complete)
say "drained $drained when $at units were complete"
while running && [ "$(complete)" -lt $((at + 3)) ] && [ "$(complete)" -lt $((units - 1)) ]; do sleep 0.1; done
drained_until=$(date +%FT%T)
scontrol update NodeName="$drained" State=RESUME
say "resumed it when $(complete) were complete"

status=0
wait "$snakemake" || status=$?
snakemake=
[ "$status" = 0 ] || fail "Snakemake ended with $status"
say "all units on Slurm: $((SECONDS - started)) s"

# What Slurm itself wrote down: JobState=, NodeList=, StartTime= of every job.
jobs=$SLURM_TEST_FOLDER/finished_jobs.txt
[ "$(grep -c "Name=gpvc-$killed JobState=FAILED " "$jobs")" = 1 ] || fail "the job of $killed did not fail once"
[ "$(grep -c "Name=gpvc-$killed JobState=COMPLETED " "$jobs")" = 1 ] || fail "$killed was not run again"
[ "$(grep -c ' JobState=COMPLETED ' "$jobs")" = "$units" ] || fail "not one completed job for each of the $units units"
for node in node1 node2; do grep -q " NodeList=$node " "$jobs" || fail "nothing ran on $node"; done
awk -v node="$drained" -v from="$drained_from" -v until="$drained_until" '
  { for (i = 1; i <= NF; i++) { split($i, pair, "="); value[pair[1]] = pair[2] } }
  value["NodeList"] == node && value["StartTime"] > from && value["StartTime"] < until { print; found = 1 }
  END { exit found }' "$jobs" >&2 || fail "jobs were started on $drained while it was drained"
first=$(grep "Name=gpvc-$killed JobState=FAILED " "$jobs" | grep -o 'mem=[0-9]*')
second=$(grep "Name=gpvc-$killed JobState=COMPLETED " "$jobs" | grep -o 'mem=[0-9]*')
[ "${second#mem=}" -gt "${first#mem=}" ] || fail "$killed was not given more memory: $first, then $second"

# run.json tells times and machines.
diff -r -x run.json "$expected/result" "$job/result" >&2 || fail "the result differs from that of one machine"
files=$(find "$job/result" -type f ! -name run.json | wc -l)
[ "$files" -gt 0 ] || fail "the result is empty"

# A complete job takes no unit up again.
snakemake --snakefile "$root/app/workflow/Snakefile" --profile "$root/app/workflow/local" --config job="$job" gpvc=false \
  >"$work/snakemake.log" 2>&1 || fail "the complete job was taken up again"
say "passed: $files files are the same; ran $killed again with $second instead of $first"
