#!/bin/sh
# SPDX-License-Identifier: MIT
# Crash loops: the supervisor starts a process that keeps dying again after growing pauses; meanwhile
# /readyz gives the reason; a process that stays alive makes the daemon ready again. This script
# mostly waits, so run.sh may run it beside other tests.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
start() {
    daemon_start
    export PENUMBRA_URL="$url"
}

# A worker that keeps dying
start
for _ in 1 2 3 4; do
    within 5 child work
    worker=$(child work)
    kill -KILL "$worker"
    within 2 gone "$worker"
done
code=$(curl -s -o ready.json -w '%{http_code}' "$url/readyz")
expect "a daemon whose worker keeps dying is not ready" "$code" 503
expect_match "/readyz gives the reason" "$(jq -r .detail ready.json)" '*worker process ended*SIGKILL*'
check "the worker is started again" within 10 child work
check "the log counts the ends in a row" grep -q "(3 in a row)" "$work/log"
check "the daemon is ready once the worker stays alive" within 15 sh -c \
    "[ \"\$(curl -s -o /dev/null -w '%{http_code}' '$url/readyz')\" = 200 ]"

# An api process that keeps dying reports that once it answers again
for _ in 1 2 3 4; do
    within 8 child api
    api=$(child api)
    kill -KILL "$api"
    within 2 gone "$api"
done
check "a daemon whose api keeps dying is not ready" within 8 sh -c \
    "[ \"\$(curl -s -o ready.json -w '%{http_code}' '$url/readyz')\" = 503 ]"
expect_match "/readyz gives that reason, too" "$(jq -r .detail ready.json)" '*api process ended*SIGKILL*'
check "the daemon is ready once the api stays alive" within 15 sh -c \
    "[ \"\$(curl -s -o /dev/null -w '%{http_code}' '$url/readyz')\" = 200 ]"

finish
