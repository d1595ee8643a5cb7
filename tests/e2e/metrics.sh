#!/bin/sh
# SPDX-License-Identifier: MIT
# GET /metrics: its format, by promtool if that is installed and else by metrics.py; and its numbers, which
# must count what happened.
. "$(dirname "$0")/lib.sh"
here=$(dirname "$0")

check_format() { # FILE: prints faults
    if command -v promtool >/dev/null; then
        promtool check metrics <"$1" 2>&1
    else
        python3 "$here/metrics.py" <"$1"
    fi
}
metric() { # SERIES: its value
    curl -s "$url/metrics" | awk -v series="$1" '$1 == series { print $2 }'
}
values() { # SERIES…: sets $values to their values
    values=
    for series; do values="$values${values:+ }$(metric "$series")"; done
}
have_values() { # VALUES SERIES…
    wanted=$1
    shift
    values "$@"
    [ "$values" = "$wanted" ]
}
# expect_values NAME VALUES SERIES…: the series get these values. Processes count what they did when it
# is done, which others may have seen before.
expect_values() {
    name=$1
    shift
    within have_values "$@"
    expect "$name" "$values" "$1"
}

# The checker finds what it is made for.
printf '# HELP a_ms x\n# TYPE a_ms counter\na_ms{b="c"} 1\nd 2\n' >"$work/wrong"
expect wrong-format-is-found "$([ "$(python3 "$here/metrics.py" <"$work/wrong" | wc -l)" -ge 3 ] && echo yes)" yes

daemon_start
call /metrics
expect metrics "$status" 200
expect media-type "$(header content-type)" 'text/plain; version=0.0.4; charset=utf-8'
cp "$work/body" "$work/metrics"
expect format "$(check_format "$work/metrics")" ''
expect no-job-yet "$(metric 'penumbra_jobs{state="succeeded"}') $(metric penumbra_queue_depth)" "0 0"
expect_values one-worker 1 penumbra_worker_starts_total # which may be after the daemon is ready

# A single tile is a single batch, which is not divided however long it takes
submit '{"scene": "builtin:spheres", "render": {"width": 64, "height": 48, "tile": 64}}'
call "$job?wait=60"
expect job-succeeds "$(body .state)" succeeded
rays=$(curl -s "$url$job/stats" | jq .rays.total)
expect succeeded "$(metric 'penumbra_jobs{state="succeeded"}')" 1
expect_values commits 1 'penumbra_batch_commits_total{result="ok"}'
expect_values batches-timed "1 1" penumbra_batch_seconds_count 'penumbra_batch_seconds_bucket{le="+Inf"}'
expect time-was-told "$(metric penumbra_batch_seconds_sum | awk '{ print ($1 > 0) }')" 1
expect_values rays "$rays" penumbra_rays_total
expect store-bytes "$(metric penumbra_store_bytes | awk '{ print ($1 > 4096) }')" 1
expect reads-timed "$(metric penumbra_store_read_seconds_count | awk '{ print ($1 > 0) }')" 1
three_writes() { # submit, claim, commit
    writes=$(metric penumbra_store_write_seconds_count)
    [ "$writes" -ge 3 ]
}
expect writes-timed "$(within three_writes && echo yes)" yes
expect memory "$(metric process_resident_memory_bytes | awk '{ print ($1 > 1000000) }')" 1

# A stream is counted while it is open, a waiting job by its age, and a killed worker by what it held.
long='{"scene": "builtin:room", "render": {"width": 4000, "height": 4000, "samples_per_pixel": 64}}'
submit "$long"
running=$job
submit '{"scene": "builtin:spheres", "priority": -50, "render": {"width": 8, "height": 8}}'
curl -sN "$url$running/events" >"$work/events" &
stream=$!
expect_values streams-and-leases "1 1" penumbra_sse_clients penumbra_batches_leased
# The stream waits, except while it sends, and so does the request that asks
expect_values a-stream-waits 2 'penumbra_http_connections{state="waiting"}'
expect waiting "$(metric penumbra_queue_depth)" 1
expect its-age "$(metric penumbra_queue_oldest_seconds | awk '{ print ($1 > 0) }')" 1
kill "$stream"
kill -KILL "$(curl -s "$url/v1/workers" | jq '.workers[0].pid')"
expect_values worker-started-again 2 penumbra_worker_starts_total
expect_values lease-lost 1 penumbra_leases_expired_total
call "$running/cancel" -X POST
curl -s "$url/metrics" >"$work/metrics"
expect format-after-work "$(check_format "$work/metrics")" ''

finish
