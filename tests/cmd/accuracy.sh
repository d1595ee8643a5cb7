#!/bin/sh
# SPDX-License-Identifier: MIT
# Accuracy studies: `penumbra accuracy` without a daemon, and jobs of that kind.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

small="--set width=40 --set height=30 --set samples_per_pixel=1 --set light_samples=16 --seeds 2"
ladder="--ladder light_samples=1,4,16"
loops=

# Without a daemon
exits "a study" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder
expect "has a line for each row, and a title" "$(sed -n '/^row  settings/,/^$/p' stdout | wc -l | tr -d ' ')" 5
prints "says which row meets the target" stdout "FLIP at most 0.02 in 95 % of its runs"
prints "and how fast errors fall" stdout "light_samples: the error is proportional to N to the power of -"
prints "it says beforehand what it will take" stderr "3 rows, 2 seeds: expected to take"
for form in json csv md html; do
    exits "the study as $form" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder -q -o "r.$form"
    expect "accuracy -q prints nothing" "$(cat stdout stderr)" ""
done
expect "JSON has the rows" "$(jq -c '[.kind, .rows[].settings.light_samples]' r.json)" '["accuracy",1,4,16]'
expect "rows have times, rays and metrics" "$(jq '[.rows[] | (.min_ms <= .median_ms and .median_ms <= .max_ms
    and .rays.primary == 1200 and .runs == 2 and .resolved and .pareto != null and .efficiency > 0
    and .rmse > 0 and .relative_mse > 0 and .psnr > 0 and .ssim < 1 and .flip > 0 and .max_error >= .rmse
    and .spread.rmse[0] <= .rmse and .rmse <= .spread.rmse[1])] | all' r.json)" true
expect "errors fall from row to row" "$(jq '[.rows[].rmse] == ([.rows[].rmse] | sort | reverse)' r.json)" true
expect "the reference is at least five times as good" "$(jq '.reference.error <= ([.rows[].rmse] | min) / 5' r.json)" true
expect "its samples are several times those of the longest row" "$(jq '.reference.settings.light_samples >= 128' r.json)" true
expect "nothing is left out" "$(jq -c .left_out r.json)" "[]"
expect "CSV has a line for each row" "$(wc -l <r.csv | tr -d ' ')" 4
expect "Markdown has a table" "$(grep -c '^|' r.md)" 5
expect "HTML has the pictures and error maps of three rows, the reference, and the time of pixels" \
    "$(grep -o '<figure class="[a-z]*"' r.html | sort | uniq -c | tr -s ' \n' ' ')" \
    ' 1 <figure class="cost" 3 <figure class="map" 3 <figure class="picture" 1 <figure class="reference" '
expect "HTML has a script and its data" "$(grep -c '<script' r.html)" 2
exits "standard output as JSON" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder --json
expect "is the report" "$(jq -r .kind stdout)" accuracy

exits "two studies are compared" 0 "$penumbra" compare r.json r.json
prints "with their errors" stdout "RMSE"
exits "the same study again gives the same pictures" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder -q -o again.json
exits "and is equal but for times" 0 "$penumbra" compare r.json again.json --json
expect "the errors are the same" "$(jq '[.rows[].errors | .rmse[0] == .rmse[1] and .flip[0] == .flip[1]] | all' stdout)" true
exits "a study of another pattern" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder --set seed=9 -q -o other.json
jq 'del(.render.seed)' other.json >seedless.json
exits "other pictures are told" 7 "$penumbra" compare r.json seedless.json
exits "a study and a picture" 3 "$penumbra" compare r.json r.csv
exits "a target that no row meets" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder --target psnr=200 -q -o t.json
expect "recommends none" "$(jq -c .recommended t.json)" null
exits "and says what it would need" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder --target flip=0.001
answer=$(sed -n '/^None below/p; /No row is recommended/p' stdout)
case $answer in
    *"No row is recommended"*) ;;
    *) expect_match "by how errors fall" "$answer" \
        "None below the target, FLIP 0.001 in 95 % of its runs, in 60 s: light_samples * would be needed*" ;;
esac
exits "a study over lights, with four samples of the edges" 0 "$penumbra" accuracy builtin:soft-shadow --set width=80 --set height=50 --seeds 1 \
    --ladder light_samples=1,4,16,64
prints "names the error that is left" stdout "does not come from soft shadows, but from edges, which take more than samples_per_pixel 4."
exits "the default ladder" 0 "$penumbra" accuracy builtin:soft-shadow --set width=40 --set height=25 --seeds 1 -q -o l.json
expect "tries the setting that helps" "$(jq -c '.convergence[] | select(.setting == "samples_per_pixel").floor' l.json)" null

# Beside two programs that use both processors a study recommends what it did before, or nothing.
busy="--set width=160 --set height=120 --set samples_per_pixel=1 --seeds 3 --ladder light_samples=1,64 --target flip=0.9"
for _ in 1 2 3 4; do
    sh -c 'while :; do :; done' &
    loops="$loops $!"
done
exits "a study on a busy machine" 0 "$penumbra" accuracy builtin:soft-shadow $busy -o b.json
kill $loops
case $(jq -c '[.recommended.row, 2 * .timing.spoiled > .timing.runs]' b.json) in
    '[null,true]') expect "begins with its spoiled runs" "$(sed -n 1p stdout | grep -c 'runs are spoiled: other programs')" 1 ;;
    '[1,false]') ;;
    *) not_ok "recommends the cheapest row, or nothing" "$(jq -c '[.recommended, .timing]' b.json)" ;;
