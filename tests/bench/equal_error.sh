#!/bin/sh
# SPDX-License-Identifier: MIT
# What a target error costs beside fixed numbers of samples, at equal true error:
#   equal_error.sh [BUILD [FOLDER]]     FOLDER is BUILD/equal-error by default
# Two accuracy studies of the same scene judge both: one over target_error, one over all combinations of the
# numbers of samples that the scene calls for. The time of fixed samples is read off their Pareto front at the
# error that a target reached, between neighbouring rows on logarithmic axes. Prints a table of the ratios
# time with a target / time with the best fixed samples, and writes it to FOLDER/equal-error.md. The table
# also has their median over scenes, and the share of the picture in penumbrae: pixels that soft lights
# change. The environment may set SCENES (names of built-in scenes, and files of scenes), TARGETS
# (0.02,0.01,0.005; smaller ones for scenes that the pilot brings below these) and SEEDS (3).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/equal-error}
penumbra=$build/penumbra
scenes=${SCENES:-soft-shadow spheres glass gloss lens patterns forest teapot room room-soft $root/tests/bench/scenes/ball_on_floor.json}
mkdir -p "$folder"

# The file of a scene.
file_of() { # SCENE
    case $1 in
    *.json) cp "$1" "$folder/scene.json" ;;
    *) "$penumbra" scenes "$1" >"$folder/scene.json" ;;
    esac
    echo "$folder/scene.json"
}

# What the scene calls for.
ladder_of() { # FILE
    jq -r '
        def soft: [.lights[]? | (.radius // 0) + (.angular_radius // 0)] | add // 0 | . > 0;
        def blurred: [.materials[]? | (.reflection_blur // 0) + (.transmission_blur // 0)] | add // 0 | . > 0;
        def lens: (.camera // .views[0].camera | .aperture_radius // 0) > 0;
        if lens then "--ladder lens_samples=2,4,8,16,32,64,128,256"
        elif soft then "--ladder samples_per_pixel=1,2,4,8,16,32,64 --ladder light_samples=1,4,16"
        elif blurred then "--ladder samples_per_pixel=1,2,4,8,16,32,64 --ladder blur_samples=1,4"
        else "--ladder samples_per_pixel=1,2,4,8,16,32,64,128" end' "$1"
}

# Of a scene most of which is even.
targets_of() { # SCENE
    case $1 in
    ball_on_floor) echo "${TARGETS:-0.002,0.001,0.0005}" ;;
    *) echo "${TARGETS:-0.02,0.01,0.005}" ;;
    esac
}

study() { # FILE SCENE NAME ARGUMENT…
    file=$1 scene=$2 name=$3
    shift 3
    size="--set width=200 --set height=150"
    case $scene in room*) size="--set width=150 --set height=210" ;; esac
    echo "$scene: $name" >&2
    "$penumbra" accuracy "$file" $size --seeds "${SEEDS:-3}" -q -o "$folder/$scene-$name.json" "$@"
}

# The percentage of pixels that soft lights change by more than 0.002 as displayed, with many samples.
penumbrae_of() { # FILE
    jq -c 'del(.lights[]? | (.radius, .angular_radius))' "$1" >"$folder/hard.json"
    for kind in scene hard; do
        "$penumbra" render "$folder/$kind.json" $size -q --set samples_per_pixel=64 --set light_samples=64 -o "$folder/$kind.pfm"
    done
    "$penumbra" compare "$folder/scene.pfm" "$folder/hard.pfm" --tolerance 0.002 --json |
        jq '100 * .over_tolerance / .pixels'
}

for scene in $scenes; do
    file=$(file_of "$scene")
    scene=$(basename "$scene" .json)
    study "$file" "$scene" target --ladder "target_error=$(targets_of "$scene")"
    # shellcheck disable=SC2046 # a list of arguments
    study "$file" "$scene" fixed --product $(ladder_of "$file")
    jq -cn --arg scene "$scene" --argjson penumbrae "$(penumbrae_of "$file")" \
        --slurpfile target "$folder/$scene-target.json" --slurpfile fixed "$folder/$scene-fixed.json" '
        [$fixed[0].rows[] | select(.pareto and .rmse != null) | {x: (.rmse | log), y: (.median_ms | log), settings}]
            | sort_by(.x) as $front |
        $target[0].rows[] | select(.settings.target_error > 0 and .rmse != null) | (.rmse | log) as $x |
        ([$front[] | select(.x <= $x)] | last) as $a | ([$front[] | select(.x > $x)] | first) as $b |
        (if $a and $b then $a.y + ($x - $a.x) / ($b.x - $a.x) * ($b.y - $a.y) else null end) as $y |
        {$scene, $penumbrae, asked: .settings.target_error, reached: .rmse, ms: .median_ms,
         fixed_ms: (if $y then ($y | exp) else null end), best: ($a // {}).settings,
         ratio: (if $y then (.median_ms / ($y | exp)) else null end)}'
done >"$folder/rows.jsonl"

jq -rs '
    def median: sort | if length == 0 then null else (.[(length - 1) / 2 | floor] + .[length / 2 | floor]) / 2 end;
    def hundredths: if . == null then "none" else . * 100 | round / 100 end;
    [group_by(.scene)[] | {scene: .[0].scene, penumbrae: .[0].penumbrae, ratio: (map(.ratio | select(. != null)) | median)}] as $scenes |
    "| scene | asked | reached | ms | fixed samples ms | ratio |", "|---|---:|---:|---:|---:|---:|",
    (.[] | "| `\(.scene)` | \(.asked) | \(.reached) | \(.ms | round) | \(if .fixed_ms then (.fixed_ms | round) else "–" end) | \(
        if .ratio then (.ratio | hundredths) else "beyond the ladder" end) |"),
    "", "| scene | in penumbrae | median ratio |", "|---|---:|---:|",
    ($scenes[] | "| `\(.scene)` | \(.penumbrae * 10 | round / 10) % | \(.ratio | hundredths) |"),
    "", "Median over scenes of their median ratios: \([$scenes[].ratio | select(. != null)] | median | hundredths)"' \
    "$folder/rows.jsonl" | tee "$folder/equal-error.md"
