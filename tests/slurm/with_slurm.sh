#!/usr/bin/env bash
# with_slurm.sh COMMAND...: runs COMMAND beside a Slurm of its own: munged, slurmctld and two nodes (slurmd) on this
# machine, on free ports of the loopback, with key, configuration, spool and logs in a temporary folder. Needs neither
# root nor systemd, and leaves a Slurm that is installed here alone. Exit status: that of COMMAND, 77 where packages are
# missing or slurmd cannot start, as in a container without a cgroup. COMMAND finds SLURM_CONF set, and in
# SLURM_TEST_FOLDER the folder, which has finished_jobs.txt (jobcomp/filetxt).
set -euo pipefail
PATH=$PATH:/usr/sbin:/sbin
for program in munged slurmctld slurmd sbatch squeue scontrol scancel python3; do
  if ! command -v "$program" >/dev/null; then
    echo "with_slurm.sh: cannot run: $program is missing (Debian packages munge, slurmctld, slurmd, slurm-client)" >&2
    exit 77
  fi
done
if ! grep -qE '^[^ ]+ [^ ]+ cgroup2? ' /proc/mounts; then
  echo "with_slurm.sh: cannot run: no cgroup is mounted, and slurmd does not start without" >&2
  exit 77
fi

folder=$(mktemp -d /tmp/slurm-test.XXXXXX)  # a short path: sockets' names have 107 characters
chmod 711 "$folder"  # munged wants its socket to be in the reach of all users
export SLURM_CONF=$folder/slurm.conf SLURM_TEST_FOLDER=$folder

daemons=()
nodes=()  # by the process of their slurmd
ready=  # how many nodes are
# Every process that this Slurm started, jobs included, was born with its SLURM_CONF.
descendants() {
  local environment
  for environment in /proc/[0-9]*/environ; do
    if tr '\0' '\n' <"$environment" 2>/dev/null | grep -qxF "SLURM_CONF=$SLURM_CONF"; then
      basename "$(dirname "$environment")"
    fi
  done
}
stop() {
  local status=$? pid
  trap - EXIT
  set +e
  if [ -n "$ready" ]; then
    timeout 10 scancel --user="$(id -un)" --full
    for _ in $(seq 50); do
      [ -n "$(timeout 5 squeue --noheader)" ] || break
      sleep 0.1
    done
  fi 2>/dev/null
  for pid in "${daemons[@]}"; do kill "$pid"; done 2>/dev/null
  for _ in $(seq 50); do
    [ -n "$(jobs -rp)" ] || break
    sleep 0.1
  done
  for pid in $(descendants); do kill -KILL "$pid"; done 2>/dev/null
  wait 2>/dev/null
  if [ "${KEEP_SLURM_FOLDER:-}" = 1 ]; then echo "with_slurm.sh: kept $folder" >&2; else rm -rf "$folder"; fi
  exit "$status"
}
trap stop EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

read -ra ports < <(python3 - <<'PYTHON'
import socket
sockets = [socket.socket() for _ in range(3)]
for s in sockets: s.bind(("127.0.0.1", 0))
print(*(s.getsockname()[1] for s in sockets))
PYTHON
)
host=$(hostname -s)
user=$(id -un)
cat >"$SLURM_CONF" <<CONF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=${ports[0]}
SlurmUser=$user
SlurmdUser=$user
AuthType=auth/munge
AuthInfo=socket=$folder/munge.socket
CredType=cred/munge
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/none
SwitchType=switch/none
SelectType=select/cons_tres
SelectTypeParameters=CR_CPU_Memory
# Nodes are what is written here, whatever this machine has.
SlurmdParameters=config_overrides
StateSaveLocation=$folder/state
SlurmctldPidFile=$folder/slurmctld.pid
SlurmctldLogFile=$folder/slurmctld.log
SlurmdSpoolDir=$folder/%n
SlurmdPidFile=$folder/%n.pid
SlurmdLogFile=$folder/%n.log
JobCompType=jobcomp/filetxt
JobCompLoc=$folder/finished_jobs.txt
SchedulerParameters=sched_interval=2,bf_interval=2
ReturnToService=2
NodeName=node1 NodeHostname=$host NodeAddr=127.0.0.1 Port=${ports[1]} CPUs=4 RealMemory=8000
NodeName=node2 NodeHostname=$host NodeAddr=127.0.0.1 Port=${ports[2]} CPUs=4 RealMemory=8000
PartitionName=all Nodes=ALL Default=YES LLN=YES MaxTime=INFINITE State=UP
CONF
mkdir "$folder/state"
touch "$folder/finished_jobs.txt"

failed_to_start() {
  echo "with_slurm.sh: $1; the logs end with:" >&2
  tail -n 8 "$folder"/*.log >&2
  exit 1
}
(umask 077 && head -c 1024 /dev/urandom >"$folder/munge.key")
munged --foreground --key-file="$folder/munge.key" --socket="$folder/munge.socket" --pid-file="$folder/munge.pid" \
  --seed-file="$folder/munge.seed" --log-file="$folder/munge.log" >"$folder/munged.log" 2>&1 &
daemons+=($!)
for _ in $(seq 100); do [ -S "$folder/munge.socket" ] && break; sleep 0.1; done
[ -S "$folder/munge.socket" ] || failed_to_start "munged did not start"

slurmctld -D >"$folder/slurmctld.out.log" 2>&1 &
daemons+=($!)
for node in node1 node2; do
  mkdir "$folder/$node"
  slurmd -D -N "$node" >"$folder/$node.out.log" 2>&1 &
  daemons+=($!)
  nodes[$!]=$node
done
for _ in $(seq 300); do
  for pid in "${!nodes[@]}"; do
    kill -0 "$pid" 2>/dev/null && continue
    reason=$(cat "$folder/${nodes[pid]}.log" "$folder/${nodes[pid]}.out.log" 2>/dev/null | grep -m 1 -E 'error|fatal' || true)
    echo "with_slurm.sh: cannot run: slurmd does not start on this machine: ${reason:-it says nothing}" >&2
    exit 77
  done
  ready=$(timeout 5 sinfo --noheader --Node --format='%N %T' 2>/dev/null | grep -c ' idle$' || true)
  [ "$ready" = 2 ] && break
  sleep 0.1
done
[ "$ready" = 2 ] || failed_to_start "the two nodes did not come up"

"$@"
