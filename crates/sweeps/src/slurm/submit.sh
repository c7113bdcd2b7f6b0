#!/bin/bash
# Puts the shards into the queue, and their merge after them. Run it again if a shard or the merge has
# failed (the merge with exit code 3: replicas are missing): shards continue where they ended.
set -eu
array=$(sbatch --parsable @array@)
merge=$(sbatch --parsable --dependency="afterany:$array" @merge@)
echo "shards: job $array, merge: job $merge"
