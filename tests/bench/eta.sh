#!/bin/sh
# SPDX-License-Identifier: MIT
# Compares the time left that jobs report with the time that was left. The jobs are the built-in scenes and
# cheap_sky, each made heavy enough to last some seconds, and a job with a budget. Prints a table, see eta.py.
#   eta.sh [BUILD]
# The environment may set DAEMON (another build's), JOBS (names of rows) and REPEATS.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
builtin() { echo "$1 {\"scene\": \"builtin:$1\", \"render\": {$2}}"; }
{
    builtin forest '"samples_per_pixel": 16'
    builtin glass '"samples_per_pixel": 25'
    builtin gloss '"width": 500, "height": 375'
    builtin lens '"lens_samples": 100'
    builtin patterns '"samples_per_pixel": 49'
    builtin room '"samples_per_pixel": 16'
    builtin room-soft '"width": 500, "height": 700, "samples_per_pixel": 2'
    builtin soft-shadow '"samples_per_pixel": 25'
    builtin spheres '"samples_per_pixel": 49'
    builtin teapot '"samples_per_pixel": 25'
    echo "cheap-sky {\"scene\": $(jq -c . "$root/tests/bench/scenes/cheap_sky.json")}"
    echo 'budget {"scene": "builtin:gloss", "budget_seconds": 8, "render": {"width": 300, "height": 200}}'
} >"$work/all"
for name in ${JOBS:-$(cut -d' ' -f1 "$work/all")}; do
    grep "^$name " "$work/all"
done >"$work/jobs"
python3 "$root/tests/bench/eta.py" "${DAEMON:-$build/penumbrad}" "$work/jobs" "${REPEATS:-3}"
