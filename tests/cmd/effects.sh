#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbra effects`, `penumbra explain` and the layers of `penumbra render`, without a daemon.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

small="--set width=40 --set height=30 --repeats 2"

exits "the bill of a scene" 0 "$penumbra" effects builtin:glass $small
sed -n '/^row  without/,/^$/p' stdout >table
expect "a line for all effects, and for each" "$(sed '/^$/,$d' table | wc -l | tr -d ' ')" 11
prints "each effect is named" stdout "refraction"
for form in json csv md html; do
    exits "the bill as $form" 0 "$penumbra" effects builtin:glass $small -q -o "r.$form"
    expect "effects -q prints nothing" "$(cat stdout stderr)" ""
done
expect "JSON has the rows" "$(jq -c '[.rows[].without] | join(" ")' r.json)" \
    '" ambient hard_shadows shadow_transmittance mirror transmission specular sky patterns refraction"'
expect "rows have times, rays and differences" "$(jq '[.rows[1:][] | (.min_ms <= .median_ms
    and .median_ms <= .max_ms and .rays.primary == 1200 and .rmse > 0 and .max_error >= .rmse
    and .flip > 0 and .flip < 1
    and has("cost_ms") and has("cost_share")
    and (.cost_ms != null) != has("cost_below_ms"))] | all' r.json)" true
expect "no cost is told of spoiled runs" "$(jq '2 * .timing.spoiled > .timing.runs and any(.rows[]; .cost_ms)' r.json)" false
expect "without transmission there are no such rays" \
    "$(jq '.rows[] | select(.without == "transmission") | .rays.transmission' r.json)" 0
expect "the first row differs by nothing" "$(jq -c '.rows[0] | [.rmse, .max_error, .flip]' r.json)" "[0,0,0]"
expect "all formats have FLIP" "$(grep -l -i flip r.json r.csv r.md r.html | wc -l | tr -d ' ')" 4
expect "CSV has a line for each row" "$(wc -l <r.csv | tr -d ' ')" 11
expect "HTML has a picture for each effect, and the whole one" "$(grep -o 'data:image/png;base64,' r.html | wc -l | tr -d ' ')" 10
grep -o 'base64,[A-Za-z0-9+/=]*' r.html | head -n 1 | cut -d, -f2 | base64 -d >first.png
exits "which are PNG files" 0 "$penumbra" compare first.png first.png
exits "a scene without effects has a bill, too" 0 "$penumbra" effects builtin:soft-shadow $small --json
exits "a report of no known format" 2 "$penumbra" effects builtin:glass $small -o r.gif
exits "a view that is not there" 4 "$penumbra" effects builtin:glass $small --view nowhere

for layer in cost samples depth normal albedo; do
    exits "the layer $layer" 0 "$penumbra" render builtin:glass --set width=40 --set height=30 --layer $layer -o l.png
    exits "the layer $layer as numbers" 0 "$penumbra" render builtin:glass --set width=40 --set height=30 -q --layer $layer -o l.pfm
    expect "--quiet says nothing" "$(cat stdout stderr)" ""
done
exits "tests of pixels" 0 "$penumbra" render builtin:glass --set width=40 --set height=30 --layer cost --cost tests -o a.png
prints "what white stands for" stderr "tests per pixel"
expect "the file says so, too" "$(grep -a -c 'white is .* tests per pixel' a.png)" 1
"$penumbra" render builtin:glass --set width=40 --set height=30 --layer cost --cost tests --threads 1 -q -o b.png
expect "tests are the same for any number of threads" "$(cmp a.png b.png && echo same)" same

exits "an explanation" 0 "$penumbra" explain builtin:glass --set width=80 --set height=60
tr -s ' \n' ' ' <stdout >line
expect_match "what the scene calls for" "$(cat line)" "*kt > 0 and an ior other than 1*"
prints "what it does not" stdout "aperture_radius is 0"
exits "an explanation that is an estimate" 0 "$penumbra" explain builtin:glass --set samples_per_pixel=9
expect_match "rounds to what its interval tells" "$(grep '^  total ' stdout | tr -s ' ')" \
    ' total [0-9][0-9].[0-9] [0-9][0-9].[0-9] to [0-9][0-9].[0-9] million rays'
exits "an explanation with a render" 0 "$penumbra" explain builtin:glass --set width=64 --set height=48 --analyze --json
expect "rays are expected as they are: all pixels are counted" \
    "$(jq '[.rays[] | .expected == .actual and .low == .high] | all' stdout)" true
expect "the kernel is named" "$(jq -r '.kernel | split("/")[0]' stdout)" "hard+refraction"
exits "an explanation of a view that is not there" 4 "$penumbra" explain builtin:glass --view nowhere

finish
