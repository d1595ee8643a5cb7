#!/bin/sh
# SPDX-License-Identifier: MIT
# Health, built-in scenes, the API's own documents.
. "$(dirname "$0")/lib.sh"
daemon_start

call /healthz
expect healthz "$status $(body .status)" "200 ok"
call /readyz
expect readyz "$status $(body .status)" "200 ready"
expect readyz-is-not-cached "$(header cache-control)" no-store
call /healthz -I
expect healthz-head "$status" 200

call /v1/scenes
expect scenes "$status $(header content-type)" "200 application/json"
names=$(body '.scenes[].name')
expect scenes-are-the-folder "$(printf '%s\n' $names | sort | tr '\n' ' ')" \
    "$(ls scenes/*.json | sed 's|scenes/||; s|[.]json||' | sort | tr '\n' ' ')"
for name in $names; do
    call "/v1/scenes/$name"
    expect "scene $name" "$status $(cmp "$work/body" "scenes/$name.json" && echo same)" "200 same"
done
call /v1/scenes/spheres
tag=$(header etag)
call /v1/scenes/spheres -H "If-None-Match: $tag"
expect scene-not-modified "$status" 304
call /v1/scenes/sphere%73
expect scene-name-is-decoded "$status" 200

call /openapi.yaml
expect openapi "$status $(header content-type) $(cmp "$work/body" api/openapi.yaml && echo same)" \
    "200 application/yaml same"
tag=$(header etag)
call /openapi.yaml -H "If-None-Match: $tag"
expect openapi-not-modified "$status" 304
call /scene.schema.json
expect schema "$status $(cmp "$work/body" api/scene.schema.json && echo same)" "200 same"
tag=$(header etag)
call /scene.schema.json -H "If-None-Match: $tag"
expect schema-not-modified "$status" 304
call /healthz --request-target "http://localhost/v1/scenes/spheres"
expect absolute-form "$status $(body .name)" "200 spheres"
call /healthz --request-target "http://evil.com/v1/scenes/spheres"
[ -n "${PEN_TLS:-}" ] || # with tokens the Host does not matter
    expect_problem absolute-form-of-another-host 403

# A line of the log names the request, job, batch and attempt that it is about.
daemon_stop
daemon_start --log-format json --log-level debug
# A single tile is a single batch, which is not divided however long it takes
submit '{"scene": "builtin:spheres", "render": {"width": 64, "height": 48, "tile": 64}}' -H 'X-Request-Id: find.me-1'
call "$job?wait=60"
lines() { # FILTER: prints the number of JSON lines in the log that match
    grep '^{' "$work/log" | jq -c --arg job "${job##*/}" "select($1)" | wc -l | tr -d ' '
}
request='.process == "api" and .job == $job and .request == "find.me-1"'
request_is_logged() {
    [ "$(lines "$request")" -gt 0 ]
}
within request_is_logged # after its answer was sent; at its end the daemon does not wait long for lines
daemon_stop
expect log-names-the-request "$(lines "$request")" 1
expect log-names-the-batch "$(lines '.process == "worker" and .job == $job and .batch > 0 and .attempt == 1')" 1
finish
