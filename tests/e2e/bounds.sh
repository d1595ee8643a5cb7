#!/bin/sh
# SPDX-License-Identifier: MIT
# No job holds a worker for ever. Paths that fork at every surface are cut off. Every job has a timeout, which
# the operator bounds.
. "$(dirname "$0")/lib.sh"
unset PENUMBRA_MAX_TIMEOUT PENUMBRA_MAX_SECONDS PENUMBRA_MAX_PIXELS PENUMBRA_MAX_SAMPLES PENUMBRA_MAX_PRIORITY \
    PENUMBRA_MAX_QUEUE PENUMBRA_MAX_CLIENT_QUEUE
daemon_start --max-timeout 600

# Three balls in each other that reflect and transmit all light, to depth 60; then another job.
ball='"radius": 2, "material": {"kr": 1, "kt": 1}'
forks='{"format": "penumbra-scene/1", "background": [1, 1, 1],
 "camera": {"position": [0, 0, 10], "look_at": [0, 0, 0]},
 "lights": [{"type": "point", "position": [9, 9, 9], "intensity": [1, 1, 1]}],
 "objects": [{"type": "sphere", "center": [-1, -0.6, 0], '$ball'},
  {"type": "sphere", "center": [1, -0.6, 0], '$ball'}, {"type": "sphere", "center": [0, 1.2, 0], '$ball'}]}'
render='{"width": 40, "height": 40, "max_depth": 60, "min_contribution": 0, "tile": 8}'
submit "{\"scene\": $forks, \"render\": $render}"
expect exploding-job-is-accepted "$status" 202
expect its-timeout-is-the-operators "$(body .timeout_seconds)" 600
exploding=$job
wait_for_end() { # JOB: for four minutes at most, which a slow machine may need
    for _ in 1 2 3 4; do
        call "$1?wait=60"
        case $(body .state) in queued | running) ;; *) break ;; esac
    done
}
submit "$small"
wait_for_end "$job"
expect the-next-job-succeeds "$(body .state)" succeeded
wait_for_end "$exploding"
expect exploding-job-succeeds "$(body .state)" succeeded
call "$exploding/stats"
cut=$(body .truncated_paths)
expect its-paths-are-cut-off "$([ "${cut:-0}" -gt 1000 ] && echo yes)" yes
echo "$forks" >"$work/forks.json"
"$build/penumbra" render "$work/forks.json" --set width=40 --set height=40 --set max_depth=60 --set min_contribution=0 \
    --threads 1 -o "$work/forks.png" --stats "$work/stats.json" 2>"$work/warning"
expect the-same-paths-without-a-daemon "$(jq .truncated_paths "$work/stats.json")" "$cut"
expect_match they-are-told "$(cat "$work/warning")" "*warning: $cut paths are cut off*"
call "$exploding/image"
expect the-same-picture "$(cmp "$work/body" "$work/forks.png" && echo same)" same

# With more pixel samples it would be too much work, which a submit counts.
submit "{\"scene\": $forks, \"render\": {\"width\": 2000, \"height\": 2000, \"samples_per_pixel\": 1000, \"max_depth\": 60}}"
expect_problem too-much-work 413 '*kr and kt*max_depth 60; lower it to 10,*'
expect its-place "$(body '.errors[0].pointer // .pointer')" /render
submit "{\"scene\": $forks, \"render\": {\"width\": 2000, \"height\": 2000, \"samples_per_pixel\": 1000, \"max_depth\": 10}}"
expect the-remedy-helps "$status" 202
call "$job/cancel" -X POST

# Timeouts
submit '{"scene": "builtin:spheres", "timeout_seconds": 601}'
expect_problem timeout-above-the-maximum 422 '*at most 600, which this daemon allows, found 601*'
submit '{"scene": "builtin:spheres", "render": {"width": 64, "height": 48}, "timeout_seconds": 600}'
expect timeout-at-the-maximum "$status" 202
daemon_stop
daemon_start
submit "$small"
expect timeout-is-a-day-by-default "$(body .timeout_seconds)" 86400
daemon_stop
export PENUMBRA_MAX_TIMEOUT=5000
daemon_start
submit "$small"
expect maximum-from-the-environment "$(body .timeout_seconds)" 5000
daemon_stop
unset PENUMBRA_MAX_TIMEOUT PENUMBRA_MAX_SECONDS PENUMBRA_MAX_PIXELS PENUMBRA_MAX_SAMPLES PENUMBRA_MAX_PRIORITY \
    PENUMBRA_MAX_QUEUE PENUMBRA_MAX_CLIENT_QUEUE
