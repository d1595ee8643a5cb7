#!/bin/sh
# SPDX-License-Identifier: MIT
# The life of a job over HTTP: submit, follow, fetch, list, cancel, remove.
. "$(dirname "$0")/lib.sh"
daemon_start

# Submit and follow.
submit "$small"
expect submit-accepted "$status" 202
expect_match submit-location "$job" '/v1/jobs/????????-????-7???-????-????????????'
expect submit-type "$(header content-type)" application/json
expect submit-self "$(body .links.self)" "$job"
expect_match submit-state "$(body .state)" '[qrs]*'
expect submit-retry-after "$(header retry-after)" 1
first=$job
call "$job?wait=60"
expect wait-status "$status" 200
expect wait-state "$(body .state)" succeeded
expect wait-done "$(body '.progress | .done == .total and .fraction == 1')" true
expect wait-etag "$(header etag)" "\"$(body .revision)\""
expect wait-no-retry-after "$(header retry-after)" ""
expect_match wait-cacheable "$(header cache-control)" 'private, max-age=*'
tag=$(header etag)
call "$job" -H "If-None-Match: $tag"
expect job-not-modified "$status" 304
expect job-not-modified-empty "$(wc -c <"$work/body" | tr -d ' ')" 0
call "$job" -H 'If-None-Match: "0", W/"99999"'
expect job-modified "$status" 200
call "$job?wait=5" -H "If-None-Match: $tag"
expect ended-job-does-not-wait "$status" 304
call "$job" -I
expect head-status "$status" 200
expect head-etag "$(header etag)" "$tag"
call "/v1/jobs/$(printf '%s' "${job##*/}" | tr a-f A-F)"
expect uuid-in-any-case "$status" 200

# The picture.
call "$job/image"
expect image-status "$status" 200
expect image-type "$(header content-type)" image/png
expect image-signature "$(head -c 8 "$work/body" | od -An -tx1 | tr -d ' \n')" 89504e470d0a1a0a
expect image-size "$(od -An -j16 -N8 -tu1 "$work/body" | tr -s ' ')" " 0 0 0 64 0 0 0 48"
expect_match image-tag "$(header etag)" '"?*"'
expect image-ranges "$(header accept-ranges)" bytes
cp "$work/body" "$work/whole"
size=$(wc -c <"$work/whole" | tr -d ' ')
tag=$(header etag)
call "$job/image" -H "If-None-Match: $tag"
expect image-not-modified "$status" 304
expect image-not-modified-length "$(header content-length)" "$size"
call "$job/image" -I
expect image-head "$status $(header content-length)" "200 $size"
call "$job/image" -I -H 'Range: bytes=0-9'
expect head-has-no-ranges "$status $(header content-length)" "200 $size"
call "$job/image" -H "Range: bytes=0-99"
expect range-status "$status" 206
expect range-content-range "$(header content-range)" "bytes 0-99/$size"
expect range-length "$(wc -c <"$work/body" | tr -d ' ')" 100
cp "$work/body" "$work/parts"
call "$job/image" -H "Range: bytes=100-" -H "If-Range: $tag"
expect range-if-same "$status" 206
cat "$work/body" >>"$work/parts"
expect ranges-make-the-whole "$(cmp "$work/parts" "$work/whole" && echo same)" same
call "$job/image" -H "Range: bytes=100-" -H 'If-Range: "another"'
expect range-if-another "$status" 200
call "$job/image" -H "Range: bytes=-10"
expect range-suffix "$(header content-range)" "bytes $((size - 10))-$((size - 1))/$size"
call "$job/image" -H "Range: bytes=$size-"
expect_problem range-outside 416
expect range-outside-has-size "$(header content-range)" "bytes */$size"
call "$job/image" -H "Range: bytes=0-1,5-6"
expect several-ranges-get-all "$status" 200
call "$job/image?view=main&layer=beauty&format=png"
expect image-by-name "$status $(cmp "$work/body" "$work/whole" && echo same)" "200 same"
call "$job/image?format=png16"
expect png16-depth "$status $(od -An -j24 -N1 -tu1 "$work/body" | tr -d ' ')" "200 16"
expect png16-has-its-own-tag "$([ "$(header etag)" != "$tag" ] && echo other)" other
call "$job/image?format=pfm"
expect pfm-status "$status" 200
expect pfm-begins "$(head -c 2 "$work/body")" PF
expect pfm-size "$(wc -c <"$work/body" | tr -d ' ')" "$((64 * 48 * 12 + $(head -n 3 "$work/body" | wc -c)))"
call "$job/image?view=nowhere"
expect_problem unknown-view 404
call "$job/image?layer=depth"
expect_problem layer-not-requested 404

# Layers: the bytes are those of the command line.
picture=$job
submit '{"scene": "builtin:glass", "render": {"width": 64, "height": 48},
    "layers": ["depth", "cost", "albedo", "samples"], "cost": "tests"}'
expect layers-accepted "$status $(jq -c '[.layers, .cost]' "$work/body")" \
    '202 [["depth","cost","albedo","samples"],"tests"]'
