#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the commands of README.md whose figures it has, and prints its four tables with date and machine: some
# 15 minutes on an idle host.
#   readme.sh [BUILD [FOLDER]]        FOLDER is BUILD/readme by default; reports stay there
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/readme}
. "$root/tests/bench/lib.sh"
mkdir -p "$folder"
echo "$(date -u +%F), $(machine)"

printf '\n## What accuracy costs\n\n'
"$build/penumbra" accuracy builtin:room-soft --set width=150 --set height=210 --ladder samples_per_pixel=1,2,4,8 \
    --ladder target_error=0.08,0.04,0.02,0.01,0.005,0.0025 --budget 180 -q -o "$folder/study.html" -o "$folder/study.json"
jq -r '"| setting | time | RMSE | FLIP | million rays |", "|---|---:|---:|---:|---:|",
    (.rows[] | (.settings | if .target_error > 0 then "`target_error` \(.target_error)"
        else "`samples_per_pixel` \(.samples_per_pixel)" end) as $setting |
     "| \($setting) | \(.median_ms / 10 | round / 100) s | \(.rmse) | \(.flip) | \(.rays.total / 1e5 | round / 10) |"),
    "", "\(.timing.spoiled) of \(.timing.runs) runs are spoiled."' "$folder/study.json"

printf '\n## Only the effects\n\n'
"$build/penumbra" effects builtin:glass --set width=400 --set height=300 -q -o "$folder/bill.html" -o "$folder/bill.json"
jq -r 'def ms: . * 10 | round / 10 | tostring + " ms";
    "| without | time | the effect costs | its rays | FLIP |", "|---|---:|---:|---:|---:|",
    (.rows[] | "| \(.without // "nothing") | \(.median_ms | ms) | \(
        if .cost_ms then .cost_ms | ms elif .cost_below_ms then "below " + (.cost_below_ms | ms) else "" end
        ) | \(.cost_rays // "") | \(if .without then .flip * 1000 | round / 1000 else "" end) |"),
    "", "\(.timing.spoiled) of \(.timing.runs) runs are spoiled."' "$folder/bill.json"

printf '\n## Stability\n\n'
cp "$root/tests/property/corpus/worst.txt" "$folder/corpus.txt"
begun=$(date +%s)
"$build/tests/property/stability" --out "$folder" --corpus "$folder/corpus.txt" --jobs "$(nproc)" --cases "${CASES:-1000}" \
    --no-price >"$folder/stability.log" || echo "a row failed: $folder/stability.log"
jq -r --arg s "$(($(date +%s) - begun))" '
    def group: (capture("H(?<n>[0-9]+)").n | tonumber) as $n |
        if $n < 59 then "1 edges, needles, outlines: a ray hits exactly one face, the right one"
        elif $n < 74 or ($n >= 129 and $n <= 139) or $n == 148 then
            "2 secondary rays, contacts, closed rooms: no self-hit, no leak, no false shadow"
        elif $n < 91 or $n == 143 then "3 grazing, scaled, turned, mirrored, far away: the same hits"
        elif $n < 100 then "4 boxes and trees: no hit is lost"
        elif $n < 106 then "5 the same bits for any accelerator, threads, tiles, instruction set"
        else "6 mirrors, glass, penumbrae: no light is lost or made" end;
    "| property | rows | cases | failures |", "|---|---:|---:|---:|",
    ([.rows[] | select(.cases > 0) | . + {group: (if .id | test("^O1") then "7 distances against 113-bit arithmetic"
        else .id | group end)}] | group_by(.group)[] |
     "| \(.[0].group[2:]) | \(length) | \(map(.cases) | add) | \(map(.failures) | add) |"),
    "", "It took \($s) s."' "$folder/report.json"

printf '\n## How fast\n\n'
SCENES="builtin:room builtin:forest builtin:room-soft builtin:teapot parlour balls rings" RUNS=3 THREADS=$(nproc) \
    sh "$root/tests/bench/frames.sh" "$build" "$folder/frames" >"$folder/frames.log"
jq -r 'def s: . / 10 | round / 100;
    "| scene | Penumbra | processor | POV-Ray | processor | gain |", "|---|---:|---:|---:|---:|---:|",
    ([.rows[].scene] | reduce .[] as $s ([]; if index([$s]) then . else . + [$s] end))[] as $scene |
    [.rows[] | select(.scene == $scene)] | map({(.program): .}) | add |
    "| `\($scene)` | \(.penumbra.wall_ms | s) | \(.penumbra.cpu_ms | s) | " + (if .povray then
        "\(.povray.wall_ms | s) | \(.povray.cpu_ms | s) | \(.povray.wall_ms / .penumbra.wall_ms * 10 | round / 10)× |"
        else "– | – | – |" end)' "$folder/frames/frames.json"
