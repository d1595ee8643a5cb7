#!/bin/sh
# SPDX-License-Identifier: MIT
# Measures how cost grows with primitives, pixels, lights, samples and threads.
#   growth.sh [BUILD [FOLDER]]        FOLDER is BUILD/growth by default
# Writes FOLDER/growth.json, FOLDER/growth.md and the chart, FOLDER/growth.svg. The environment may set
# RUNS (1) and MOST, the largest number of primitives (1000000). The chart shows processor time of the
# render threads; for threads, rays per second by the clock.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/growth}
runs=${RUNS:-1}
most=${MOST:-1000000}
bench=$build/tests/bench
mkdir -p "$folder"
: >"$folder/points"

# point PANEL X SETTING…: times the scene on standard input.
point() {
    panel=$1 x=$2
    shift 2
    "$bench/phases" "$runs" "$@" | jq -c --arg panel "$panel" --argjson x "$x" '{panel: $panel, x: $x} + .' >>"$folder/points"
}
primitives=100
while [ "$primitives" -le "$most" ]; do
    "$bench/make_scene" field "$primitives" >"$folder/scene.json"
    point primitives "$primitives" threads=1 <"$folder/scene.json"
    primitives=$((primitives * 10))
done
"$bench/make_scene" parlour >"$folder/parlour.json"
for side in 32 100 320 1000; do
    point pixels $((side * side)) width=$side height=$side threads=1 <"$folder/parlour.json"
done
for lights in 1 2 4 8 16 32; do
    jq -c --argjson n "$lights" '.lights as $l | .lights = [range($n) | $l[. % 3]]' "$folder/parlour.json" >"$folder/scene.json"
    point lights "$lights" width=250 height=350 threads=1 <"$folder/scene.json"
done
for samples in 1 4 16 64; do
    point samples "$samples" width=100 height=140 samples_per_pixel=$samples threads=1 <"$folder/parlour.json"
done
threads=1
while [ "$threads" -le "$(nproc)" ]; do
    point threads "$threads" width=500 height=700 threads=$threads <"$folder/parlour.json"
    threads=$((threads * 2))
done
rm "$folder/scene.json" "$folder/parlour.json"
jq -s . "$folder/points" >"$folder/growth.json"
jq -r '.[] | .panel as $p |
    (if $p == "primitives" then ["parse", .parse_ms], ["build", .build_ms], ["render", .cpu_ms]
    elif $p == "threads" then ["by the clock", .rays / .render_ms / 1e3] else ["render", .cpu_ms] end) as [$series, $y] |
    "\($p), \(if $p == "threads" then "Mray/s" else "ms" end)\t\($series)\t\(.x)\t\($y)"' "$folder/growth.json" | "$bench/growth_chart" >"$folder/growth.svg"
jq -r '"| of | number | primitives | rays | read, ms | freeze, ms | of which build | render, ms | processor, ms |",
    "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    (.[] | "| \(.panel) | \(.x) | \(.primitives) | \(.rays) | \(.parse_ms) | \(.freeze_ms) | \(.build_ms) | \(.render_ms) | \(.cpu_ms) |")' \
    "$folder/growth.json" >"$folder/growth.md"
cat "$folder/growth.md"
