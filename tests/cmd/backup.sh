#!/bin/sh
# SPDX-License-Identifier: MIT
# A backup made while jobs are submitted and rendered; a daemon that runs on the restored copy.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
"$penumbra" scenes forest >scene.json
set -- --set width=200 --set height=150
set -- "$@" --set samples_per_pixel=$(samples_lasting 1000 scene.json "$@")
"$penumbra" render scene.json "$@" -o wanted.pfm

exits "a backup without a store fails" 4 "$build/penumbrad" backup b.db --store "$store"
prints "and names the missing store" stderr "$store: there is no store"
exits "a backup without a file name fails" 2 "$build/penumbrad" backup --store "$store"
daemon_start
export PENUMBRA_URL="$url"
running=$("$penumbra" submit scene.json "$@")
has_begun() { "$penumbra" list --json | jq -e ".jobs[] | select(.id == \"$running\") | .state == \"running\" or .state == \"succeeded\""; }
within has_begun || not_ok "the job starts" "$("$penumbra" list)"
: >taken
(while [ ! -e enough ]; do
    "$penumbra" submit builtin:spheres --set width=16 --set height=16 >>taken 2>>log || exit 1
done) &
load=$!
within test -s taken
sleep 0.5
cp taken before # these jobs were acknowledged before the backup began
exits "a backup under load" 0 "$build/penumbrad" backup "$work/b.db" --store "$store"
prints "a backup prints the number of jobs" stdout " jobs, "
held=$(sed -n 's/.*: \([0-9]*\) jobs, .*/\1/p' stdout)
bytes=$(sed -n 's/.* jobs, \([0-9]*\) bytes.*/\1/p' stdout)
expect "and the number of bytes" "$bytes" "$(wc -c <b.db | tr -d ' ')"
exits "a backup does not replace an existing file" 4 "$build/penumbrad" backup b.db --store "$store"
prints "and names the option for that" stderr "--replace"
exits "a backup finds the store by the environment variable" 0 env PENUMBRA_STORE="$store" "$build/penumbrad" backup c.db
exits "--replace replaces an existing file" 0 "$build/penumbrad" backup c.db --store "$store" --replace
: >enough
wait $load

# One that is killed leaves nothing. The store is so big that a copy takes a while.
for i in 1 2 3 4 5; do
    {
        printf '{"format": "penumbra-scene/1", "comment": "'
        head -c 6000000 /dev/urandom | base64 -w 0
        printf '", "camera": {"position": [0, 0, 5], "look_at": [0, 0, 0]}, "render": {"width": 4, "height": 4}}'
    } >big.json
    "$penumbra" submit big.json >>log
done
is_made() { [ -e d.db ] || [ "$(find . -name 'd.db.part-*' -size +1000k | wc -l)" -gt 0 ]; }
no_copy() { [ -z "$(find . -name 'd.db*')" ]; }
# ended_by COMMAND…: begins backups until one was still being made when the command came, which ends it. One
# that looked at signals no longer is made to its end, and has its name then. Sets $code.
ended_by() {
    for _ in $(seq 40); do
        env --default-signal=INT "$build/penumbrad" backup d.db --store "$store" >stdout 2>stderr &
        backup=$!
        within is_made || not_ok "the backup begins" "$(ls -l)"
        maker=$(pgrep -P $backup)
        "$@" 2>>log
        wait $backup 2>>log
        code=$?
        [ -z "$maker" ] || within gone "$maker" || not_ok "the process that makes the backup ends" "$maker"
        [ -e d.db ] || return
        rm d.db
    done
    not_ok "a backup is ended while it is made" "it is done before: $*"
}
end_backup() { kill "-$1" $backup; } # SIGNAL
end_maker() { kill -KILL "$maker"; }
end_both() { kill -KILL $backup "$maker"; }
for signal in TERM=143 INT=130 KILL=137; do
    ended_by end_backup ${signal%=*}
    expect "a backup dies of SIG${signal%=*}" "$code" "${signal#*=}"
    check "and leaves nothing" within no_copy
done
ended_by end_maker
expect "a backup dies with the process that makes it" "$code" 137
check "and leaves nothing" within no_copy
check "and says so" grep -q 'was ended by a signal' stderr
ended_by end_both
exits "the next backup" 0 "$build/penumbrad" backup d.db --store "$store"
expect "removes what two processes that were killed at once have left" "$(find . -name 'd.db*')" ./d.db
expect "no temporary file of a backup remains" "$(find . -name '*.part-*' | wc -l | tr -d ' ')" 0

# Restores the copy over the store of a killed daemon. Its children end by themselves, and until then they
# may write to the store.
children="$(child api) $(child work)"
daemon_stop KILL
# shellcheck disable=SC2086
within gone $children || not_ok "the children of the killed daemon end" "$(ps -o pid,stat,comm -p "$children")"
cp b.db "$store"
rm -f "$store-wal" "$store-shm"
daemon_start
export PENUMBRA_URL="$url"
"$penumbra" list --json --limit 500 | jq -r '.jobs[].id' | sort >restored
expect "the restored store has as many jobs as the backup printed" "$(wc -l <restored | tr -d ' ')" "$held"
sort before >want
expect "all jobs acknowledged before the backup are among them" "$(comm -23 want restored | wc -l | tr -d ' ')" 0
exits "the job that was running succeeds after the restore" 0 "$penumbra" wait "$running"
"$penumbra" fetch "$running" -o got.pfm
check "with the bytes of an undisturbed render" cmp got.pfm wanted.pfm
exits "all other jobs succeed too" 0 "$penumbra" wait $(cat restored)
daemon_stop
printf 'not a database' >"$store"
rm -f "$store-wal" "$store-shm"
exits "a daemon does not start with a damaged store" 8 "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
prints "and says so" stderr "is not a Penumbra store, or is damaged"
exits "a worker does not start with a damaged store" 8 "$build/penumbrad" --role worker --store "$store"
expect "the damaged store is not changed" "$(cat "$store")" "not a database"
finish
