#!/usr/bin/env bash
# Runs a study under a real Slurm on this machine: an array of shards, one of them killed, one told
# to end and put back into the queue, the merge as a dependent job. The merged table must be that of
# one process, byte for byte. Usage: tests/slurm.sh [CAROM]; without the program it is built.
#
# Needs root and Debian's packages slurm-wlm and munge; without them it is skipped, and counted in
# the file that CAROM_SKIPPED names. Nothing outside of a temporary folder is written.
set -euo pipefail

skip() {
    echo "skipped: slurm: $*" | tee -a "${CAROM_SKIPPED:-/dev/null}"
    exit 0
}
((EUID == 0)) || skip "needs root to start its services"
for command in slurmctld slurmd sbatch munged; do
    command -v "$command" >/dev/null || skip "no $command"
done

cd "$(dirname "$0")/.."
if (($# == 0)); then
    cargo build --release --quiet --package carom-cli
fi
carom=$(realpath "${1:-${CARGO_TARGET_DIR:-target}/release/carom}")
place=$(realpath "$(mktemp -d)")
chmod 755 "$place"
mkdir "$place"/{munge,spool,state}
export SLURM_CONF=$place/slurm.conf

end() {
    code=$?
    ((code == 0)) || tail -n 15 "$place"/out/slurm/logs/*.log "$place"/*.log 2>/dev/null || true
    for file in "$place"/{slurmd.pid,slurmctld.pid,munge/pid}; do
        [[ ! -s $file ]] || kill "$(cat "$file")" 2>/dev/null || true
    done
    wait
    sleep 1
    rm -rf "$place"
    exit "$code"
}
trap end EXIT

# Keys and services of this test alone.
head -c 1024 /dev/urandom >"$place/munge/key"
chown -R munge: "$place/munge"
chmod 400 "$place/munge/key"
runuser -u munge -- munged --force --key-file="$place/munge/key" --socket="$place/munge/socket" \
    --pid-file="$place/munge/pid" --log-file="$place/munge/log" --seed-file="$place/munge/seed" 2>/dev/null
host=$(hostname -s)
cat >"$SLURM_CONF" <<EOF
ClusterName=test
SlurmctldHost=$host(127.0.0.1)
SlurmctldPort=16817
SlurmdPort=16818
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket=$place/munge/socket
MpiDefault=none
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
ReturnToService=2
SlurmctldPidFile=$place/slurmctld.pid
SlurmdPidFile=$place/slurmd.pid
SlurmdSpoolDir=$place/spool
StateSaveLocation=$place/state
SlurmctldLogFile=$place/slurmctld.log
SlurmdLogFile=$place/slurmd.log
SchedulerType=sched/backfill
SchedulerParameters=sched_interval=2,bf_interval=2
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
JobCompType=jobcomp/none
MinJobAge=3600
NodeName=$host NodeAddr=127.0.0.1 CPUs=2 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
EOF
slurmctld -f "$SLURM_CONF"
slurmd -f "$SLURM_CONF"

# Waits until a command succeeds.
until_true() {
    local seconds=$1
    shift
    for ((i = 0; i < 10 * seconds; i++)); do
        if "$@" >/dev/null 2>&1; then return 0; fi
        sleep 0.1
    done
    echo "not within $seconds s: $*" >&2
    return 1
}
until_true 60 bash -c "sinfo -h -o %T | grep -q idle"

mkdir "$place/out"
cat >"$place/gas.toml" <<'EOF'
[box]
sides = [1.0, 1.0]
seed = 7
[[gas]]
count = 300
radius = 0.01
mass = 1.0
energy = 1.0
[run]
until = 2000.0
sample_interval = 10.0
animation = false
observe = ["pressure", "energy"]
EOF
cat >"$place/study.toml" <<'EOF'
scene = "gas.toml"
replicas = 2
[[vary]]
key = "gas.0.count"
values = [200, 300, 400, 500]
EOF

cd "$place/out"
"$carom" --quiet sweep "$place/study.toml" --out one
"$carom" --quiet sweep "$place/study.toml" --slurm --array-size 4 --time 10 --out slurm

submit() {
    # shards: job 1, merge: job 2
    local said
    said=$(bash slurm/submit.sh)
    echo "$said"
    read -r array merge < <(tr -c '0-9\n' ' ' <<<"$said")
}
state() { squeue -h -j "$1" -t all -r -o "%i %T %r"; }
task_is() { state "${array}_$1" | grep -q "$2"; }
# The process of a shard of this test: its command line holds the temporary folder of this test.
shard_process() {
    local entry
    for entry in /proc/[0-9]*; do
        if [[ $(readlink "$entry/exe") == "$carom" ]] &&
            tr '\0' ' ' <"$entry/cmdline" | grep -qF -- "--shard $1/4 --out $place/out/slurm/shards/"; then
            echo "${entry#/proc/}"
            return
        fi
    done 2>/dev/null
    return 1
}
ended() { ! squeue -h -j "$1" 2>/dev/null | grep -q .; }

submit
until_true 60 task_is 1 RUNNING
until_true 60 task_is 2 RUNNING
sleep 1
# One program is killed, as for want of memory; another receives the signal before its time limit.
kill -KILL "$(shard_process 1)" && echo "killed shard 1"
# scancel asks again while the task is put back, so nothing waits for it.
scancel --batch --signal=USR1 "${array}_2" 2>/dev/null &
echo "sent shard 2 the signal before its time limit"
# A task that has been put back waits two minutes, unless its start time is changed.
until_true 60 task_is 2 PENDING
until_true 30 scontrol update JobId="${array}_2" StartTime=now
until_true 300 ended "$array"
until_true 120 ended "$merge"
state "$array,$merge"
grep -q Incomplete slurm/logs/merge.log
# A merge that lacks replicas ends with exit code 3, which Slurm shows as a failure.
state "$merge" | grep -q FAILED
# The killed shard is missing; the same command continues it.
submit
until_true 300 ended "$array"
until_true 120 ended "$merge"
state "$array,$merge"

cmp one/table.csv slurm/all/table.csv
echo "slurm: killed, put back, continued, merged: $(wc -c <one/table.csv) bytes of table, all equal"
