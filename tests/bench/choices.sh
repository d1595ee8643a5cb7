#!/bin/sh
# SPDX-License-Identifier: MIT
# The choices of `auto` (src/accel/auto_choice.c): processor time of a ray with each, in ns, and in
# brackets what the cost model expects, in tests of a block of four triangles; one thread, medians of
# interleaved runs.
#   choices.sh [BUILD [FOLDER]]     FOLDER is BUILD/choices by default
# Writes FOLDER/choices.md, whose last columns are the model's choice and its time over the quickest
# one. The environment may set SCENES, SIZE and RUNS as for frames.sh.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/choices}
. "$root/tests/bench/lib.sh"
mkdir -p "$folder"
{
    echo '| scene | none | tree | packets | choice | over the quickest |'
    echo '|---|---:|---:|---:|---|---:|'
    for scene in ${SCENES-$SMALL builtin:spheres builtin:soft-shadow parlour builtin:room field:1000}; do
        size=${SIZE:+$(timed_size "$scene")}
        make_scene "$scene" "$folder/scene.json" ${size:-200 150}
        "$build/tests/bench/choices" "${RUNS:-7}" <"$folder/scene.json" | jq -r --arg scene "$scene" '
            def round1: . * 10 | round / 10;
            (to_entries | min_by(.value.expected)) as $choice | (map(.ns) | min) as $least |
            "| `\($scene)` | \([.none, .tree, .packets] | map("\(.ns | round1) (\(.expected | round1))") | join(" | ")) | \($choice.key) | \($choice.value.ns / $least * 100 | round / 100) |"'
    done
} | tee "$folder/choices.md"
