#!/bin/sh
# SPDX-License-Identifier: MIT
# Every class of bad input gets its HTTP status and a problem document that names the error.
. "$(dirname "$0")/lib.sh"
daemon_start
none=/v1/jobs/01890a5d-ac96-774b-bcce-b302099a8057

# Paths and methods.
for path in /nowhere /v1 /v1/ /v1/jobs/ //v1/jobs /v1/jobs/x /v1/jobs/$none/image /v1/scenes/nothing \
    "$none" "$none/events" "$none/image" "$none/preview" "$none/stats" "$none/scene" "$none/report"; do
    call "$path" --path-as-is
    expect_problem "GET $path" 404
done
for path in /v1/plan /v1/assets/abc; do
    call "$path"
    expect_problem "GET $path" 404 '*not supported yet*'
done
call "/v1/jobs/%"
expect_problem bad-escape 400 '*percent-encoding*'
call "/%76%31/jobs"
expect escaped-path "$status" 200
while read -r method path allow; do
    call "$path" -X "$method"
    expect_problem "$method $path" 405
    expect "$method $path allows" "$(header allow)" "$allow"
done <<END
PUT /v1/jobs POST, GET, HEAD
DELETE /v1/jobs POST, GET, HEAD
POST $none GET, HEAD, DELETE
GET $none/cancel POST
PATCH $none/image GET, HEAD
GET /v1/validate POST
POST /healthz GET, HEAD
OPTIONS /v1/scenes GET, HEAD
BREW /readyz GET, HEAD
END

# Query parameters: the answer names the parameter and what is allowed.
while read -r path pattern; do
    call "$path"
    expect_problem "GET $path" 400 "$pattern"
done <<END
/v1/jobs?limt=5 *limt*did*you*mean*limit*state,*kind,*limit,*cursor*
/v1/jobs?limit=0 *limit*1*to*500*
/v1/jobs?limit=501 *limit*1*to*500*
/v1/jobs?limit=ten *limit*1*to*500*
/v1/jobs?limit= *limit*1*to*500*
/v1/jobs?limit=5&limit=5 *limit*twice*
/v1/jobs?state=quued *state*did*you*mean*queued*
/v1/jobs?state=QUEUED *state*queued,*running*
/v1/jobs?kind=movie *kind*render*
/v1/jobs?cursor= *cursor*
$none?wait=61 *wait*0*to*60*
$none?wait=-1 *wait*0*to*60*
$none?wait=1.5 *wait*0*to*60*
$none?view=main *view*wait*
$none/image?layer=beaty *layer*did*you*mean*beauty*
$none/image?format=gif *format*png,*png16,*pfm*
$none/image?fmt=png *fmt*view,*layer,*format*
$none/stats?x=1 *x*so_far*
/healthz?verbose *verbose*none*is*allowed*
/v1/jobs?a=%zz *percent-encoding*
/v1/jobs?name=%00 *encoded*zero*byte*
END

# Bodies: length, type, size.
call /v1/jobs -X POST
expect_problem no-length 411
call /v1/jobs -H 'Transfer-Encoding: chunked' -d "$small"
expect chunked "$status" 202
call /v1/validate -H 'Transfer-Encoding: chunked' -d '{}'
expect_problem chunked-validate 422
call /v1/jobs -X GET -H 'Transfer-Encoding: chunked' -d '{}'
expect chunked-get "$status" 200
call /v1/jobs -H 'Transfer-Encoding: gzip' -H 'Content-Length:' -d '{}'
expect_problem coded-transfer 400 '*Transfer-Encoding*chunked*'
head -c 16777217 /dev/zero >"$work/big"
call /v1/jobs --data-binary "@$work/big"
expect_problem too-large 413 '*16777217*16777216*'
# curl waits for the answer to its Expect field; by default it sends the body after a second all the same
expect too-large-was-not-sent "$(curl -s -o /dev/null -w '%{size_upload}' --expect100-timeout 60 --data-binary "@$work/big" "$url/v1/jobs")" 0
call /v1/jobs -H 'Expect:' --data-binary "@$work/big"
expect_problem too-large-without-asking 413
call /v1/jobs -H 'Transfer-Encoding: chunked' -H 'Expect:' --data-binary "@$work/big"
expect_problem too-large-in-chunks 413 '*16777216*'
call /v1/validate --data-binary "@$work/big"
expect_problem too-large-to-validate 413
call "$none" -X DELETE -H 'Expect:' --data-binary "@$work/big"
expect_problem too-large-for-nothing 413
call /v1/jobs -H 'Content-Length: 99999999999999999999999999' -H 'Expect:' -d '{}'
expect length-beyond-64-bits "$status" 413 # libmicrohttpd's own page
call /nowhere --data-binary "@$work/big"
expect_problem large-to-nowhere 404
for type in text/plain multipart/form-data application/octet-stream 'application/json; charset=latin1'; do
    call /v1/jobs -H "Content-Type: $type" -d '{}'
    expect_problem "type $type" 415 '*application/json*'
done
call /v1/jobs -H 'Content-Type;' -d '{}'
expect_problem empty-type 415 '*of type ""*'
for type in application/xml text/xml; do
    call /v1/jobs -H "Content-Type: $type" -d '{}'
    expect_problem "no xml, but type $type" 400 '*not well-formed*'
