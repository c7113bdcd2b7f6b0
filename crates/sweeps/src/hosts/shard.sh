#!/bin/bash
# One shard of a study, whose number is the argument. When the standard input ends, as it does when
# the connection breaks, the program writes its checkpoints and ends; the same command continues.
exec 3<&0
@program@ --quiet sweep @study@ --shard "$1/@count@" --out @shards@/"$1-of-@count@" \
    --checkpoint-every @checkpoint_every@ </dev/null 3<&- &
pid=$!
(
    cat <&3
    kill -TERM "$pid"
) >/dev/null 2>&1 &
watch=$!
trap 'kill -TERM "$pid"' TERM
# A signal ends `wait` before the program has ended.
while wait "$pid"; code=$?; kill -0 "$pid" 2>/dev/null; do :; done
kill "$watch" 2>/dev/null
exit "$code"
