#!/bin/sh
# SPDX-License-Identifier: MIT
# The page's files are served as they are, open to everybody, with headers that keep foreign scripts out.
. "$(dirname "$0")/lib.sh"
nobody='Authorization: Bearer wrong'
if [ -n "${PEN_TLS:-}" ]; then # there are tokens already, and curl sends one
    nobody='Accept: */*'
    somebody=$nobody
    daemon_start
else
    somebody="Authorization: Bearer $("$build/penumbrad" token add page --scope submit --tokens "$work/tokens" 2>>"$work/log")"
    daemon_start --tokens "$work/tokens"
fi

call / -H "$nobody"
expect page "$status $(header content-type) $(cmp "$work/body" api/page/index.html && echo same)" \
    "200 text/html; charset=utf-8 same"
policy=$(header content-security-policy)
# A report that the page shows in a frame inherits the policy: its script and style are known by hashes.
for part in script style; do
    expect_match "$part-by-hash" "$policy;" "*$part-src 'self' 'sha256-????????????????????????????????????????????';*"
done
for rule in "default-src 'none'" "connect-src 'self'" \
    "img-src 'self' blob: data:" 'frame-src blob:' "base-uri 'none'" "form-action 'none'" "frame-ancestors 'none'"; do
    expect_match "policy-has $rule" "$policy;" "*$rule;*"
done
case $policy in *unsafe*) not_ok policy-is-safe "$policy" ;; *) ok policy-is-safe ;; esac
expect page-headers "$(header x-content-type-options) $(header referrer-policy) $(header cache-control)" \
    "nosniff no-referrer no-cache"
call / -I
expect page-head "$status $(header content-length)" "200 $(wc -c <api/page/index.html | tr -d ' ')"
call '/?x=1'
expect_problem page-parameter 400
call / -X POST -H "$somebody"
expect_problem page-post 405

# What its script does: a POST names the page's origin, and events come through fetch with the token.
for origin in "$url" "$(echo "$url" | sed 's/127.0.0.1/localhost/')"; do
    call /v1/jobs -H "$somebody" -H "Origin: $origin" -H "Host: ${origin#*//}" -d "$small"
    expect "post-from $origin" "$status" 202
done
job=$(header location)
call "$job?wait=60" -H "$somebody"
call "$job/events" -H "$somebody" -H 'Accept: text/event-stream'
expect events "$status $(header content-type) $(grep -c '^event: tile' "$work/body" | sed 's/[1-9][0-9]*/some/')" \
    "200 text/event-stream some"

for file in api/page/*; do
    name=${file##*/}
    call "/page/$name" -H "$nobody"
    case $name in
    report.*)
        expect_problem "$name-is-no-file-of-the-page" 404
        continue
        ;;
    *.html) type='text/html; charset=utf-8' ;;
    *.css) type='text/css; charset=utf-8' ;;
    *.js) type='text/javascript; charset=utf-8' ;;
    *.svg) type=image/svg+xml ;;
    *.png) type=image/png ;;
    *.json) type=application/json ;;
    *) type=unknown ;;
    esac
    expect "$name" "$status $(header content-type) $(header x-content-type-options) $(header cache-control) $(cmp "$work/body" "$file" && echo same)" \
        "200 $type nosniff no-cache same"
    tag=$(header etag)
    call "/page/$name" -H "If-None-Match: $tag"
    expect "$name-not-modified" "$status" 304
    call "/page/$name" --compressed
    expect "$name-compressed" "$status $(cmp "$work/body" "$file" && echo same)" "200 same"
done
for name in nothing.js ../openapi.yaml ..%2fopenapi.yaml index.html/ ''; do
    call "/page/$name" --path-as-is -H "$somebody"
    expect "no page/$name" "$status" 404
done
finish