echo '{"max_timeout": 30}' >"$work/config.json"
daemon_start --config "$work/config.json"
submit "$small"
expect maximum-from-the-file "$(body .timeout_seconds)" 30
daemon_stop

# What counts alone tell to take days is refused; the operator may bound jobs further.
days='{"scene": "builtin:spheres", "render": {"max_depth": 1, "width": 8000, "height": 8000, "samples_per_pixel": 10000}}'
daemon_start
submit "$days"
expect_problem a-job-of-days-is-refused 413 '*expected to take at least * s (* hours)*allows 86400 s*--max-seconds*'
daemon_stop
daemon_start --max-seconds 0
submit "$days"
expect any-time-if-the-operator-says-so "$status" 202
call "$job/cancel" -X POST
daemon_stop

# The map of what pixels cost takes several times as long as they.
pixels='{"scene": "builtin:spheres", "render": {"width": 1000, "height": 1000, "samples_per_pixel": 8}'
daemon_start --max-seconds 10
submit "$pixels, \"layers\": [\"beauty\", \"cost\"]}"
expect_problem layers-count 413 '*expected to take at least * s (* hours)*allows 10 s*--max-seconds*'
submit "$pixels, \"audit\": {\"pixels\": 100000}}"
expect_problem audits-count 413 '*expected to take at least * s (* hours)*allows 10 s*--max-seconds*'
submit "$pixels, \"audit\": {}, \"layers\": [\"beauty\", \"depth\"]}"
expect what-takes-little "$status" 202
call "$job/cancel" -X POST
daemon_stop
echo '{"max_seconds": 5, "max_pixels": 10000, "max_samples": 16, "max_priority": 0}' >"$work/config.json"
daemon_start --config "$work/config.json"
submit '{"scene": "builtin:spheres", "render": {"width": 101, "height": 100}}'
expect_problem too-many-pixels 413 '*10100 pixels in a view, at most 10000*'
submit '{"scene": "builtin:spheres", "render": {"width": 100, "height": 100, "samples_per_pixel": 17}}'
expect_problem too-many-samples 413 '*samples_per_pixel is 17, this daemon allows at most 16*'
submit '{"scene": "builtin:spheres", "render": {"width": 100, "height": 100, "target_error": 0.01}}'
expect_problem too-many-samples-in-rounds 413 '*max_samples is 4096, this daemon allows at most 16*'
submit '{"scene": "builtin:spheres", "priority": 1, "render": {"width": 100, "height": 100}}'
expect_problem too-large-a-priority 422 '*at most 0, which this daemon allows, found 1*'
for priority in 1.0 1e0 100.0 101; do # integers are numbers without a fraction
    submit '{"scene": "builtin:spheres", "priority": '$priority', "render": {"width": 100, "height": 100}}'
    expect_problem "too-large-a-priority-$priority" 422 '*at most 0, which this daemon allows, found *'
done
for kind in render benchmark accuracy; do
    submit '{"scene": "builtin:spheres", "kind": "'$kind'", "budget_seconds": 80000, "render": {"width": 16, "height": 12}}'
    expect_problem "too-long-a-budget-$kind" 422 '*at most 5, which this daemon allows (--max-seconds), found 80000*'
    expect "its-place-$kind" "$(body '.errors[0].pointer')" /budget_seconds