call "$job?wait=60"
for layer in depth cost albedo samples; do
    tests=
    [ $layer != cost ] || tests='--cost tests'
    # shellcheck disable=SC2086
    "$build/penumbra" render builtin:glass --set width=64 --set height=48 --layer $layer $tests -q \
        -o "$work/$layer.pfm"
    call "$job/image?layer=$layer&format=pfm"
    expect "layer-$layer" "$status $(cmp "$work/body" "$work/$layer.pfm" && echo same)" "200 same"
    call "$job/image?layer=$layer"
    expect "layer-$layer-png" "$status $(header content-type)" "200 image/png"
    call "$job/image?layer=$layer&view=all&format=png16"
    expect "layer-$layer-sheet" "$status" 200
done
call "$job/image?layer=normal"
expect_problem layer-of-none 404
call "$job/image"
expect layers-and-beauty "$status $(header content-type)" "200 image/png"
job=$picture

# Preview, statistics, scene.
call "$job/preview"
expect preview "$status $(header content-type)" "200 image/png"
expect preview-is-rgba "$(od -An -j25 -N1 -tu1 "$work/body" | tr -d ' ')" 6
call "$job/stats"
expect stats-status "$status" 200
expect stats-primary-rays "$(body .rays.primary)" 3072
expect stats-parts "$(body '[has("timing", "threads", "tiles", "accelerator", "kernel", "effects", "host")] | all')" true
expect stats-rays-add-up "$(body '.rays | .primary + .shadow + .reflection + .transmission == .total')" true
call "$job/scene"
expect scene-as-accepted "$status $(body .format)" "200 penumbra-scene/1"
tag=$(header etag)
call "$job/scene" -H "If-None-Match: $tag"
expect scene-not-modified "$status" 304

# The same key gives the same job; with another body it is an error.
submit "$small" -H 'Idempotency-Key: once'
keyed=$job
submit "$small" -H 'Idempotency-Key: once'
expect repeat-is-the-same-job "$status $job" "202 $keyed"
submit "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 65, \"height\": 48}}" -H 'Idempotency-Key: once'
expect_problem key-with-another-body 422
submit "$small" -H "Idempotency-Key: $(head -c 256 /dev/zero | tr '\0' k)"
expect_problem key-too-long 400
submit "$small" -H 'Idempotency-Key;'
expect_problem key-empty 400
call "$keyed?wait=60"

# An unfinished job.
submit "$long"
big=$job
call "$big?wait=1"
expect_match unfinished-after-wait "$status $(body .state)" '200 [qr]u*'
expect unfinished-retry-after "$(header retry-after)" 1
expect unfinished-not-cached "$(header cache-control)" no-cache
call "$big/image"
expect_problem image-unfinished 409
expect image-unfinished-retry-after "$(header retry-after)" 1
call "$big/stats"
expect_problem stats-unfinished 409
call "$big/preview"
expect preview-unfinished "$status $(header content-type)" "200 image/png"
call "$big" -X DELETE
expect_problem delete-unfinished 409

# The place of jobs that wait behind it, since their priority is lower
big_runs() {
    call "$big"
    [ "$(body .state)" = running ]
}
within big_runs
# The queue is read again after 20 times as long as that took, which a halt of the daemon makes long
has_place() {
    call "$third"
    [ "$(body .queue_position)" = "$1" ]
}
waiting='{"scene": "builtin:spheres", "priority": -50, "render": {"width": 8, "height": 8}}'
submit "$waiting"
second=$job
submit "$waiting"
expect submit-without-place "$(body 'has("queue_position")')" false
third=$job
within has_place 3 # behind the big one, whose other batches come first
expect place-of-the-last "$(body .queue_position) $(header etag)" "3 W/\"$(body .revision)\""
expect eta-of-the-last "$(body '.progress.eta_seconds > 0')" true
tag=$(header etag)
call "$third" -H "If-None-Match: $tag"
expect weak-tag-not-modified "$status" 304
call "$second/cancel" -X POST
expect no-place-any-more "$(body 'has("queue_position")')" false
within has_place 2
expect place-moves-up "$(body .queue_position) $(header etag)" "2 $tag"
call "$big"
expect running-has-no-place "$(body 'has("queue_position")') $(header etag)" "false \"$(body .revision)\""
call "$third/cancel" -X POST

# A waiting GET ends when the job changes, here by a cancel.
curl -s "$url$big?wait=50" >"$work/waited" &
waiter=$!
sleep 0.5
begun=$(now_ms)
call "$big/cancel" -X POST
expect cancel "$status $(body .state)" "202 cancelled"
wait $waiter
took=$(($(now_ms) - begun))
expect wait-returns-the-cancelled-job "$(jq -r .state "$work/waited")" cancelled
timed wait-ends-with-the-job "$took" 1000
call "$big/cancel" -X POST
expect cancel-again "$status $(body .state)" "202 cancelled"
call "$first/cancel" -X POST
expect cancel-of-a-finished-job "$status $(body .state)" "202 succeeded"
call "$big/image"
expect_problem image-of-a-cancelled-job 409
expect no-retry-for-the-cancelled "$(header retry-after)" ""
call "$big/stats"
expect stats-of-a-cancelled-job "$status" 200