done
call /v1/jobs -H 'Content-Type: application/json; charset=utf-16' -d '{}'
expect_problem json-in-utf-16 415 '*application/json in UTF-8*'
call /v1/jobs -H 'Content-Type: application/json' -d '<scene/>'
expect_problem xml-as-json 400 '*not JSON*'
call /v1/jobs -d ' <scene><sphere/></scene>'
expect_problem looks-like-xml 422 '*unknown element*'
call /v1/jobs -H 'Content-Type:' --data-binary "$small"
expect no-type-is-json "$status" 202
call /v1/jobs -d "$small"
expect form-type-is-json "$status" 202
call /v1/jobs -H 'Content-Type: Application/JSON ; charset=utf-8' -d "$small"
expect json-with-charset "$status" 202

# Hosts and origins.
port=${url##*:}
for host in evil.com "evil.com:$port" 127.0.0.2 localhost.evil.com ''; do
    call /healthz -H "Host: $host" --http1.0
    expect_problem "host <$host>" 403
done
for host in localhost "LOCALHOST:$port" 127.0.0.1:1 '[::1]' '[::1]:99'; do
    call /healthz -H "Host: $host"
    expect "host $host" "$status" 200
done
call /v1/jobs -H 'Origin: http://evil.com' -d "$small"
expect_problem foreign-page 403 '*evil.com*'
call /v1/jobs -H "Origin: $url" -d "$small"
expect own-page "$status" 202
call /v1/jobs -H 'Origin: http://evil.com'
expect_problem foreign-page-reads 403 '*evil.com*'
call /healthz -H 'Origin: null'
expect_problem page-without-origin 403 '*null*'

# Malformed JSON: the first error, by line and column.
while read -r name json; do
    call /v1/jobs -H 'Content-Type: application/json' --data-binary "$json"
    expect_problem "syntax $name" 400
    expect "syntax $name has a place" "$(body '.errors | length == 1 and .[0].line > 0 and .[0].column > 0')" true
done <<'END'
empty-object-open {
trailing-comma {"scene": "builtin:spheres",}
duplicate-key {"scene": "builtin:spheres", "scene": "builtin:spheres"}
nan {"scene": "builtin:spheres", "priority": NaN}
overflow {"scene": "builtin:spheres", "priority": 1e999}
two-values {} {}
END
call /v1/jobs -H 'Content-Type: application/json' -d ''
expect_problem empty-body 400

# Invalid jobs and scenes: every place by JSON Pointer.
while read -r name pointer json; do
    for path in /v1/jobs /v1/validate; do
        call $path -H 'Content-Type: application/json' --data-binary "$json"
        expect_problem "$path $name" 422
        expect "$path $name pointer" "$(body '.errors[0].pointer')" "${pointer#-}"
    done
done <<'END'
neither-job-nor-scene - {}
scene-of-a-wrong-type /scene {"scene": 5}
unknown-key /prioriti {"scene": "builtin:spheres", "prioriti": 1}
priority /priority {"scene": "builtin:spheres", "priority": 101}
attempts /max_attempts {"scene": "builtin:spheres", "max_attempts": 0}
setting /render/widht {"scene": "builtin:spheres", "render": {"widht": 5}}
radius /scene/objects/0/radius {"scene": {"format": "penumbra-scene/1", "camera": {"position": [0,0,9], "look_at": [0,0,0]}, "objects": [{"type": "sphere", "center": [0,0,0], "radius": -1}]}}
bare-radius /objects/0/radius {"format": "penumbra-scene/1", "camera": {"position": [0,0,9], "look_at": [0,0,0]}, "objects": [{"type": "sphere", "center": [0,0,0], "radius": -1}]}
ladder /ladder/threads {"scene": "builtin:spheres", "kind": "accuracy", "ladder": {"threads": [1, 2]}}
unknown-kind /kind {"scene": "builtin:spheres", "kind": "benchmrk"}
setting-to-come /render/precision {"scene": "builtin:spheres", "render": {"precision": "fast"}}
END
call /v1/jobs -H 'Content-Type: application/json' --data-binary '{"scene": "builtin:rom"}'
expect_problem unknown-builtin 404
expect unknown-builtin-pointer "$(body '.errors[0].pointer')" /scene
expect_match nearest-scene "$(body '.errors[0].detail')" '*room*'
call /v1/jobs -d '{"scene": "builtin:spheres", "render": {"width": 10000, "height": 10000}}'
expect_problem too-many-pixels 413
call /v1/jobs -d '{"scene": "builtin:spheres", "render": {"width": 8000, "height": 8000, "samples_per_pixel": 1000000}}'
expect_problem too-much-work 413

# Validation of valid documents.
call /v1/validate -d "$small"
expect validate-job "$status $(body '.valid, (.warnings | type)' | tr '\n' ' ')" "200 true array "
call /v1/scenes/spheres
cp "$work/body" "$work/scene"
call /v1/validate -H 'Content-Type: application/json' --data-binary "@$work/scene"
expect validate-scene "$status $(body .valid)" "200 true"

# A wrong body does not close the connection; a request that is refused before its body is read does.
codes=$(curl -s -o /dev/null -o /dev/null -o /dev/null -o /dev/null -w '%{http_code} %{num_connects} ' \
    -d '{' "$url/v1/jobs" "$url/v1/validate" "$url/nowhere" "$url/v1/validate")
expect refusals-keep-the-connection "$codes" "400 1 400 0 404 0 400 1 "
call /healthz -H 'X-Request-Id: my-id.1'
expect request-id-taken "$(header x-request-id)" my-id.1
call /nowhere -H 'X-Request-Id: my id'
expect_match request-id-made "$(header x-request-id)" '????????-??????'
expect request-id-in-the-problem "$(body .request_id)" "$(header x-request-id)"
finish