esac
exits "the cheapest row for a target" 0 "$penumbra" accuracy builtin:soft-shadow $small $ladder --target flip=0.9 -q -o t.json
row=$(jq .recommended.row t.json)
if [ "$(jq '2 * .timing.spoiled > .timing.runs' t.json)" = true ]; then
    expect "is not told of spoiled runs" "$row" null
else
    expect "is the one with the fewest rays, or a quicker one" \
        "$(jq ".rows | .[$row].rays.total == (map(.rays.total) | min) or .[$row].max_ms < .[0].min_ms" t.json)" true
fi
exits "a product" 0 "$penumbra" accuracy builtin:soft-shadow $small --ladder light_samples=1,4,9 --ladder \
    light_pattern=sobol,random --product -q -o p.json
expect "has all combinations" "$(jq '.rows | length' p.json)" 6
expect "and two slopes" "$(jq -c '[.convergence[].with.light_pattern]' p.json)" '["sobol","random"]'
exits "a study without a ladder" 0 "$penumbra" accuracy builtin:lens $small --set width=12 --set height=9 -q -o l.json
expect "takes the samples that the scene calls for" "$(jq '.rows[0].settings | has("lens_samples")' l.json)" true
exits "a scene where nothing is random" 0 "$penumbra" accuracy builtin:room $small --ladder max_depth=1,2,14 -q -o d.json
expect "has a reference without error" "$(jq .reference.error d.json)" 0

exits "a key on which accuracy does not depend" 2 "$penumbra" accuracy builtin:soft-shadow --ladder threads=1,2
prints "the error names the option" stderr "--ladder threads: must be a setting on which accuracy depends"
exits "a wrong value" 2 "$penumbra" accuracy builtin:soft-shadow --ladder light_samples=1,0
prints "the error names the option" stderr "--ladder light_samples: must be an integer of at least 1, found 0"
exits "a ladder without values" 2 "$penumbra" accuracy builtin:soft-shadow --ladder light_samples
prints "the error shows the form" stderr "allowed is KEY=VALUE,…"
exits "a wrong target" 2 "$penumbra" accuracy builtin:soft-shadow --target flop=1
prints "the error lists the metrics" stderr "must be one of rmse"
exits "a target without a value" 2 "$penumbra" accuracy builtin:soft-shadow --target flip
prints "the error shows the form" stderr "allowed is METRIC=VALUE"
exits "a reference with a target error" 2 "$penumbra" accuracy builtin:soft-shadow --reference target_error=0.1
prints "the error says why" stderr "fixed numbers of samples"

# As jobs
daemon_start
PENUMBRA_URL=$url
export PENUMBRA_URL
study="--kind accuracy $small $ladder"
for form in html json csv md; do
    exits "submit and fetch as $form" 0 "$penumbra" submit builtin:soft-shadow $study -q -o "j.$form"
done
facts='.rows | map({settings, rays, rmse, flip, resolved})'
expect "gives the same errors" "$(jq -cS "$facts" j.json)" "$(jq -cS "$facts" r.json)"
job=$("$penumbra" submit builtin:soft-shadow $study --budget 50 --product)
exits "wait for a study" 0 "$penumbra" wait "$job"
call "/v1/jobs/$job"
expect "its progress counts all runs" "$(body '.progress | [.done, .total] | tostring')" "[9,9]"
expect "the job says what it was asked" "$(body '[.kind, .seeds, .budget_seconds, .product, .ladder.light_samples, .target.metric] | tostring')" \
    '["accuracy",2,50,true,[1,4,16],"flip"]'
call "/v1/jobs/$job/report"
expect "GET report gives the page" "$status $(header content-type)" "200 text/html; charset=utf-8"
call "/v1/jobs/$job/report" -H 'Accept: text/csv'
expect "or CSV" "$status $(header content-type)" "200 text/csv; charset=utf-8"
call "/v1/jobs/$job/stats"
expect "statistics are those of a row" "$(body .rays.primary)" 1200
submit '{"scene": "builtin:spheres", "kind": "accuracy", "ladder": {"tile": [1]}}'
expect_problem "a wrong ladder" 422 '*on which accuracy depends*'
submit '{"scene": "builtin:spheres", "ladder": {"light_samples": [1]}}'
expect_problem "a ladder in a render" 422 '*belongs to jobs of kind*accuracy*'

# A cancelled one. That a study goes on when its worker dies, and gives way to a job of higher priority, is in
# tests/jobs/test_study_kept.c, and of a daemon's bill in effect_jobs.sh.
lengthy="--kind accuracy --set width=200 --set height=150 --ladder light_samples=256,257,258,259 --seeds 64"
job=$("$penumbra" submit builtin:soft-shadow $lengthy)
within has_runs "$job" 2 || not_ok "progress counts runs during a study" "$(done_runs "$job")"
"$penumbra" cancel "$job" >/dev/null
render=$("$penumbra" submit builtin:spheres --set width=20 --set height=20)
exits "after a cancelled study the next job runs" 0 "$penumbra" wait "$render" -q

finish
