#!/bin/sh
# SPDX-License-Identifier: MIT
# Soft shadows beside POV-Ray's adaptive area lights, at equal or lower true error.
#   soft_lights.sh [BUILD [FOLDER]]        FOLDER is BUILD/soft-lights by default
# There are two comparisons on builtin:room-soft. "lights" has one camera ray a pixel, so that only the
# lights' error counts: fixed light_samples against POV-Ray without anti-aliasing. "picture" is target_error
# against POV-Ray's adaptive anti-aliasing (method 2).
#
# POV-Ray's lights are `area_light N N adaptive LEVEL circular orient jitter`. N is a power of two. Halving
# the grid then takes each point once, so all points have the same weight. Jitter moves a point by up to half
# of the grid's spacing, also beyond the border. So the grid is made smaller by (N - 1) / N, and its points
# lie in the same disk for each N.
#
# Errors are the RMSE of sRGB-encoded values, from PNG files of 16 bits. Each program is judged by its own
# reference, without adaptive lights. POV-Ray's disk is not evenly bright (points on a square's diagonal lie
# closer on its circle), and to_pov.c lists the other differences. The difference of the programs is printed
# beside that of the same scene with hard shadows, where the lights play no part. A second reference, with
# other points, gives the error of the first.
#
# Runs are interleaved, times are medians: of the whole program by the clock, and of tracing as each program
# reports it. For each row of POV-Ray the table has the quickest row of Penumbra whose error is not larger.
# Writes FOLDER/soft-lights.json and .md. References are kept in FOLDER and used again. The environment may
# set SIZE (150x210), RUNS, THREADS (all), WHAT ("lights picture"), POINTS (N: "8 16"), LEVELS ("0 1 2 3"),
# ALIASING (thresholds and depths: "0.3,2 0.1,2 0.1,3 0.03,3"), LIGHT_SAMPLES, TARGETS, REFERENCE (camera rays
# a pixel of Penumbra's references, 1024).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/soft-lights}
. "$root/tests/bench/lib.sh"
scene=builtin:room-soft
size=$(timed_size "$scene")
width=${size% *} height=${size#* }
runs=${RUNS:-3}
threads=${THREADS:-$(nproc)}
what=${WHAT:-lights picture}
renderer=$build/penumbra
command -v povray >/dev/null || {
    echo "soft_lights: no povray (deploy/install-deps.sh --bench installs it)" >&2
    exit 2
}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)
make_scene "$scene" "$folder/scene.json" "$width" "$height"
"$build/tests/bench/to_pov" <"$folder/scene.json" >"$folder/scene.pov"

# pov_scene FILE POINTS LEVEL: the scene with other lights; LEVEL may be empty.
pov_scene() {
    scale=$(awk "BEGIN { print ($2 - 1) / $2 }")
    sed -E "s/area_light <([^,]*), 0, 0>, <0, ([^,]*), 0>, [0-9]+, [0-9]+/area_light <\\1*$scale, 0, 0>, <0, \\2*$scale, 0>, $2, $2${3:+ adaptive $3}/" \
        "$folder/scene.pov" >"$1"
}

# pov FILE PICTURE ARGUMENT…: the command that renders a scene; its messages are added to PICTURE.log.
pov() {
    echo "HOME=$folder povray +I$1 +O$2.png +FN16 File_Gamma=srgb +W$width +H$height +Q9 +WT$threads -D -P $3 2>>$2.log"
}

# pen PICTURE SETTING…: likewise; the result is added to PICTURE.log.
pen() {
    picture=$1
    shift
    echo "$renderer render $folder/scene.json -q --json --threads $threads --format png16 -o $picture.png$(printf ' --set %s' "$@") >>$picture.log"
}

# One line for each row: comparison, program, name of its files, label, command; parted by tabs.
rows() {
    case " $what " in *" lights "*)
        for n in ${POINTS:-8 16}; do
            for level in ${LEVELS:-0 1 2 3}; do
                name=lights-pov-$n-$level
                pov_scene "$folder/$name.pov" "$n" "$level"
                printf 'lights\tpovray\t%s\t%s\t%s\n' "$name" "$n × $n, adaptive $level" \
                    "$(pov "$folder/$name.pov" "$folder/$name" "-A")"
            done
        done
        for n in ${LIGHT_SAMPLES:-4 8 16 32 64 128 256}; do
            name=lights-pen-$n
            printf 'lights\tpenumbra\t%s\t%s\t%s\n' "$name" "light_samples $n" \
                "$(pen "$folder/$name" samples_per_pixel=1 "light_samples=$n")"
        done
        ;;
    esac
    case " $what " in *" picture "*)
        for n in ${POINTS:-8}; do
            for level in ${LEVELS:-0 1 2 3}; do
                for aliasing in ${ALIASING:-0.3,2 0.1,2 0.1,3 0.03,3}; do
                    name=picture-pov-$n-$level-$aliasing
                    pov_scene "$folder/$name.pov" "$n" "$level"
                    printf 'picture\tpovray\t%s\t%s\t%s\n' "$name" "$n × $n, adaptive $level, +AM2 +A${aliasing%,*} +R${aliasing#*,}" \
                        "$(pov "$folder/$name.pov" "$folder/$name" "+AM2 +A${aliasing%,*} +R${aliasing#*,}")"
                done
            done
        done
        for target in ${TARGETS:-0.06 0.04 0.03 0.025 0.022 0.02 0.018 0.015 0.01 0.009 0.007 0.005}; do
            name=picture-pen-$target
            printf 'picture\tpenumbra\t%s\t%s\t%s\n' "$name" "target_error $target" \
                "$(pen "$folder/$name" "target_error=$target")"
        done
        ;;
    esac
}

