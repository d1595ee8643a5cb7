#!/bin/sh
# SPDX-License-Identifier: MIT
# A backup made while jobs come and go, and what a daemon makes of it as the README says.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
"$penumbra" scenes forest >scene.json
set -- --set width=200 --set height=150
"$penumbra" render scene.json "$@" --stats stats.json
set -- "$@" --set samples_per_pixel=$(jq '2500 / (.timing.render_ms + 1) | floor + 1' stats.json)
"$penumbra" render scene.json "$@" -o wanted.pfm

ends "without a store there is no backup" 4 "$build/penumbrad" backup b.db --store "$store"
says "which is said" stderr "there is no store $store"
ends "a backup needs a name" 2 "$build/penumbrad" backup --store "$store"
daemon_start
export PENUMBRA_URL="$url"
running=$("$penumbra" submit scene.json "$@")
is_running() { [ "$("$penumbra" list --json | jq -r ".jobs[] | select(.id == \"$running\") | .state")" = running ]; }
within 20 is_running || not_ok "the job starts" "$("$penumbra" list)"
: >taken
(while [ ! -e enough ]; do
    "$penumbra" submit builtin:spheres --set width=16 --set height=16 >>taken 2>>log || exit 1
done) &
load=$!
within 20 test -s taken
sleep 0.5
cp taken before # all of these were acknowledged before the backup begins
ends "a backup under load" 0 "$build/penumbrad" backup "$work/b.db" --store "$store"
says "says how many jobs it has" stdout " jobs, "
held=$(sed -n 's/.*: \([0-9]*\) jobs, .*/\1/p' stdout)
bytes=$(sed -n 's/.* jobs, \([0-9]*\) bytes.*/\1/p' stdout)
expect "and bytes" "$bytes" "$(wc -c <b.db | tr -d ' ')"
ends "another is not written over it" 4 "$build/penumbrad" backup b.db --store "$store"
says "and why" stderr "--replace"
ends "unless that is wanted" 0 env PENUMBRA_STORE="$store" "$build/penumbrad" backup c.db
ends "with --replace" 0 "$build/penumbrad" backup c.db --store "$store" --replace
: >enough
wait $load
expect "nothing unfinished is left" "$(find . -name '*.part-*' | wc -l | tr -d ' ')" 0
daemon_stop KILL

# Restored, over a store that was killed
cp b.db "$store"
rm -f "$store-wal" "$store-shm"
daemon_start
export PENUMBRA_URL="$url"
"$penumbra" list --json --limit 500 | jq -r '.jobs[].id' | sort >restored
expect "the restored store has the jobs of the backup" "$(wc -l <restored | tr -d ' ')" "$held"
sort before >want
expect "all that was acknowledged before it among them" "$(comm -23 want restored | wc -l | tr -d ' ')" 0
ends "the job that ran goes on" 0 "$penumbra" wait "$running"
"$penumbra" fetch "$running" -o got.pfm
check "to the same bytes" cmp got.pfm wanted.pfm
ends "and the others end" 0 "$penumbra" wait $(cat restored)
daemon_stop
printf 'not a database' >"$store"
rm -f "$store-wal" "$store-shm"
ends "a damaged store is not served" 8 "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
says "and it says what to do" stderr "restore a backup"
ends "nor does a worker use it" 8 "$build/penumbrad" --role worker --store "$store"
expect "it is left as it was" "$(cat "$store")" "not a database"
finish
