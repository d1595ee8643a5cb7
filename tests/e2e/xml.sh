#!/bin/sh
# SPDX-License-Identifier: MIT
# Scenes in XML over HTTP: submit, validate, errors by line, and the scene as it was accepted.
. "$(dirname "$0")/lib.sh"
penumbra=$build/penumbra
daemon_start

xml=tests/golden/xml/primitives.xml
for type in 'application/xml' 'text/xml; charset=utf-8' 'application/x-www-form-urlencoded' ''; do
    call /v1/validate -H "Content-Type:${type:+ $type}" --data-binary "@$xml"
    expect "validate as ${type:-nothing}" "$status $(jq -c . "$work/body")" \
        '200 {"valid":true,"warnings":[]}'
done
call /v1/jobs --data-binary "@$xml"
expect "submitted without a type" "$status" 202
job=$(header location)
call "$job?wait=60"
expect "the job succeeds" "$(body .state)" succeeded
call "$job/image?format=pfm"
cp "$work/body" "$work/xml.pfm"
"$penumbra" render $xml -o "$work/local.pfm"
expect "its picture equals that of penumbra render" \
    "$(cmp "$work/xml.pfm" "$work/local.pfm" && echo same)" same
"$penumbra" render tests/golden/scenes/primitives.json -o "$work/json.pfm"
expect "and the picture of the same scene in JSON" \
    "$(cmp "$work/xml.pfm" "$work/json.pfm" && echo same)" same
call "$job/scene"
expect "GET scene gives the bytes that were sent" "$status $(cmp "$work/body" $xml && echo same)" \
    "200 same"
expect "GET scene has the type application/xml" "$(header content-type)" application/xml
call "$job" # the job's own settings are those of the XML
expect "the job's settings are those of the XML" "$(jq -c '.render | [.width, .height, .transfer]' "$work/body")" \
    "$(jq -c '.render | [.width, .height, "srgb"]' tests/golden/scenes/primitives.json)"

call /v1/jobs -H 'Content-Type: application/xml' -H 'Idempotency-Key: k' --data-binary "@$xml"
expect "submitted with a key" "$status" 202
first=$(jq -r .id "$work/body")
call /v1/jobs -H 'Content-Type: application/xml' -H 'Idempotency-Key: k' --data-binary "@$xml"
expect "submitted again with the same key, the same job" "$status $(jq -r .id "$work/body")" "202 $first"

# Errors have lines
bad='<scene>
  <lights><spot color="1 1 1" position="0 0 0" direction="0 0 1" beam-exponant="-1"/></lights>
  <geometries><sphere center="0 0 -9" radius="0"/></geometries>
</scene>'
for path in /v1/validate /v1/jobs; do
    call $path -H 'Content-Type: application/xml' --data-binary "$bad"
    expect_problem "$path: errors" 422 '*2 errors*'
    expect "$path: places" "$(jq -c '[.errors[] | [.line, .column]]' "$work/body")" '[[2,66],[3,39]]'
    expect "$path: names" "$(jq -r '.errors[0].detail' "$work/body")" \
        '<spot>: unknown attribute "beam-exponant"; did you mean "beam-exponent"?'
done
call /v1/validate -H 'Content-Type: application/xml' --data-binary '<scene>
</scen>'
expect_problem "not well-formed" 400 '*does not close <scene>*'
expect "a syntax error has line and column" "$(jq -c '.errors[0] | [.line, .column]' "$work/body")" '[2,1]'
for bomb in billion-laughs external-entity parameter-entity doctype-system utf16-no-mark utf16-surrogate zero-byte; do
    call /v1/jobs -H 'Content-Type: text/xml' --data-binary "@tests/io/corpus/xml-bad/$bomb.xml"
    expect_problem "$bomb" 400
done

# UTF-16, with and without a charset, is kept as it was sent
wide=tests/io/corpus/xml-spellings/utf16-le.xml
for type in 'application/xml' 'text/xml; charset=utf-16' ''; do
    call /v1/validate -H "Content-Type:${type:+ $type}" --data-binary "@$wide"
    expect "UTF-16 as ${type:-nothing}" "$status $(jq -c .valid "$work/body")" '200 true'
