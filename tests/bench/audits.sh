#!/bin/sh
# SPDX-License-Identifier: MIT
# How often the bound of an audit holds: 200 audits of pictures with target errors, over five scenes,
# against references. Exit status 1 if it holds in less than 180.
#   audits.sh [BUILD]
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
. "$root/tests/bench/lib.sh"
folder=$build/audits
mkdir -p "$folder"

# Scene, width, height, samples of the references, target error, threshold.
echo 'spheres 80 60 1024 0.01 0.02
glass 60 45 1024 0.02 0.05
forest 80 54 2048 0.01 0.05
room 50 70 1024 0.02 0.05
soft-shadow 80 50 1024 0.005 0.02' | while read -r scene width height samples target threshold; do
    make_scene "builtin:$scene" "$folder/scene.json" "$width" "$height"
    printf '%s\t%s\t%s\t' "$scene" "$target" "$threshold"
    "$build/tests/bench/audits" "$samples" 40 "$target" "$threshold" <"$folder/scene.json"
done | awk -F '\t' '
    BEGIN {
        print "| scene | target error | threshold | audits | bound holds | share that is wrong | mean bound |"
        print "|---|---:|---:|---:|---:|---:|---:|"
    }
    { print "| " $1 " | " $2 " | " $3 " | " $4 " | " $5 " | " $6 " | " $7 " |"; all += $4; held += $5 }
    END {
        printf "\nThe bound holds in %d of %d audits.\n", held, all
        exit all < 200 || held < 180
    }'
