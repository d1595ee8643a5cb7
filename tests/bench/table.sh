#!/bin/sh
# SPDX-License-Identifier: MIT
# Benchmarks every accelerator with one thread and with all, with hard and with soft shadows.
#   table.sh [BUILD [FOLDER]]        FOLDER is BUILD/table by default
# Writes room.* and room-soft.* into FOLDER, the reports of two benchmarks as HTML, JSON, CSV and
# Markdown, and table.md, which shows both beside the times published for a classroom ray tracer and
# its own room. The environment may set ROOM and SOFT (sizes), REPEATS and WARMUP. Runs that take
# seconds need no warm-up. With soft shadows and no accelerator a picture of full size takes more than
# ten minutes.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/table}
room=${ROOM:-1000x1400}
soft=${SOFT:-150x210}
repeats=${REPEATS:-3}
warmup=${WARMUP:-0}
mkdir -p "$folder"

measure() { # SCENE SIZE
    "$build/penumbra" bench "$root/scenes/$1.json" --set width="${2%x*}" --set height="${2#*x}" \
        --matrix accelerator=none,cbr,manual,median,auto --matrix threads=1,0 \
        --repeats "$repeats" --warmup "$warmup" \
        -o "$folder/$1.html" -o "$folder/$1.json" -o "$folder/$1.csv" -o "$folder/$1.md"
    echo
}
echo "room, $room"
measure room "$room"
echo "room-soft, $soft"
measure room-soft "$soft"

# The classroom tracer's milliseconds: "Spring 2025" room, its authors' machine, Java 21.
jq -rn --slurpfile hard "$folder/room.json" --slurpfile soft "$folder/room-soft.json" '
    {none: [57805, 37170, 2055717, 1341216], cbr: [12873, 6430, 764358, 305627],
     manual: [8350, 4330, 268007, 164178], auto: [8607, 2670, 289321, 106268]} as $theirs |
    def row($report; $kind; $threads):
        $report.rows[] | select(.settings == {accelerator: $kind, threads: $threads});
    def ms: if . == null then "–" elif . < 100 then (. * 10 | round / 10 | tostring)
        else (round | tostring) end;
    def times: . * 100 | round / 100 | tostring + "×";
    def mine($kind): [row($hard[0]; $kind; 1), row($hard[0]; $kind; 0),
                      row($soft[0]; $kind; 1), row($soft[0]; $kind; 0)] | map(.median_ms);
    def cells: map(ms) | join(" | ");
    def gain($a; $b): ($a / $b) | times;
    ($hard[0].pool_threads | tostring) as $all |
    (["none", "cbr", "manual", "median", "auto"] | map({key: ., value: mine(.)}) | from_entries) as $m |
    "Medians of \($hard[0].repeats) interleaved runs, in milliseconds, of building the tree and rendering:",
    "`room.json` at \($hard[0].render.width)×\($hard[0].render.height), `room-soft.json` (64 rays to each of three lights) at \($soft[0].render.width)×\($soft[0].render.height).",
    "\($hard[0].host.cpu), \($hard[0].host.isa), \($all) threads; load average \($hard[0].load_average.before) before, \($soft[0].load_average.after) after.",
    "On the right the classroom tracer: its own room, its authors’ machine, Java 21, as published.",
    "",
    "| | room, 1 thread | \($all) threads | soft, 1 thread | \($all) threads | classroom, 1 thread | threads | soft, 1 thread | threads |",
    "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
    ($m | to_entries[] | "| `\(.key)` | \(.value | cells) | \(($theirs[.key] // [null, null, null, null]) | cells) |"),
    "| `none`, 1 thread, over `auto`, all threads | | \(gain($m.none[0]; $m.auto[1])) | | \(gain($m.none[2]; $m.auto[3])) | | \(gain(57805; 2670)) | | \(gain(2055717; 106268)) |",
    "| `auto`: all threads against one | | \(gain($m.auto[0]; $m.auto[1])) | | \(gain($m.auto[2]; $m.auto[3])) | | \(gain(8607; 2670)) | | \(gain(289321; 106268)) |",
    "",
    "Processor time, which other work on the machine changes less:",
    "",
    "| | room, 1 thread | \($all) threads | soft, 1 thread | \($all) threads | boxes, primitives tested per ray: room | soft |",
    "|---|---:|---:|---:|---:|---:|---:|",
    (["none", "cbr", "manual", "median", "auto"][] | . as $k |
        "| `\($k)` | \([row($hard[0]; $k; 1), row($hard[0]; $k; 0), row($soft[0]; $k; 1), row($soft[0]; $k; 0)] | map(.cpu_ms) | cells) | \([row($hard[0]; $k; 1), row($soft[0]; $k; 1)] | map(.accelerator | "\(.box_tests_per_ray | ms), \(.primitive_tests_per_ray | ms)") | join(" | ")) |")
' >"$folder/table.md"
cat "$folder/table.md"
