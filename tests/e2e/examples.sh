#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs every script of api/examples and checks its output.
. "$(dirname "$0")/lib.sh"
threads=2
daemon_start
PENUMBRA_URL=$url
export PENUMBRA_URL
examples=api/examples

job=$(sh $examples/submit.sh)
expect_match submit "$job" '/v1/jobs/????????-*'
sh $examples/follow.sh "$job" >"$work/followed"
expect follow "$? $(tail -n 1 "$work/followed" | jq -r .state)" "0 succeeded"
sh $examples/events.sh "$job" >"$work/events"
expect events "$? $(tail -n 1 "$work/events")" "0 succeeded 100 %"
expect events-cover-the-picture "$(awk '/pixels at/ {split($2, side, "x"); n += side[1] * side[2]} END {print n}' "$work/events")" 19200
expect wait "$(sh $examples/wait.sh "$job")" succeeded
sh $examples/fetch.sh "$job" "$work/picture.png" "$work/stats.json"
expect fetch "$? $(head -c 4 "$work/picture.png" | tail -c 3) $(jq .rays.primary "$work/stats.json")" \
    "0 PNG 19200"
cp "$work/picture.png" "$work/before.png"
sh $examples/fetch.sh "$job" "$work/picture.png" "$work/stats.json"
expect fetch-again "$? $(cmp "$work/picture.png" "$work/before.png" && echo same)" "0 same"

key=$(sh $examples/retry.sh key-1)
expect retry "$(sh $examples/retry.sh key-1)" "$key"
expect_match retry-with-a-random-key "$(sh $examples/retry.sh)" '/v1/jobs/*'
expect list "$(sh $examples/list.sh | wc -l | tr -d ' ')" 3
job=$(sh $examples/submit-xml.sh)
expect_match submit-xml "$job" '/v1/jobs/????????-*'
expect submit-xml-renders "$(sh $examples/wait.sh "$job")" succeeded
expect submit-xml-a-file "$(sh $examples/wait.sh "$(sh $examples/submit-xml.sh tests/golden/xml/views.xml)")" \
    succeeded
expect list-names "$(sh $examples/list.sh | cut -f3 | grep -c '^example$')" 1

mkdir "$work/reports"
expect benchmark "$(sh $examples/benchmark.sh "$work/reports" | cut -d' ' -f1,2 | tr '\n' ' ')" \
    "none 1 none 2 auto 1 auto 2 "
expect benchmark-reports "$(cd "$work/reports" && echo *)" "report.csv report.html report.json report.md"

expect effects "$(sh $examples/effects.sh "$work/bill.html" | cut -d' ' -f1 | tr '\n' ' ')" \
    "ambient hard_shadows shadow_transmittance mirror transmission specular sky patterns refraction "
expect effects-page "$(head -n 1 "$work/bill.html")" "<!doctype html>"
explain() { # [SCENE.json]: after 10 s the answer is the job (202), which the script cannot print
    for _ in 1 2 3; do
        sh $examples/explain.sh "$@" >"$work/explained" && break
    done
    cat "$work/explained"
}
expect explain "$(explain | sed -n '1p;$p' | sed 's/[:0-9].*//' | tr '\n' ' ')" "ambient time "
expect explain-a-file "$(explain scenes/spheres.json | grep -c '^rays: ')" 1

submit "$long"
expect cancel "$(sh $examples/cancel.sh "$job")" cancelled
call "$job"
expect cancel-removes "$status" 410

expect validate "$(sh $examples/validate.sh scenes/spheres.json)" valid
echo '{"format": "penumbra-scene/1", "camera": {"position": [0,0,9], "look_at": [0,0,0]}, "fog": 1}' \
    >"$work/bad.json"
sh $examples/validate.sh "$work/bad.json" >"$work/output"
expect validate-refuses "$? $(grep -c '^  /fog: ' "$work/output")" "1 1"
printf '{"format": }' >"$work/bad.json"
sh $examples/validate.sh "$work/bad.json" >"$work/output"
expect_match validate-places-syntax "$? $(tail -n 1 "$work/output")" '1   1:1*: *'

expect every-example-is-run "$(for f in $examples/*.sh; do grep -q "/$(basename "$f")" "$0" || echo "$f"; done)" ""
finish
