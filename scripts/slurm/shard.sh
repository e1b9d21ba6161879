#!/usr/bin/env bash
# One task of the array (see submit): shard.sh BINPICK CONFIG DIR [OPTIONS OF binpick run].
# The program reads its shard from the array's environment.
binpick=$1 config=$2 directory=$3
shift 3
for _ in 1 2 3; do
  "$binpick" run "$config" --out "$directory" --workers "${SLURM_CPUS_PER_TASK:-1}" "$@"
  code=$?
  # Killed from outside: it goes on where it was. A stop that was asked for is no such thing.
  [ "$code" -eq 137 ] || break
done
# Gates are judged when everything is there.
[ "$code" -ne 1 ] || code=0
exit "$code"
