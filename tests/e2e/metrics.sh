#!/bin/sh
# SPDX-License-Identifier: MIT
# GET /metrics: its format, by promtool where that is installed and else by metrics.py, and that the
# numbers are those of what happened.
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
expect one-worker "$(metric penumbra_worker_starts_total)" 1

submit "$small"
call "$job?wait=60"
expect job-succeeds "$(body .state)" succeeded
rays=$(curl -s "$url$job/stats" | jq .rays.total)
expect succeeded "$(metric 'penumbra_jobs{state="succeeded"}')" 1
expect commits "$(metric 'penumbra_batch_commits_total{result="ok"}')" 1
expect batches-timed "$(metric penumbra_batch_seconds_count) $(metric 'penumbra_batch_seconds_bucket{le="+Inf"}')" "1 1"
expect time-was-told "$(metric penumbra_batch_seconds_sum | awk '{ print ($1 > 0) }')" 1
expect rays "$(metric penumbra_rays_total)" "$rays"
expect store-bytes "$(metric penumbra_store_bytes | awk '{ print ($1 > 4096) }')" 1
expect reads-timed "$(metric penumbra_store_read_seconds_count | awk '{ print ($1 > 0) }')" 1
expect writes-timed "$(metric penumbra_store_write_seconds_count | awk '{ print ($1 >= 3) }')" 1 # submit, claim, commit
expect memory "$(metric process_resident_memory_bytes | awk '{ print ($1 > 1000000) }')" 1

# A stream is counted while it is open, a waiting job by its age, and a killed worker by what it held.
long='{"scene": "builtin:room", "render": {"width": 4000, "height": 4000, "samples_per_pixel": 64}}'
submit "$long"
running=$job
submit '{"scene": "builtin:spheres", "priority": -50, "render": {"width": 8, "height": 8}}'
curl -sN "$url$running/events" >"$work/events" &
stream=$!
for _ in $(seq 500); do
    [ "$(metric penumbra_sse_clients) $(metric penumbra_batches_leased)" = "1 1" ] && break
    sleep 0.02
done
expect streams-and-leases "$(metric penumbra_sse_clients) $(metric penumbra_batches_leased)" "1 1"
expect a-stream-waits "$(metric 'penumbra_http_connections{state="waiting"}')" 2 # and this request itself
expect waiting "$(metric penumbra_queue_depth)" 1
expect its-age "$(metric penumbra_queue_oldest_seconds | awk '{ print ($1 > 0) }')" 1
kill "$stream"
kill -KILL "$(curl -s "$url/v1/workers" | jq '.workers[0].pid')"
for _ in $(seq 500); do
    [ "$(metric penumbra_worker_starts_total)" = 2 ] && break
    sleep 0.02
done
expect worker-started-again "$(metric penumbra_worker_starts_total)" 2
expect lease-lost "$(metric penumbra_leases_expired_total)" 1
call "$running/cancel" -X POST
curl -s "$url/metrics" >"$work/metrics"
expect format-after-work "$(check_format "$work/metrics")" ''

finish
