#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon under load, with the limits that it must hold on a machine that has nothing else to do; takes
# some minutes. `make load` runs it; the figures are printed.
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
below resident-mib 300
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
# clients themselves take of the processors.
daemon_stop
daemon_start
port=${url##*:}
render_beside() { # PORT: milliseconds of a render beside bad requests to this port
    "$load" bad "$1" 10000 "$seconds" >"$work/values" &
    sleep 1
    submit '{"scene": "builtin:room", "render": {"width": 1000, "height": 1400, "samples_per_pixel": 4}}'
    while [ "$(curl -s "$url$job?wait=60" | jq -r .state)" = running ]; do :; done
    curl -s "$url$job/stats" | jq .timing.render_ms
    wait $!
}
alone=$(render_beside 0)
echo "== a render beside bad requests to a server that only closes: $alone ms"
beside=$(render_beside "$port")
echo "== and to the daemon: $beside ms"
cat "$work/values"
expect bad-health-failed "$(value health-failed)" 0
echo "slower $(awk -v a="$beside" -v b="$alone" 'BEGIN {print a / b}')" >"$work/values"
below slower 1.1
finish