done
call /v1/jobs -H 'Content-Type: text/xml; charset=utf-16' --data-binary "@$wide"
call "$(header location)/scene"
expect "GET scene gives UTF-16 as it was sent" "$status $(cmp "$work/body" $wide && echo same)" "200 same"

# Line breaks that curl -d has removed: the same error, and a hint
typo='<?xml version="1.0"?>
<scene background-color="20 30 40">
  <geometries>
    <sphere center="1 2 -60" radios="15"/>
  </geometries>
</scene>'
printf '%s\n' "$typo" >"$work/typo.xml"
long="<scene><geometries><sphere center=\"1 2 -60\" radios=\"15\" name=\"$(printf %0200d 0)\"/></geometries></scene>"
lost='; the body has no line breaks: curl -d removes them, curl --data-binary does not'
hints() { jq -c "[.errors[] | [.line, .column, (.detail | contains(\"$lost\"))]]" "$work/body"; }
call /v1/validate --data-binary "@$work/typo.xml"
expect "an error behind line breaks" "$(hints)" '[[4,5,false],[4,30,false]]'
call /v1/validate -d "@$work/typo.xml"
expect "the same error without them has a hint" "$(hints)" '[[1,75,true],[1,100,false]]'
call /v1/jobs -d "$long"
expect "and so has an error in one long line" "$(hints)" '[[1,20,true],[1,45,false]]'
call /v1/validate -H 'Content-Type: application/xml' -d "$long"
expect "but none with a type of its own" "$(hints)" '[[1,20,false],[1,45,false]]'
call /v1/validate -d '<scene><fog/></scene>'
expect "and none in a short line" "$(jq -r .errors[0].detail "$work/body" | grep -c 'curl')" 0

call /v1/validate --data-binary "@tests/io/corpus/xml-good/notes.xml"
expect "warnings have line and column" "$(jq -c '[.warnings[] | [.line, .column]]' "$work/body")" \
    '[[1,1],[2,14],[4,29]]'
cat >"$work/far.xml" <<'SCENE'
<scene>
  <geometries>
    <sphere center="1e99 0 0" radius="1e-99"/>
  <sphere center="0 0 -9" radius="1"/></geometries>
  <render width="8" height="8"/>
</scene>
SCENE
call /v1/jobs -H 'Content-Type: application/xml' --data-binary "@$work/far.xml"
call "$(header location)?wait=60"
expect "an error of the worker has line and column, too" \
    "$(jq -c '.error.errors[0] | [.line, .column]' "$work/body")" '[3,5]'

# The command line
PENUMBRA_URL=$url
export PENUMBRA_URL
"$penumbra" submit $xml -q -o "$work/s.pfm" >/dev/null
expect "the picture of penumbra submit is the same" "$(cmp "$work/s.pfm" "$work/local.pfm" && echo same)" same
id=$("$penumbra" submit $xml --name from-xml --set samples_per_pixel=4 --wait -q)
call "/v1/jobs/$id"
expect "penumbra submit with options" "$(jq -c '[.name, .render.samples_per_pixel, .state]' "$work/body")" \
    '["from-xml",4,"succeeded"]'
call "/v1/jobs/$id/image?format=pfm"
"$penumbra" render $xml -o "$work/four.pfm" --set samples_per_pixel=4
expect "the picture of penumbra submit with options is the same" "$(cmp "$work/body" "$work/four.pfm" && echo same)" same
printf '%s' "$bad" >"$work/bad.xml"
"$penumbra" submit "$work/bad.xml" --name x 2>"$work/errors"
expect "penumbra submit of an invalid scene" "$? $(grep -c "bad.xml:[23]:[0-9]*: " "$work/errors")" "3 2"
"$penumbra" submit $xml --set width=20000 --set height=20000 2>"$work/errors"
expect "penumbra submit of too large a picture" "$?" 3
"$penumbra" submit - -q <$xml >"$work/id"
expect "penumbra submit from standard input" "$?" 0
finish
