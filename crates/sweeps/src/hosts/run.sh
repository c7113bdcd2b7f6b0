#!/bin/bash
# Runs the shards of a study on the hosts of a list, waits for all of them, and merges them. Run it
# again if some have failed: shards continue where they ended, and one that has ended does nothing.
# The list may be changed in between: the shards of a host that is gone run on the others.
set -u
hosts=()
while read -r host; do
    hosts+=("$host")
done < <(sed 's/#.*//; s/[[:space:]]//g; /^$/d' @hosts@)
if ((${#hosts[@]} == 0)); then
    echo "no host in" @hosts@ >&2
    exit 2
fi
# While this script lives, the standard input of each connection is open. Its end ends the shard.
pipe=$(mktemp -d) || exit 2
trap 'rm -rf "$pipe"' EXIT
mkfifo "$pipe/open" || exit 2
exec 3<>"$pipe/open"
pids=()
trap 'kill "${pids[@]:-}" 2>/dev/null; exit 130' INT
trap 'kill "${pids[@]:-}" 2>/dev/null; exit 143' TERM HUP
for ((i = 1; i <= @count@; i++)); do
    host=${hosts[(i - 1) % ${#hosts[@]}]}
    ssh -o BatchMode=yes -o ServerAliveInterval=60 "$host" @shard@" $i" \
        <"$pipe/open" 3>&- >>@logs@/"shard-$i.log" 2>&1 &
    pids[i]=$!
done
failed=0
for ((i = 1; i <= @count@; i++)); do
    wait "${pids[i]}"
    code=$?
    if ((code != 0)); then
        failed=$((failed + 1))
        host=${hosts[(i - 1) % ${#hosts[@]}]}
        echo "shard $i on $host failed with the exit code $code:" @logs@/"shard-$i.log" >&2
    fi
done
if ((failed > 0)); then
    echo "$failed of @count@ shards failed; the same command continues them" >&2
    exit 1
fi
@program@ merge @shards@/* --out @all@ --force