# reference NAME COMMAND: runs the command unless its picture is there and the command is the same.
reference() {
    [ -f "$folder/$1.png" ] && [ "$(cat "$folder/$1.command")" = "$2" ] && return
    echo "reference $1" >&2
    rm -f "$folder/$1.png" "$folder/$1.log"
    sh -c "$2" || {
        tail -n 5 "$folder/$1.log" >&2
        exit 1
    }
    echo "$2" >"$folder/$1.command"
}

# Two references each. For "picture" a pixel's camera rays are a grid (method 1, threshold 0) with few
# points on a light for each; their jitter is drawn anew for each ray.
references() {
    case " $what " in *" lights "*)
        for n in 32 24; do
            pov_scene "$folder/lights-pov-reference-$n.pov" "$n" ""
            reference "lights-pov-reference-$n" \
                "$(pov "$folder/lights-pov-reference-$n.pov" "$folder/lights-pov-reference-$n" -A)"
        done
        for seed in 1001 1002; do
            reference "lights-pen-reference-$seed" "$(pen "$folder/lights-pen-reference-$seed" \
                samples_per_pixel=1 light_samples=4096 "seed=$seed")"
        done
        ;;
    esac
    case " $what " in *" picture "*)
        pov_scene "$folder/picture-pov-reference.pov" 4 ""
        for depth in 9 8; do
            reference "picture-pov-reference-$depth" "$(pov "$folder/picture-pov-reference.pov" \
                "$folder/picture-pov-reference-$depth" "+AM1 +A0.0 +J1.0 +R$depth")"
        done
        for seed in 1001 1002; do
            reference "picture-pen-reference-$seed" "$(pen "$folder/picture-pen-reference-$seed" \
                "samples_per_pixel=${REFERENCE:-1024}" light_samples=16 "seed=$seed")"
        done
        ;;
    esac
}

# The scene with hard shadows, by both programs.
hard_shadows() {
    jq -c 'del(.lights[].radius)' "$folder/scene.json" >"$folder/hard.json"
    "$build/tests/bench/to_pov" <"$folder/hard.json" >"$folder/hard.pov"
    reference hard-pov "$(pov "$folder/hard.pov" "$folder/hard-pov" -A)"
    reference hard-pen "$(pen "$folder/hard-pen" samples_per_pixel=1 | sed 's/scene\.json/hard.json/')"
}

rmse() { # A B
    "$renderer" compare "$folder/$1.png" "$folder/$2.png" --json | jq .rmse
}

# The first reference of a comparison and a program, and the second.
first_of() {
    case $1-$2 in
    lights-povray) echo lights-pov-reference-32 lights-pov-reference-24 ;;
    picture-povray) echo picture-pov-reference-9 picture-pov-reference-8 ;;
    *) echo "$1-pen-reference-1001 $1-pen-reference-1002" ;;
    esac
}

# Milliseconds of tracing in each timed run of a row, as the programs tell them; the first run is not timed.
trace_times() { # PROGRAM NAME
    case $1 in
    povray) sed -n 's/.*Trace Time:.*(\([0-9.]*\) seconds).*/\1/p' "$folder/$2.log" | jq '. * 1000' ;;
    penumbra) jq .stats.timing.render_ms "$folder/$2.log" ;;
    esac | tail -n "$runs" | jq -s 'sort | (.[(length - 1) / 2 | floor] + .[length / 2 | floor]) / 2'
}

rm -f "$folder"/lights-p*-[0-9]*.log "$folder"/picture-p*-[0-9]*.log
references
hard_shadows
rows >"$folder/rows"
cut -f 3,5 "$folder/rows" >"$folder/commands"
"$build/tests/bench/time_runs" "$runs" <"$folder/commands" >"$folder/times.json"

tab=$(printf '\t')
while IFS=$tab read -r comparison program name setting _; do
    set -- $(first_of "$comparison" "$program")
    jq -nc --arg comparison "$comparison" --arg program "$program" --arg name "$name" --arg setting "$setting" \
        --argjson rmse "$(rmse "$name" "$1")" --argjson trace_ms "$(trace_times "$program" "$name")" \
        --slurpfile times "$folder/times.json" \
        '{$comparison, $program, $setting, $rmse, $trace_ms} + ($times[0][] | select(.name == $name) | del(.name))'
done <"$folder/rows" >"$folder/rows.jsonl"

for comparison in $what; do
    set -- $(first_of "$comparison" povray) $(first_of "$comparison" penumbra)
    jq -nc --arg comparison "$comparison" --argjson povray "$(rmse "$1" "$2")" --argjson penumbra "$(rmse "$3" "$4")" \
        --argjson between "$(rmse "$1" "$3")" --argjson hard "$(rmse hard-pov hard-pen)" \
        '{$comparison, $povray, $penumbra, $between, $hard}'
done >"$folder/references.jsonl"

jq -n --slurpfile rows "$folder/rows.jsonl" --slurpfile references "$folder/references.jsonl" \
    --arg machine "$(machine)" --arg date "$(date -u +%F)" --arg povray "$(povray --version 2>&1 | grep -m 1 -o 'POV-Ray [0-9.]*')" \
    --arg revision "$(git -C "$root" rev-parse --short HEAD 2>/dev/null || echo unknown)" \
    --arg size "$width×$height" --argjson runs "$runs" --argjson threads "$threads" \
    '{$date, $machine, $revision, $povray, $size, $runs, $threads, $references, $rows}' >"$folder/soft-lights.json"
jq -r -f "$root/tests/bench/soft_lights.jq" "$folder/soft-lights.json" | tee "$folder/soft-lights.md"