done
submit '{"scene": "builtin:spheres", "budget_seconds": 2, "layers": ["cost"], "render": {"width": 16, "height": 12}}'
expect_problem too-long-a-budget-with-its-layer 422 '*at most 1, which this daemon allows beside the layer cost and the audit (--max-seconds), found 2*'
submit '{"scene": "builtin:spheres", "budget_seconds": 2, "audit": {}, "render": {"width": 100, "height": 100}}'
expect_problem too-long-a-budget-with-its-audit 422 '*at most 1.0*, which this daemon allows beside*'
expect its-place-of-the-audit "$(body '.errors[0].pointer')" /budget_seconds
submit '{"scene": "builtin:spheres", "kind": "benchmark", "interval": 0.5, "render": {"width": 16, "height": 12}}'
expect a-default-budget-is-bounded "$status $(body .budget_seconds)" "202 5"
call "$job/cancel" -X POST
submit '{"scene": "builtin:spheres", "priority": 0, "render": {"width": 100, "height": 100, "samples_per_pixel": 16}}'
expect what-is-allowed "$status" 202
call "/v1/explain" -H 'Content-Type: application/json' -d '{"scene": "builtin:spheres", "render": {"width": 100, "height": 100}}'
expect explained-at-an-allowed-priority "$status" 200
daemon_stop

# The queue is bounded; the same submit again is not one more.
daemon_start --max-queue 3 --max-client-queue 2
long='{"scene": "builtin:room", "render": {"width": 2000, "height": 2000, "samples_per_pixel": 64}}'
submit "$long"
first=$job
call /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: again' -d "$long"
expect second-job "$status" 202
second=$(body .id)
submit "$small"
expect_problem too-many-jobs-of-one-client 429 '*2 jobs of client address:127.0.0.1 wait or run, at most 2*'
expect_match when-to-try-again "$(curl -s -D - -o "$work/ignored" "$url/v1/jobs" -d "$small" | tr -d '\r')" '*Retry-After: *'
call /v1/jobs -H 'Content-Type: application/json' -H 'Idempotency-Key: again' -d "$long"
expect known-job-is-answered "$(body .id)" "$second"
call "$first/cancel" -X POST
submit "$small"
expect there-is-room-again "$status" 202
daemon_stop

# An api alone makes no store.
store=$work/proxied.db
daemon_start
daemon_stop
cp "$store" "$work/network.db"
cp "$store" "$work/unnamed.db"

# Behind a proxy the client is the last address that it tells. None of them can fill the queue.
daemon_start --role api --max-queue 8 --trusted-proxy 127.0.0.1
from() { # ADDRESSES…: submits a job through the proxy, with a field for each
    fields=
    for address; do fields="$fields -H X-Forwarded-For:$address"; done
    # shellcheck disable=SC2086 # addresses have no spaces
    call /v1/jobs -H 'Content-Type: application/json' $fields -d "$small"
}
for addresses in 10.0.0.7 10.0.0.9,10.0.0.7 '10.0.0.9 10.0.0.7' 10.0.0.7:80; do
    # shellcheck disable=SC2086 # several fields
    from $addresses
    expect "a-job-of-a-client-$addresses" "$status" 202
done
from 10.0.0.7
expect_problem one-more-of-that-client 429 '*4 jobs of client address:10.0.0.7 wait or run, at most 4*'
from 10.0.0.7,10.0.0.8
expect a-job-of-another-client "$status" 202
call "/v1/jobs/$(body .id)/cancel" -X POST
for n in 1 2 3; do
    from "2001:db8::$n"
    expect "a-job-of-a-network-$n" "$status" 202
done
from '[2001:db8::4]:80'
expect the-last-job-of-a-network "$status" 202
from 2001:db8::5
expect_problem the-queue-is-full 429 '*8 jobs wait or run, at most 8*'
daemon_stop
store=$work/network.db
daemon_start --role api --max-queue 4 --trusted-proxy 127.0.0.1
from 2001:db8::1
from 2001:db8::2
from 2001:db8::3
expect_problem networks-are-one-client 429 '*2 jobs of client address:2001:db8:: wait or run, at most 2*'
daemon_stop
store=$work/unnamed.db
daemon_start --role api --max-queue 4 --trusted-proxy 127.0.0.1
for n in 1 2; do
    from nobody
    expect "a-job-of-nobody-$n" "$status" 202
done
from 10.0.0.7,
expect_problem clients-without-a-name-are-one 429 '*2 jobs of client address:127.0.0.1 wait or run, at most 2*'
for n in 3 4; do
    submit "$small"
    expect "the-proxy-itself-may-fill-it-$n" "$status" 202
done

finish
