#!/bin/sh
# SPDX-License-Identifier: MIT
# How often benchmarks judge rightly, with a least effect of 2 % and intervals of 2 %:
#   verdicts.sh [BUILD [FOLDER]]        FOLDER is BUILD/verdicts by default
# 1. a program against itself, beside a load that comes and goes: "same" or "undecided" in 89 of 100;
# 2. a kernel slowed by 5 % on an idle host: "slower" in 82 of 100.
# It also compares reports of successive benchmarks. Prints the rates, and ends with code 1 if one is missed.
# The environment may set COMPARISONS (100), SCENE (builtin:spheres), SIZE (100x75), THREADS (1), BUDGET
# (seconds of each comparison, 10), SLOWER (0.05), LOADS (the number of processes that make the load; 1).
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/verdicts}
. "$root/tests/bench/lib.sh"
comparisons=${COMPARISONS:-100}
size=${SIZE:-100x75}
verdicts=$build/tests/bench/verdicts
mkdir -p "$folder"
make_scene "${SCENE:-builtin:spheres}" "$folder/scene.json"

measure() { # SLOWER
    "$verdicts" "$comparisons" "$1" "${BUDGET:-10}" "width=${size%x*}" "height=${size#*x}" "threads=${THREADS:-1}" \
        <"$folder/scene.json"
}

loads=
stop_loads() {
    for pid in $loads; do
        kill "$pid" 2>/dev/null || :
    done
    loads=
}
trap stop_loads EXIT
i=0
while [ "$i" -lt "${LOADS:-1}" ]; do
    i=$((i + 1))
    "$verdicts" --load 86400 "$i" &
    loads="$loads $!"
done
echo "the same against itself, beside ${LOADS:-1} process(es) that come and go; then slowed by ${SLOWER:-0.05}, idle" >&2
measure 0 >"$folder/same.json"
stop_loads
measure "${SLOWER:-0.05}" >"$folder/slower.json"
jq -rn --slurpfile same "$folder/same.json" --slurpfile slower "$folder/slower.json" '
    def rate($good; $wanted): "\($good) of \($wanted.of), wanted \($wanted.least * 100) %: \(
        if $good >= $wanted.least * $wanted.of then "held" else "MISSED" end)";
    ($same[0]) as $a | ($slower[0]) as $b | $a.comparisons as $n |
    "same against itself beside a load: same \($a.rows.same), undecided \($a.rows.undecided), faster \($a.rows.faster), slower \($a.rows.slower);"
    + " \($a.repeats) repeats, \($a.spoiled_share * 100 | round) % of pairs spoiled (means)",
    "  same or undecided in " + rate($a.rows.same + $a.rows.undecided; {of: $n, least: 0.89}),
    "  between two reports: same \($a.reports.same), undecided \($a.reports.undecided), faster \($a.reports.faster), slower \($a.reports.slower)",
    "slowed by \($b.slower * 100) % on an idle host: slower \($b.rows.slower), same \($b.rows.same), undecided \($b.rows.undecided), faster \($b.rows.faster);"
    + " \($b.repeats) repeats, \($b.spoiled_share * 100 | round) % of pairs spoiled (means)",
    "  found in " + rate($b.rows.slower; {of: $n, least: 0.82}),
    "  between two reports of rows that are the same: same \($b.reports.same), undecided \($b.reports.undecided), faster \($b.reports.faster), slower \($b.reports.slower)"' |
    tee "$folder/verdicts.txt"
! grep -q MISSED "$folder/verdicts.txt"
