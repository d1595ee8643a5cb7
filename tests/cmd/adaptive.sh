#!/bin/sh
# SPDX-License-Identifier: MIT
# A target error instead of numbers of samples: on the command line and as jobs.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
small="--set width=80 --set height=60"

# The command line
exits "a render to a target" 0 "$penumbra" render builtin:lens $small --set target_error=0.02 -o a.pfm --stats a.json --threads 2
prints "says what error is estimated" stderr "estimated error 0.0"
expect "which statistics have, too" "$(jq '.estimated_error <= .adaptive.interval[1] and .adaptive.interval[1] <= 0.02 and
    .adaptive.met and .adaptive.target_error == 0.02 and .adaptive.confidence == 0.99' a.json)" true
expect "and where samples went" "$(jq '.adaptive | .samples_per_pixel.min == 2 and .samples_per_pixel.max > 8 and
    .capped_pixels == 0 and .rounds[0].pixels == 4800 and (.rounds | length) > 2' a.json)" true
expect "rays are those of the samples" \
    "$(jq '(.rays.primary / 4800 - .adaptive.samples_per_pixel.mean) | fabs < 0.001' a.json)" true
exits "one thread, other tiles" 0 "$penumbra" render builtin:lens $small --set target_error=0.02 --set tile=7 \
    --set accelerator=none -q -o b.pfm --threads 1
check "give the same bytes" cmp a.pfm b.pfm
exits "a layer of samples" 0 "$penumbra" render builtin:lens $small --set target_error=0.02 --layer samples -o s.pfm --json
expect "whose largest is that of the statistics" "$(tail -c 57600 s.pfm | od -An -v -tf4 -w4 | sort -g | tail -n 1 | tr -d ' ')" \
    "$(jq .adaptive.samples_per_pixel.max a.json)"
exits "a pixel of it" 0 "$penumbra" render builtin:lens $small --set target_error=0.02 --pixel 40,30 --json
expect "has its samples" "$(jq '.rays.primary >= 2' stdout)" true
exits "a target out of reach" 0 "$penumbra" render builtin:lens $small --set target_error=0.001 --set max_samples=16 \
    -q -o c.pfm --stats c.json
prints "is told" stderr "above the target of 0.001: max_samples keeps"
expect "with how many pixels" "$(jq '(.adaptive.met | not) and .adaptive.capped_pixels > 100 and
    .adaptive.samples_per_pixel.max == 16' c.json)" true
exits "a grid of points on lights" 3 "$penumbra" render builtin:lens --set target_error=0.1 --set light_pattern=grid -o d.pfm
prints "is refused" stderr 'light_pattern is "grid"'
exits "one sample" 3 "$penumbra" render builtin:lens --set target_error=0.1 --set max_samples=1 -o d.pfm
prints "is too few" stderr "max_samples is 1; allowed with this target_error is 2 or more"
exits "three samples" 3 "$penumbra" render builtin:lens --set target_error=0.005 --set max_samples=3 -o d.pfm
prints "are too few for a finer picture" stderr "max_samples is 3; allowed with this target_error is 4 or more"
exits "an explanation" 0 "$penumbra" explain builtin:lens --set target_error=0.01 $small --json
expect "says what the target calls for" "$(jq -r '.effects[] | select(.name == "anti_aliasing").because' stdout)" \
    "target_error is 0.01"

# Jobs
daemon_start
PENUMBRA_URL=$url
export PENUMBRA_URL
exits "a job with a target" 0 "$penumbra" submit builtin:lens $small --set target_error=0.02 -q -o job.pfm
check "gives the bytes of the command line" cmp a.pfm job.pfm
submit '{"scene": "builtin:forest", "render": {"width": 40, "height": 30, "target_error": 0.01}, "layers": ["beauty", "samples", "cost"]}'
job=$(body .id)
exits "a job of several views, with layers" 0 "$penumbra" wait "$job" -q
call "/v1/jobs/$job/stats"
expect "its statistics are those of the worst view" \
    "$(body '.estimated_error > 0 and .estimated_error <= 0.01 and .adaptive.met | tostring')" true
