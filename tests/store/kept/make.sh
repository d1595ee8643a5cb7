#!/bin/sh
# SPDX-License-Identifier: MIT
# Makes one of the kept stores, see README.md:
#   tests/store/kept/make.sh BUILD FILE
# starts the daemon of a build of that version, submits the jobs beside this script, kills all its
# processes (SIGKILL) as soon as the job `half` has its first batch, and writes the store to FILE.zst.
set -eu
build=$1 file=$2
jobs=$(cd "$(dirname "$0")" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

"$build/penumbrad" --listen 127.0.0.1:0 --store "$work/store.db" --threads 1 >"$work/out" 2>"$work/log" &
daemon=$!
url=
while [ -z "$url" ]; do
    sleep 0.1
    url=$(sed -n 's/^listening on //p' "$work/out")
done
until curl -sS -f "$url/readyz" >"$work/ready" 2>&1; do # it listens before its store is open
    sleep 0.1
done

submit() { # NAME: prints the job's id
    curl -sS -f "$url/v1/jobs" -H 'Content-Type: application/json' -H "Idempotency-Key: $1" -d "@$jobs/$1.json" | jq -r .id
}
state() { # ID
    curl -sS -f "$url/v1/jobs/$1?wait=60" | jq -r .state
}
finished=$(submit done)
failed=$(submit failed)
[ "$(state "$finished")" = succeeded ]
[ "$(state "$failed")" = failed ]
half=$(submit half)
submit queued
submit views
cancelled=$(submit cancelled)
curl -sS -f -X POST "$url/v1/jobs/$cancelled/cancel" >"$work/answer"
submit benchmark || echo "this version has no benchmarks"
until [ "$(curl -sS -f "$url/v1/jobs/$half" | jq .progress.done)" -gt 0 ]; do
    sleep 0.05
done
kill -9 "$daemon" $(pgrep -P "$daemon")
wait "$daemon" || [ $? -eq 137 ] # 128 + SIGKILL

python3 - "$work/store.db" <<'END'
import sqlite3, sys
store = sqlite3.connect(sys.argv[1])
if store.execute("SELECT 1 FROM sqlite_schema WHERE name = 'meta'").fetchone():
    store.execute("UPDATE meta SET value = 0 WHERE name = 'log'")  # its log is folded into it below
    store.commit()
store.execute("PRAGMA wal_checkpoint(TRUNCATE)")
store.execute("PRAGMA journal_mode = DELETE")
for row in store.execute("SELECT number, state, done_pixels, total_pixels FROM job"):
    print(row)
for row in store.execute("SELECT id, job, view, state, attempt, worker FROM batch"):
    print(row)
END
zstd -19 -q -f "$work/store.db" -o "$file.zst"
