#!/bin/sh
# SPDX-License-Identifier: MIT
# A sky that no ray meets, and checkers of two equal colours, change no byte and no ray of a scene, and
# cost at most 2 % of its instructions.
case ${1:-build} in
*asan* | *tsan*)
    echo "skipped: plain-build: instructions with sanitizers are not those that are installed"
    exit 77
    ;;
esac
. "$(dirname "$0")/../e2e/lib.sh"
cd "$(dirname "$0")/../.." || exit 1

# render FORM [COMMAND…]: renders the form of the scene, by a command.
render() {
    form=$1
    shift
    "$@" "$build/penumbra" render "tests/effects/scenes/$form.json" -q --threads 1 -o "$work/$form.png" \
        --stats "$work/$form.stats" >"$work/log" 2>&1
}
rays() { tr -d '\n ' <"$work/$1.stats" | sed 's/.*"rays":{\([^}]*\)}.*/\1/'; }
# count FORM: the instructions of the whole program.
count() {
    PENUMBRA_ISA=avx2 render "$1" valgrind --tool=callgrind --callgrind-out-file="$work/out"
    sed -n 's/^totals: *\([0-9]*\).*/\1/p' "$work/out"
}

render plain
for form in plain_unseen_sky plain_equal_pattern; do
    render "$form"
    expect "$form: the same bytes" "$(cmp "$work/$form.png" "$work/plain.png" 2>&1)" ""
    expect "$form: the same rays" "$(rays "$form")" "$(rays plain)"
done
if command -v valgrind >/dev/null && grep -qw avx2 /proc/cpuinfo 2>/dev/null; then
    plain=$(count plain)
    for form in plain_unseen_sky plain_equal_pattern; do
        expect "$form: at most 1.02 times the instructions" \
            "$(echo "$(count "$form") $plain" | awk '{print ($2 > 1e6 && $1 <= 1.02 * $2) ? "ok" : $0}')" ok
    done
else
    skip command-valgrind "the instructions of the scene with idle effects"
fi
finish
