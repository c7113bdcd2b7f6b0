#!/bin/bash
#SBATCH --job-name=@name@
#SBATCH --array=1-@count@
#SBATCH --cpus-per-task=@cpus@
#SBATCH --time=@time@
#SBATCH --signal=B:USR1@@lead@
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output="@logs@/shard-%a.log"
@options@
# One shard of a study. Before the time limit, Slurm sends USR1: the program writes its checkpoints,
# and the task goes back into the queue, where it continues.
shard=$SLURM_ARRAY_TASK_ID
@program@ --quiet sweep @study@ --shard "$shard/@count@" --out @shards@/"$shard-of-@count@" \
    --threads @cpus@ --checkpoint-every @checkpoint_every@ &
pid=$!
late=no
trap 'late=yes; kill -TERM "$pid"' USR1
trap 'kill -TERM "$pid"' TERM
# A signal ends `wait` before the program has ended.
while wait "$pid"; code=$?; kill -0 "$pid" 2>/dev/null; do :; done
if [ "$late" = yes ] && [ "$code" -ne 0 ]; then
    scontrol requeue "${SLURM_ARRAY_JOB_ID}_$shard"
fi
exit "$code"
