#!/bin/sh
# SPDX-License-Identifier: MIT
# Times pictures as whole programs, by the clock, against POV-Ray if it is installed, with one thread and with
# all. Then prints the numbers of rays of Haines' scenes beside the published ones.
#   frames.sh [BUILD [FOLDER]]        FOLDER is BUILD/frames by default
# Writes FOLDER/frames.json and FOLDER/frames.md. Both programs read the same scene at the same size and write
# a PNG; to_pov.c lists what is translated exactly and what is approximated. Runs are interleaved; times are
# medians. The environment may set SCENES (names as `make_scene --list` prints them, or builtin:NAME), SIZE
# (WIDTHxHEIGHT), RUNS, THREADS, RENDERER (another program of this project, by default BUILD/penumbra) and
# POV= (empty: without).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/frames}
. "$root/tests/bench/lib.sh"
scenes=${SCENES-$BUILTIN $ROOMS $HAINES}
runs=${RUNS:-3}
threads=${THREADS:-$(printf '1\n%s\n' "$(nproc)" | sort -nu)}
renderer=${RENDERER:-$build/penumbra}
pov=${POV-$(command -v povray || :)}
mkdir -p "$folder"
folder=$(cd "$folder" && pwd)

commands() {
    for scene in $scenes; do
        file=$folder/$(echo "$scene" | tr : -)
        make_scene "$scene" "$file.json" $(timed_size "$scene")
        size=$(jq -r '"+W\(.render.width // 800) +H\(.render.height // 600)"' "$file.json")
        [ -z "$pov" ] || "$build/tests/bench/to_pov" <"$file.json" >"$file.pov"
        for n in $threads; do
            printf '%s %s penumbra\t%s render %s.json -q --threads %s -o %s.png\n' \
                "$scene" "$n" "$renderer" "$file" "$n" "$file"
            [ -z "$pov" ] || printf '%s %s povray\tHOME=%s %s +I%s.pov +O%s-pov.png +FN %s +WT%s +Q9 -A -D -P -V 2>%s.log\n' \
                "$scene" "$n" "$folder" "$pov" "$file" "$file" "$size" "$n" "$file"
        done
    done
}
commands >"$folder/commands"
"$build/tests/bench/time_runs" "$runs" <"$folder/commands" >"$folder/times.json"

# Numbers of rays, which do not depend on threads.
for scene in $scenes; do
    file=$folder/$(echo "$scene" | tr : -)
    "$renderer" render "$file.json" -q --stats "$file-stats.json" >/dev/null
    jq -c --arg scene "$scene" '{scene: $scene, rays, accelerator: .accelerator.kind, kernel}' "$file-stats.json"
done >"$folder/rays"

jq -n --slurpfile times "$folder/times.json" --slurpfile rays "$folder/rays" \
    --arg machine "$(machine)" --arg isa "$("$renderer" render builtin:spheres --set width=8 --set height=8 -q --json -o /dev/null --format png | jq -r .stats.host.isa)" \
    --arg date "$(date -u +%F)" --arg revision "$(git -C "$root" rev-parse --short HEAD 2>/dev/null || echo unknown)" \
    --argjson runs "$runs" '
    {date: $date, machine: $machine, isa: $isa, revision: $revision, runs: $runs, rays: $rays,
     rows: [$times[0][] | (.name / " ") as [$scene, $threads, $program] |
            {scene: $scene, threads: ($threads | tonumber), program: $program} + del(.name)]}' >"$folder/frames.json"
jq -r -f "$root/tests/bench/frames.jq" "$folder/frames.json" >"$folder/frames.md"
cat "$folder/frames.md"
