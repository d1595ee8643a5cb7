#!/bin/sh
# SPDX-License-Identifier: MIT
# What the presets of `quality` cost, and how much their pictures differ from a render with another seed and
# the preset `reference`.
#   presets.sh [BUILD [FOLDER]]     FOLDER is BUILD/presets by default
# Writes FOLDER/presets.md: processor time in ms, median of three renders by one thread, and the mean of FLIP.
# The environment may set SCENES and SIZE as for frames.sh.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/presets}
. "$root/tests/bench/lib.sh"
mkdir -p "$folder"
build=$(cd "$build" && pwd)
cd "$folder"
render() { # SCENE SIZE OUT ARGUMENTS…
    scene=$1 width=${2%x*} height=${2#*x} out=$3
    shift 3
    "$build/penumbra" render "$scene" --set "width=$width" --set "height=$height" --threads 1 -q -o "$out" "$@"
}
{
    echo '| | draft | good | final | reference |'
    echo '|---|---|---|---|---|'
    for scene in ${SCENES:-builtin:spheres builtin:soft-shadow builtin:glass builtin:gloss builtin:lens \
        builtin:patterns builtin:forest builtin:teapot builtin:room builtin:room-soft}; do
        case $scene in builtin:room*) size=150x210 ;; *) size=200x150 ;; esac
        size=${SIZE:-$size}
        render "$scene" "$size" converged.pfm --set quality=reference --set seed=1 2>/dev/null
        printf '| `%s` |' "${scene#builtin:}"
        for quality in draft good final reference; do
            for run in 1 2 3; do
                render "$scene" "$size" preset.pfm --set "quality=$quality" --stats "$run.json" 2>/dev/null
            done
            printf ' %s ms, %s |' "$(jq -s 'map(.timing.cpu_ms) | sort | .[1] | round' 1.json 2.json 3.json)" \
                "$("$build/penumbra" compare preset.pfm converged.pfm --json | jq '.flip * 10000 | round / 10000')"
        done
        echo
    done
} | tee presets.md
