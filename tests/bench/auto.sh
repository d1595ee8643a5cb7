#!/bin/sh
# SPDX-License-Identifier: MIT
# Whether `auto` is the quickest accelerator: processor time of rendering and building, one thread,
# medians of interleaved runs.
#   auto.sh [BUILD [FOLDER]]        FOLDER is BUILD/auto by default
# Writes FOLDER/auto.md, whose last column is `auto` over the quickest of the others. Scenes of more than
# 1000 primitives are not rendered with `none`, `cbr` and `manual`, which take minutes. The environment
# may set SCENES, SIZE and RUNS as for frames.sh.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/auto}
. "$root/tests/bench/lib.sh"
scenes=${SCENES-$BUILTIN $ROOMS $SMALL $HAINES}
mkdir -p "$folder"
{
    echo '| scene | none | cbr | manual | median | auto, ms | over the quickest of the others |'
    echo '|---|---:|---:|---:|---:|---:|---:|'
    for scene in $scenes; do
        size=${SIZE:+$(timed_size "$scene")}
        case $scene in
        *:[0-9]*) size=${size:-400 300} ;;
        builtin:room | builtin:forest | parlour) size=${size:-250 350} ;;
        builtin:room-soft | builtin:soft-shadow | soft-room) size=${size:-75 105} ;;
        esac
        make_scene "$scene" "$folder/scene.json" $size
        kinds=none,cbr,manual,median,auto
        [ "$(grep -o '"type":' "$folder/scene.json" | wc -l)" -le 1000 ] || kinds=median,auto
        "$build/penumbra" bench "$folder/scene.json" --matrix accelerator=$kinds --threads 1 --repeats "${RUNS:-5}" \
            -q --json | jq -r --arg scene "$scene" '
            (.rows | map({key: .settings.accelerator, value: (.cpu_ms + .build_ms)}) | from_entries) as $ms |
            def ms: if . == null then "–" else (. * 10 | round / 10 | tostring) end;
            "| `\($scene)` | \([$ms.none, $ms.cbr, $ms.manual, $ms.median, $ms.auto] | map(ms) | join(" | ")) | \($ms.auto / ($ms | del(.auto) | [.[]] | min) * 100 | round / 100) |"'
    done
} | tee "$folder/auto.md"