exits "its samples" 0 "$penumbra" fetch "$job" --layer samples -o ls.pfm
exits "are those of a render" 0 "$penumbra" render builtin:forest --set width=40 --set height=30 --set target_error=0.01 \
    --layer samples -o rs.pfm -q
check "byte for byte" cmp ls.pfm rs.pfm
submit '{"scene": "builtin:lens", "render": {"target_error": 0.1, "light_pattern": "grid"}}'
expect_problem "a job with a grid of points on lights" 422 '*light_pattern is*'

# Budgets
budget() { # WIDTH HEIGHT SECONDS ARGUMENTS…
    width=$1 height=$2 seconds=$3
    shift 3
    "$penumbra" render builtin:room-soft --set "width=$width" --set "height=$height" --budget "$seconds" "$@"
}
exits "a render with a budget" 0 budget 100 140 0.3 -q -o t.pfm --stats t.json --threads 2
expect "has no target" "$(jq '.adaptive | .target_error == null and (.met | not)' t.json)" true
exits "its rounds repeated by one thread" 0 "$penumbra" render builtin:room-soft --repeat t.json -q -o r.pfm --threads 1
check "give the same bytes" cmp t.pfm r.pfm
jq '.adaptive.rule = 7' t.json >rule.json
exits "rounds of another rule" 4 "$penumbra" render builtin:room-soft --repeat rule.json -q -o w.pfm
prints "are refused by its number" stderr "has the rounds of rule 7 for a target error; this version has rule 2"
jq 'del(.adaptive.rule)' t.json >rule.json
exits "rounds without a rule" 4 "$penumbra" render builtin:room-soft --repeat rule.json -q -o w.pfm
prints "are of the first one" stderr "rule 1"
exits "lights out of focus with few samples" 0 "$penumbra" render "$root/tests/cmd/bokeh.json" --set max_samples=16 -q -o w.pfm --stats w.json
prints "are told of" stderr "of the pixels may show small or bright objects"
expect "by a share" "$(jq '.adaptive | .unproven > 0.01 and .unproven < 0.5 and (.met | not)' w.json)" true
exits "a budget that is too small" 0 budget 100 140 0 -q -o u.pfm --stats u.json
expect "gives the first round" "$(jq -c '.adaptive.rounds | map([.pixels, .tiles])' u.json)" "[[14000,20]]"
exits "a budget with a target" 0 budget 50 70 1000 --set target_error=0.01 -q -o t.pfm --stats t.json
expect "ends when that is met" "$(jq '.adaptive | .met and .target_error == 0.01 and (.rounds | length) > 2' t.json)" true
jq '.adaptive.rounds |= .[:3] | .adaptive.rounds[2].tiles = 3' t.json >part.json
for threads in 1 2; do
    exits "a round that a time had ended" 0 "$penumbra" render builtin:room-soft --repeat part.json --threads "$threads" \
        -q -o "p$threads.pfm"
done
check "gives the same bytes with any number of threads" cmp p1.pfm p2.pfm
check "which are not those of the whole rounds" test "$(cmp -s p1.pfm t.pfm; echo $?)" = 1
exits "rounds of another scene" 4 "$penumbra" render builtin:room --repeat t.json -q -o w.pfm
prints "are refused" stderr "is of another scene"
exits "statistics without a budget" 3 "$penumbra" render builtin:lens --repeat a.json -q -o w.pfm
prints "say what they lack" stderr "has no scene_sha256"
jq '.adaptive.rounds[1].pixels += 1' t.json >bad.json
exits "rounds that were changed" 4 "$penumbra" render builtin:room-soft --repeat bad.json -q -o w.pfm
prints "do not fit" stderr "round 1 refines"
exits "both" 2 budget 10 10 1 --repeat t.json -q -o w.pfm
exits "a job with a budget" 0 "$penumbra" submit builtin:room-soft --set width=100 --set height=140 --budget 0.5 -q -o jt.pfm --json
job=$(jq -r .id stdout)
call "/v1/jobs/$job"
expect "says so" "$(body .budget_seconds)" 0.5
call "/v1/jobs/$job/stats"
cp body jt.json
call "/v1/jobs/$job/scene"
cp body scene.json
exits "its rounds, repeated from its scene" 0 "$penumbra" render scene.json --repeat jt.json -q -o jr.pfm
check "give the bytes of the job" cmp jt.pfm jr.pfm
submit '{"scene": "builtin:forest", "budget_seconds": 1, "views": ["front", "left"]}'
expect_problem "a budget for several views" 422 "*must name one view*"
submit '{"scene": "builtin:lens", "budget_seconds": 0}'
expect_problem "a budget of 0" 422 '*must be a number above 0*'

