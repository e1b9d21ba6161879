#!/usr/bin/env bash
# After the array (see submit): merge.sh SUBMIT BINPICK ROUND CONFIG DIR [-n ...] [-- OPTIONS].
# Submits again what is missing, or joins the shards into DIR/trials.sqlite with its report.
submit=$1 binpick=$2 round=$3 config=$4 directory=$5
shift 5
"$binpick" status "$directory" --json >"$directory/log/status.json"
if ! grep -q '"state": "complete"' "$directory/log/status.json" && [ "$round" -lt 3 ]; then
  echo "some trials are missing, submitting again"
  BINPICK=$binpick exec "$submit" "$config" "$directory" -r $((round + 1)) "$@"
fi
exec "$binpick" merge "$directory" "$directory"
