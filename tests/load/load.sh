#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon under load, and the limits that it must keep on an otherwise idle machine; takes some minutes.
# `make load` runs it; it prints the figures.
. "$(dirname "$0")/../e2e/lib.sh"
. "$(dirname "$0")/lib.sh"
ulimit -n "$(ulimit -Hn)"
seconds=${SECONDS_EACH:-30}
load_start

run() { # NAME ARGUMENT…: runs `load` and shows what it prints
    echo "== $*"
    "$load" "$@" | tee "$work/values"
}

run half "$port" 1100 "$seconds"
expect half-health-failed "$(value health-failed)" 0
below health-p99-ms 50

run crowd "$port" "$api" "$job" "$picture" 100 "$seconds"
expect polls "$(value polls)" 512
expect streams "$(value streams)" 500
expect health-failed "$(value health-failed)" 0
expect job-failed "$(value job-failed)" 0
below health-p99-ms 50
below job-p99-ms 50
below resident-mib 250
below closed-freed-s 5

# Shorter than it takes to find out that a client has vanished: how long that is, is measured after the end.
run crowd "$port" "$api" "$job" "$picture" 100 6
expect descriptors-left "$(value left)" 0
below closed-freed-s 5
below vanished-freed-s 30

# A scene of 12 MB.
awk 'BEGIN {
    printf "{\"format\": \"penumbra-scene/1\", \"camera\": {\"position\": [0,0,9], \"look_at\": [0,0,0]}, \"objects\": ["
    for (i = 0; i < 209000; i++)
        printf "%s{\"type\":\"sphere\",\"center\":[%d.5,%d.25,%d],\"radius\":0.125}", i ? "," : "", i % 100, i / 100 % 100, i / 10000
    print "]}"
}' >"$work/scene"
run post "$port" "$work/scene" 6 "$seconds"
expect posts-refused "$(value refused)" 0
expect list-failed "$(value list-failed)" 0
expect ready-failed "$(value ready-failed)" 0
below list-p99-ms 20
below ready-p99-ms 100

# Bad requests beside a render. The same requests to a server that only accepts and closes show what the
# clients themselves take of the processors. A machine's speed drifts, so short rounds of both alternate, and
# a round is held against the mean of its neighbours.
daemon_stop
store=$work/second.db # without the scenes from above, whose pictures would be computed beside
daemon_start
port=${url##*:}
middle() { # FILE: the median
    sort -n "$1" | awk '{v[NR] = $1} END {print NR ? v[int((NR + 1) / 2)] : "none"}'
}
renders_beside() { # PORT: sets $took to the milliseconds of a render beside bad requests to this port
    : >"$work/renders"
    "$load" bad "$1" 10000 "$((seconds / 10))" >"$work/values" &
    clients=$!
    sleep 0.3
    while kill -0 $clients 2>/dev/null; do
        submit '{"scene": "builtin:room", "render": {"width": 400, "height": 560, "samples_per_pixel": 2}}'
        while [ "$(curl -s "$url$job?wait=60" | jq -r .state)" = running ]; do :; done
        kill -0 $clients 2>/dev/null &&
            curl -s "$url$job/stats" | jq '.timing.render_ms | numbers' >>"$work/renders"
    done
    wait $clients
    took=$(middle "$work/renders")
    echo "port $1: $(value per-second) requests in a second, $(wc -l <"$work/renders") renders of $took ms"
    expect "requests-in-a-second-$1" "$(awk -v n="$(value per-second)" 'BEGIN {print (n > 9500)}')" 1
    expect "renders-beside-$1" "$(($(wc -l <"$work/renders") > 2))" 1
}
renders_beside 0
before=$took
for _ in $(seq 30); do
    renders_beside "$port"
    beside=$took
    expect bad-health-failed "$(value health-failed)" 0
    cat "$work/values"
    renders_beside 0
    awk -v a="$before" -v b="$beside" -v c="$took" 'BEGIN {print 2 * b / (a + c)}' >>"$work/ratios"
    before=$took
done
echo "== renders beside bad requests to the daemon, and to a server that only closes: $(sort -n "$work/ratios" | tr '\n' ' ')"
echo "slower $(middle "$work/ratios")" >"$work/values"
below slower 1.1
finish
