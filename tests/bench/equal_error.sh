#!/bin/sh
# SPDX-License-Identifier: MIT
# What a target error costs beside fixed numbers of samples, at equal true error:
#   equal_error.sh [BUILD [FOLDER]]     FOLDER is BUILD/equal-error by default
# Both are judged by accuracy studies of the same scene: one over target_error, one over the products of those
# numbers of samples that the scene calls for. The time of fixed samples at the error that a target reached
# is read off their Pareto front, between neighbouring rows on logarithmic axes. Prints a table of the ratios
# time with a target / time with the best fixed samples, to FOLDER/equal-error.md as well. The environment may set
# SCENES, TARGETS (0.02,0.01,0.005) and SEEDS (3).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/equal-error}
penumbra=$build/penumbra
scenes=${SCENES:-soft-shadow spheres glass gloss lens patterns forest teapot room room-soft}
targets=${TARGETS:-0.02,0.01,0.005}
mkdir -p "$folder"

ladder_of() { # SCENE
    camera=1,2,4,8,16,32,64,128
    case $1 in
    soft-shadow | room-soft) echo "--ladder samples_per_pixel=1,2,4,8,16,32,64 --ladder light_samples=1,4,16" ;;
    gloss) echo "--ladder samples_per_pixel=1,2,4,8,16,32,64 --ladder blur_samples=1,4" ;;
    lens) echo "--ladder lens_samples=2,4,8,16,32,64,128,256" ;;
    *) echo "--ladder samples_per_pixel=$camera" ;;
    esac
}

study() { # SCENE NAME ARGUMENT…
    scene=$1 name=$2
    shift 2
    size="--set width=200 --set height=150"
    case $scene in room*) size="--set width=150 --set height=210" ;; esac
    echo "$scene: $name" >&2
    "$penumbra" accuracy "builtin:$scene" $size --seeds "${SEEDS:-3}" -q -o "$folder/$scene-$name.json" "$@"
}

for scene in $scenes; do
    study "$scene" target --ladder "target_error=$targets"
    # shellcheck disable=SC2046 # a list of arguments
    study "$scene" fixed --product $(ladder_of "$scene")
    jq -cn --arg scene "$scene" --slurpfile target "$folder/$scene-target.json" --slurpfile fixed "$folder/$scene-fixed.json" '
        [$fixed[0].rows[] | select(.pareto and .rmse != null) | {x: (.rmse | log), y: (.median_ms | log), settings}]
            | sort_by(.x) as $front |
        $target[0].rows[] | select(.settings.target_error > 0 and .rmse != null) | (.rmse | log) as $x |
        ([$front[] | select(.x <= $x)] | last) as $a | ([$front[] | select(.x > $x)] | first) as $b |
        (if $a and $b then $a.y + ($x - $a.x) / ($b.x - $a.x) * ($b.y - $a.y) else null end) as $y |
        {scene: $scene, asked: .settings.target_error, reached: .rmse, ms: .median_ms,
         fixed_ms: (if $y then ($y | exp) else null end), best: ($a // {}).settings,
         ratio: (if $y then (.median_ms / ($y | exp)) else null end)}'
done >"$folder/rows.jsonl"

jq -rs '
    "| scene | asked | reached | ms | fixed samples ms | ratio |", "|---|---:|---:|---:|---:|---:|",
    (.[] | "| `\(.scene)` | \(.asked) | \(.reached) | \(.ms | round) | \(if .fixed_ms then (.fixed_ms | round) else "–" end) | \(
        if .ratio then (.ratio * 100 | round / 100) else "beyond the ladder" end) |"),
    ([.[].ratio | select(. != null)] | sort | "\nMedian ratio: \(.[length / 2 | floor] * 100 | round / 100)")' \
    "$folder/rows.jsonl" | tee "$folder/equal-error.md"
