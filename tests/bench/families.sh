#!/bin/sh
# SPDX-License-Identifier: MIT
# Targets in random scenes whose light is small and bright (tests/bench/families.py):
#   families.sh [BUILD [FOLDER]]        FOLDER is BUILD/families by default
# Writes the renders of each family into FOLDER (tests/bench/calibration.c, after family and number of the
# scene), and a table. Exit status 1 if a limit is missed. A render is beyond its target if it exceeds the
# target by more than a tenth plus the error of its reference.
# - Of all renders that report `met`, at most 3 % are beyond the target.
# - Of lamps, bokeh, dots and wires, at least 95 % report `met`.
# - Of sparks and highlights, at least 80 % reach the target, with or without `met`.
# The environment may set FAMILIES, SCENES (9 of each family, each with two targets and four seeds) and FIRST,
# the number of the first scene.
set -eu
root=$(cd "$(dirname "$0")/../.." && pwd)
build=${1:-$root/build}
folder=${2:-$build/families}
families=${FAMILIES:-lamps bokeh dots wires sparks highlights}
scenes=${SCENES:-9}
first=${FIRST:-1}
mkdir -p "$folder"
for family in $families; do
    i=$first
    while [ "$i" -lt $((first + scenes)) ]; do
        python3 "$root/tests/bench/families.py" "$family" "$i" >"$folder/scene.json"
        "$build/tests/bench/calibration" 4096 4 0.02 0.005 <"$folder/scene.json" | sed "s/^/$family	$i	/"
        i=$((i + 1))
    done >"$folder/$family.tsv"
    cat "$folder/$family.tsv"
done >"$folder/all.tsv"
awk -F '\t' '
    BEGIN {
        print "| family | renders | report met | of these beyond | reach the target | most reached / asked | samples per pixel |"
        print "|---|---:|---:|---:|---:|---:|---:|"
    }
    function row() {
        printf "| %s | %d | %d | %d | %d | %.2f | %.1f |\n", family, n, met, beyond, reached, most, samples / n
        all_met += met; all_beyond += beyond
        low = low || (family ~ /sparks|highlights/ ? reached < 0.8 * n : met < 0.95 * n)
    }
    $1 != family { if (n) row(); family = $1; n = met = beyond = reached = most = samples = 0 }
    {
        n++; met += $9; samples += $12; reached += $5 <= $3 + $14
        beyond += $9 && $5 > 1.1 * $3 + $14
        if ($5 / $3 > most) most = $5 / $3
    }
    END {
        row()
        printf "\nOf %d renders that report met, %d are beyond the target (%.1f %%).\n", all_met, all_beyond,
            all_met ? 100 * all_beyond / all_met : 0
        exit low || all_beyond > 0.03 * all_met
    }' "$folder/all.tsv" >"$folder/families.md" && ok=0 || ok=1
cat "$folder/families.md"
[ $ok = 0 ] || echo 'A bar is missed.' >&2
exit $ok
