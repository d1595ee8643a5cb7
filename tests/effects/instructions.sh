#!/bin/sh
# SPDX-License-Identifier: MIT
# Counts the instructions of a frame under callgrind. It compares a compiled kernel with the same kernel,
# stripped by hand of the effects that it does not have (tests/effects/stripped). It also compares a frame
# with an effect without consequence and a frame without this effect (tests/support/forms.c):
#   tests/effects/instructions.sh BUILD
# Prints tables; exit 1 if a ratio is above the limit, if a stripped kernel gives other bits, or if valgrind
# is missing.
set -u
build=${1:-build}
cd "$(dirname "$0")/../.." || exit 1
limit=1.02
program=$build/tests/effects/instructions
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
if ! command -v valgrind >/dev/null; then
    echo "valgrind is missing: it counts the instructions"
    exit 1
fi
PENUMBRA_ISA=avx2
export PENUMBRA_ISA

# count SET SCENE WHICH: the instructions of the frame.
count() {
    valgrind --tool=callgrind --toggle-collect=proof_frame --callgrind-out-file="$work/out" \
        "$program" "$1" "$2" "$3" >"$work/log" 2>&1 || cat "$work/log" >&2
    sed -n 's/^totals: *\([0-9]*\).*/\1/p' "$work/out"
    rm -f "$work/out"
}

# judge NAME SCENE COUNT OF: a row of a table.
judge() {
    echo "$@" | awk -v limit=$limit '{
        ok = NF == 4 && $3 > 1e6 && $4 > 1e6 && $3 / $4 <= limit
        printf "%-24s %-30s %10d %10d %8.4f %6.2f  %s\n", $1, $2, $3, $4, $4 ? $3 / $4 : 0, limit,
            ok ? "ok" : "FAILED"
        exit !ok
    }' || failed=1
}

failed=0
heads='%-24s %-30s %10s %10s %8s %6s\n'
# shellcheck disable=SC2059 # the format is a constant
printf "$heads" set scene compiled stripped ratio limit
for set in none hard soft mirror; do
    for scene in ${SCENES:-scenes/spheres.json scenes/room.json}; do
        if ! "$program" "$set" "$scene"; then
            failed=1
            continue
        fi
        judge "$set" "$scene" "$(count "$set" "$scene" compiled)" "$(count "$set" "$scene" stripped)"
    done
done
# shellcheck disable=SC2059
printf "$heads" form scene idle without ratio limit
scene=tests/effects/scenes/plain.json
for form in $(sed -n 's/^    {"\([a-z0-9-]*\)", PEN_FX_.*/\1/p' tests/support/forms.c); do
    judge "$form" "$scene" "$(count "$form" "$scene" idle)" "$(count "$form" "$scene" without)"
done
exit "$failed"
