#!/bin/sh
# SPDX-License-Identifier: MIT
# Crash loops. If a process dies again and again, the supervisor restarts it after growing pauses. Meanwhile
# /readyz gives the reason. A process that stays alive makes the daemon ready again. This script mostly waits,
# so run.sh may run it beside other tests.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
start() {
    daemon_start
    export PENUMBRA_URL="$url"
}
not_ready() { [ "$(curl -s -o ready.json -w '%{http_code}' "$url/readyz")" = 503 ]; }

# in_a_row ROLE: whether the log counts three ends of that process in a row
in_a_row() {
    grep -q "the $1 process .* (3 in a row)" "$work/log"
}

# reaped PID: whether the supervisor has collected the process, which until then still bears its name
reaped() {
    ! kill -0 "$1" 2>/dev/null
}

# keeps_dying ROLE NAME: kills the process until the log counts three ends in a row. One that lives 10 s,
# since this script is held up, begins the row again.
keeps_dying() {
    for _ in 1 2 3 4 5 6 7 8 9 10 11 12; do
        within child "$2"
        pid=$(child "$2")
        kill -KILL "$pid"
        within reaped "$pid"
        in_a_row "$1" && break
    done
}

# A worker that keeps dying
start
keeps_dying worker work
check "a daemon whose worker keeps dying is not ready" within not_ready
expect_match "/readyz gives the reason" "$(jq -r .detail ready.json)" '*worker process ended*SIGKILL*'
check "the worker is started again" within child work
check "the log counts the ends in a row" in_a_row worker
check "the daemon is ready once the worker stays alive" within sh -c \
    "[ \"\$(curl -s -o /dev/null -w '%{http_code}' '$url/readyz')\" = 200 ]"

# An api process that keeps dying reports that once it answers again
keeps_dying api api
tells() { not_ready && jq -r .detail ready.json | grep -q 'api process ended.*SIGKILL'; }
check "a daemon whose api keeps dying is not ready, and says so once the store is open" within tells
check "the daemon is ready once the api stays alive" within sh -c \
    "[ \"\$(curl -s -o /dev/null -w '%{http_code}' '$url/readyz')\" = 200 ]"

finish