# Lists.
for _ in 1 2 3; do submit "$small"; done
call "$job?wait=60"
call "/v1/jobs?limit=2"
expect list-page "$status $(body '.jobs | length')" "200 2"
expect list-newest-first "$(body '.jobs[0].links.self')" "$job"
expect_match list-link "$(header link)" '</v1/jobs[?]limit=2&cursor=*>; rel="next"'
seen=$(body '.jobs[].id')
next=$(header link | sed 's/^<\(.*\)>.*/\1/')
while [ -n "$next" ]; do
    call "$next"
    seen="$seen $(body '.jobs[].id')"
    next=$(header link | sed -n 's/^<\(.*\)>.*/\1/p')
done
total=$(printf '%s\n' $seen | wc -l | tr -d ' ')
expect pages-hold-every-job-once "$total $(printf '%s\n' $seen | sort -u | wc -l | tr -d ' ')" "9 9"
call "/v1/jobs?state=cancelled"
expect list-by-state "$(body '[.jobs[].state] | unique | join(" ")')" cancelled
call "/v1/jobs?kind=benchmark"
expect list-of-another-kind "$status $(body '.jobs | length')" "200 0"
call "/v1/jobs?cursor=nonsense"
expect_problem foreign-cursor 400

# Removal: the statistics stay, everything else is gone.
call "$first/stats"
cp "$work/body" "$work/stats"
call "$first" -X DELETE
expect delete "$status" 204
expect delete-is-empty "$(wc -c <"$work/body" | tr -d ' ')" 0
call "$first"
expect_problem deleted-job 410 '*was removed; only its statistics are left*'
for part in image preview scene events report; do
    call "$first/$part"
    expect_problem "deleted-$part" 410
done
call "$first/cancel" -X POST
expect_problem cancel-deleted 410
call "$first" -X DELETE
expect_problem delete-again 410
call "$first/stats"
expect stats-stay "$status $(cmp "$work/body" "$work/stats" && echo same)" "200 same"
call "$first?stats=1" -X DELETE
expect_problem delete-parameter 400 '*allowed are false, true*'
call "$first?stats=true" -X DELETE
expect delete-stats "$status" 204
call "$first/stats"
expect_problem deleted-stats 410
call "$first?stats=true" -X DELETE
expect_problem delete-stats-again 410

# A key holds for 24 hours, but its job is gone.
last=$job
submit "$small" -H 'Idempotency-Key: brief'
expect key-of-a-job "$status" 202
call "$job?wait=60"
call "$job" -X DELETE
expect delete-with-key "$status" 204
submit "$small" -H 'Idempotency-Key: brief'
expect_problem key-of-a-deleted-job 410 '*which this Idempotency-Key made, was removed*'
job=$last

# What was accepted is still there after a restart.
daemon_stop
expect clean-end "$stopped" 0
daemon_start
call "$job"
expect job-after-restart "$status $(body .state)" "200 succeeded"
call "$job/image"
expect image-after-restart "$(cmp "$work/body" "$work/whole" && echo same)" same
# Lists by name and label
submit '{"scene": "builtin:spheres", "name": "night & day", "labels": {"shot": "12"}, "render": {"width": 8, "height": 8}}'
labelled=$(body .id)
call '/v1/jobs?label=shot:12&name=night%20%26%20day'
expect list-by-name-and-label "$(body '[.jobs[].id] | join(" ")')" "$labelled"
call '/v1/jobs?label=shot:13'
expect list-by-another-label "$(body '.jobs | length')" 0
call '/v1/jobs?label=shot'
expect_problem label-without-colon 400 '*label must be a key, a colon and a value*'
expect list-on-the-command-line "$("$build/penumbra" list --server "$url" --label shot:12 --name 'night & day' --json | jq -r '.jobs[].id')" "$labelled"

# A trace context is kept with the job and logged
trace=00-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01
call /v1/jobs -H 'Content-Type: application/json' -H "traceparent: $trace" -d "$small"
expect traced-job "$status $(body .traceparent)" "202 $trace"
call "/v1/jobs/$(body .id)"
expect trace-is-kept "$(body .traceparent)" "$trace"
within grep -q "traceparent=$trace" "$work/log" # after the answer was sent
expect trace-is-logged "$(grep -c "POST /v1/jobs 202 .* traceparent=$trace" "$work/log")" 1
for wrong in 01-4bf92f3577b34da6a3ce929d0e0e4736-00f067aa0ba902b7-01 00-4bf9-00f067aa0ba902b7-01 \
    00-00000000000000000000000000000000-00f067aa0ba902b7-01 "$trace-x" x; do
    call /v1/jobs -H 'Content-Type: application/json' -H "traceparent: $wrong" -d "$small"
    expect malformed-trace-is-ignored "$status $(body .traceparent)" "202 null"
done

finish
