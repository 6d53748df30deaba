#!/usr/bin/env bash
# slurm_submit.sh UNIT OPTION... SCRIPT: submits a unit's script by sbatch from the job's folder and prints the id of its
# Slurm job. Where that unit is in the queue already, it prints that id instead: a Snakemake that was killed leaves its jobs
# behind, and the next one would run each of them twice.
set -euo pipefail
unit=$1
shift

queued=$(squeue --noheader --user="$(id -un)" --name="gpvc-$unit" --states=PENDING,CONFIGURING,RUNNING,SUSPENDED,REQUEUED \
  --format='%i %Z' | awk -v folder="$(pwd -P)" '{ id = $1; sub(/^[^ ]+ /, "") } $0 == folder { print id; exit }')
if [ -n "$queued" ]; then
  echo "$queued"
else
  # A job that Slurm starts anew, as after the loss of a node, goes on writing to its log.
  sbatch --parsable --job-name="gpvc-$unit" --chdir="$(pwd -P)" --output="slurm/$unit-%j.log" --open-mode=append "$@"
fi
