#!/bin/bash
#SBATCH --job-name=@name@-merge
#SBATCH --cpus-per-task=@cpus@
#SBATCH --time=@time@
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output="@logs@/merge.log"
@options@
# Merges what the shards have done. If something is missing, the page names it, and the exit code is
# 3: the results of what is there are written all the same.
exec @program@ merge @shards@/* --out @all@ --force