# Audits
audit="pixels threshold wrong undecided bound seed clusters"
exits "a render with an audit" 0 "$penumbra" render builtin:lens $small --view middle --set target_error=0.02 -q -o a.pfm --stats a.json \
    --audit 0.05 --audit-pixels 200
expect "has what it found" "$(jq -r '.audit | keys_unsorted | join(" ")' a.json)" "$audit"
expect "of so many pixels" "$(jq -c '.audit | [.pixels, .threshold, .wrong + .undecided < 100]' a.json)" "[200,0.05,true]"
exits "a job with an audit" 0 "$penumbra" submit builtin:lens $small --view middle --set target_error=0.02 -q -o job.pfm --json \
    --audit 0.05 --audit-pixels 200
call "/v1/jobs/$(jq -r .id stdout)/stats"
expect "finds the same" "$(body '.audit | tostring')" "$(jq -c .audit a.json)"
submit '{"scene": "builtin:spheres", "render": {"width": 640, "height": 480, "light_samples": 64, "samples_per_pixel": 4},
    "audit": {}}'
job=$(body .id)
expect "an audit has defaults" "$(body '.audit | tostring')" '{"pixels":600,"threshold":0.01}'
exits "a job of several batches" 0 "$penumbra" wait "$job" -q
call "/v1/jobs/$job/stats"
expect "is audited when its picture is whole" "$(body '.audit | [.pixels, .threshold] | tostring')" "[600,0.01]"
submit '{"scene": "builtin:lens", "audit": {"pixels": 0}}'
expect_problem "an audit of no pixel" 422 '*must be an integer from 1 to 1000000*'
submit '{"scene": "builtin:lens", "audit": {"threshold": 1}}'
expect_problem "a threshold of 1" 422 '*above 0 and below 1*'
submit '{"scene": "builtin:lens", "audit": {"pixel": 9}}'
expect_problem "an unknown key" 422 '*the keys here are pixels, threshold*'
submit '{"scene": "builtin:lens", "audit": 5}'
expect_problem "an audit that is a number" 422 '*must be an object of pixels and threshold*'
exits "the audit of a file" 0 "$penumbra" audit builtin:lens a.pfm $small --threshold 0.05 --audit-pixels 200 --json
expect "draws the same pixels" "$(jq -r .seed stdout)" "$(jq -r .audit.seed a.json)"
exits "with --max-wrong" 7 "$penumbra" audit builtin:lens a.pfm $small --threshold 0.001 --audit-pixels 20 --max-wrong 0.1
exits "a picture of one sample" 0 "$penumbra" render builtin:lens $small --view middle --set samples_per_pixel=1 -q -o one.pfm
exits "its audit" 0 "$penumbra" audit builtin:lens one.pfm $small --threshold 0.05 --audit-pixels 200 --view middle
prints "tells where pixels are wrong" stdout "audited pixels are wrong in columns"
exits "a picture of another size" 3 "$penumbra" audit builtin:lens a.pfm
prints "is told both sizes" stderr "has 80 x 60 pixels, the scene is rendered with 800 x 600"
exits "no picture" 4 "$penumbra" audit builtin:lens none.png $small
exits "a file that is none" 3 "$penumbra" audit builtin:lens a.json $small
finish
