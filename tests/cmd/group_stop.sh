#!/bin/sh
# SPDX-License-Identifier: MIT
# SIGTERM to all processes of the daemon at once, as systemd sends it to a control group. Only the supervisor
# decides, and it restarts none of them.
. "$(dirname "$0")/lib.sh"
daemon_start
export PENUMBRA_URL="$url"
id=$("$penumbra" submit builtin:spheres --set width=4000 --set height=4000 --set samples_per_pixel=64)
running() {
    "$penumbra" list --json --retry 0 | jq -e ".jobs[] | select(.id == \"$id\" and .state == \"running\")"
}
within running || not_ok "the job starts" "$("$penumbra" list)"
api=$(child api) worker=$(child work)
kill -TERM "$api" "$worker"
sleep 0.5 # the children's signals come first, which is the harder order for the supervisor
expect "the api process has not ended" "$(child api)" "$api"
expect "nor has the worker" "$(child work)" "$worker"
exits "the job is still there" 0 "$penumbra" list
kill -TERM "$api" "$worker" "$daemon"
wait "$daemon"
expect "the daemon ends with exit code 0" "$?" 0
daemon=
check "its children are gone" within gone "$api" "$worker"
expect "none was started again" "$(grep -c 'starting it again' "$work/log")" 0

# While the children are being started
for round in 1 2 3 4 5 6; do
    : >"$work/first"
    setsid "$build/penumbrad" --listen 127.0.0.1:0 --store "$store" >"$work/first" 2>>"$work/log" &
    group=$!
    within grep -q '^listening on' "$work/first"
    sleep "0.00$round"
    kill -TERM "-$group"
    wait "$group"
    expect "a daemon that is told to stop at its start ends with exit code 0 ($round)" "$?" 0
done
expect "no child dies of the signal" "$(grep -c 'SIGTERM' "$work/log")" 0
expect "and none is started again" "$(grep -c 'starting it again' "$work/log")" 0
finish
