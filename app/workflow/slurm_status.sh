#!/usr/bin/env bash
# slurm_status.sh ID: prints running, success or failed for a job of Slurm, as Snakemake's --cluster-status wants it.
# Asks the controller alone, so a cluster without accounting (slurmdbd, sacct) will do.
set -euo pipefail
id=$1

# Snakemake gives up when it gets no answer; a controller that is restarted or busy is no reason to.
if ! state=$(squeue --noheader --states=all --format=%T --jobs="$id" 2>&1); then
  case $state in
    *"Invalid job id"*) state= ;;
    *) state=UNKNOWN ;;
  esac
fi

case $state in
  COMPLETED) echo success ;;
  BOOT_FAIL | CANCELLED | DEADLINE | FAILED | NODE_FAIL | OUT_OF_MEMORY | PREEMPTED | REVOKED | TIMEOUT) echo failed ;;
  "")
    # The controller forgets a job some minutes after its end (MinJobAge). The name of its log names the unit.
    log=$(compgen -G "slurm/*-$id.log" | head -n 1 || true)
    unit=${log#slurm/}
    unit=${unit%-"$id".log}
    if [ -n "$log" ] && [ -e "units/$unit/done.json" ]; then echo success; else echo failed; fi
    ;;
  *) echo running ;;
esac
