#!/bin/sh
# SPDX-License-Identifier: MIT
# Determinism across builds and processes, which no row inside one program can judge:
#   h101_killed     jobs of a daemon whose processes are killed give the same pictures
#   h103_compilers  gcc and clang, -O1, -O2 and -O3, and gcc's optimisation at link time, give the
#                   same films and accumulators
#   h104_libm       glibc's variants without FMA and AVX2 change nothing; no libm in the library
#   tests/property/matrix.sh BUILD [ROW…]      only these rows
# Writes BUILD/stability/matrix.json, of which `stability --also` makes rows of the report. Exit 1
# if a row failed.
set -u
build=$1
shift
only=" $* "
cd "$(dirname "$0")/../.." || exit 2
out=$build/stability
facts=$out/facts
films=tests/property/films
make=${MAKE:-make}
unset MAKEFLAGS MAKELEVEL PENUMBRA_ISA
failed=0
mkdir -p "$out"
: >"$facts"
rm -f "$out/matrix.json"

wanted() {
    case $only in "  " | *" $1 "*) ;; *) return 1 ;; esac
    cases=0 failures=0 why= begun=$(date +%s)
}

# result ID NAME WHAT ORACLE: of what `agrees` and others have counted.
result() {
    [ "$cases" -gt 0 ] || failures=1 why="nothing was judged"
    echo "$2: $cases cases, $failures failures${why:+: $why}"
    jq -nc --arg id "$1" --arg name "$2" --arg what "$3" --arg oracle "$4" --arg why "$why" \
        --argjson cases "$cases" --argjson failures "$failures" \
        --argjson seconds $(($(date +%s) - begun)) \
        '{id: $id, name: $name, what: $what, oracle: $oracle, why: $why, cases: $cases,
          failures: $failures, seconds: $seconds}' >>"$facts"
    [ "$failures" -eq 0 ] || failed=1
}

wrong() { # WHAT
    failures=$((failures + 1))
    why=${why:+$why; }$1
}

# agrees NAME COMMAND…: the films that the command makes are those of the table, and have the
# accumulators of the first command.
agrees() {
    name=$1
    shift
    cases=$((cases + 1))
    "$@" >"$out/films" 2>"$out/said" || wrong "$name: $(head -n 1 "$out/said")"
    [ -e "$out/accumulators" ] || cp "$out/films" "$out/accumulators"
    different=$(diff "$out/accumulators" "$out/films" | grep -c '^>')
    [ "$different" -eq 0 ] || wrong "$name: $different films have other accumulators"
}

rm -f "$out/accumulators"
$make -s BUILD="$build" "$build/$films" >/dev/null || exit 2

if wanted h104_libm; then
    agrees "glibc's choice" "$build/$films"
    agrees "without AVX2 and FMA" env GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4 "$build/$films"
    agrees "AVX-512" env PENUMBRA_ISA=avx512 "$build/$films"
    agrees "AVX2" env PENUMBRA_ISA=avx2 "$build/$films"
    agrees "baseline" env PENUMBRA_ISA=base "$build/$films"
    agrees "baseline without AVX2 and FMA" env PENUMBRA_ISA=base \
        GLIBC_TUNABLES=glibc.cpu.hwcaps=-AVX2,-FMA,-FMA4 "$build/$films"
    cases=$((cases + 1))
    found=$(sh deploy/libm.sh "$build/libpenumbra.a" | tr '\n' ' ')
    [ -z "$found" ] || wrong "libpenumbra.a calls $found"
    result "H104" h104_libm "every golden film, and the values it is rounded from, with glibc's \
variants for AVX2 and FMA masked off, by every set of instructions; the library calls no libm but \
sqrt, fma and rounding" "golden hashes; itself; nm -u"
fi

if wanted h103_compilers; then
    for compiler in gcc clang; do
        command -v $compiler >/dev/null || {
            why="$compiler is not installed"
            continue
        }
        for level in -O1 -O2 -O3 -flto; do
            into=$out/$compiler$level options=$level
            if [ $level = -flto ]; then
                [ $compiler = gcc ] || continue # clang needs a linker of its own for it
                options="-O2 -flto"
            fi
            if $make -s -j"${JOBS:-$(nproc)}" BUILD="$into" CC=$compiler OPT="$options" \
                "$into/$films" >"$out/said" 2>&1; then
                agrees "$compiler $level" "$into/$films"
                agrees "$compiler $level AVX-512" env PENUMBRA_ISA=avx512 "$into/$films"
                agrees "$compiler $level AVX2" env PENUMBRA_ISA=avx2 "$into/$films"
                agrees "$compiler $level baseline" env PENUMBRA_ISA=base "$into/$films"
            else
                wrong "$compiler $level does not build: $(grep -m1 error "$out/said")"
            fi
            echo "  $compiler $level: $failures failures so far"
        done
    done
    result "H103" h103_compilers "every golden film, and the values it is rounded from, made by gcc \
and clang with -O1, -O2 and -O3, and by gcc with -O2 -flto, by every set of instructions" "golden hashes; the first build"
fi

if wanted h101_killed; then
    rounds=5
    $make -s -j"${JOBS:-$(nproc)}" BUILD="$build" all "$build/tests/crash/crash" >/dev/null || exit 2
    cases=$rounds
    "$build/tests/crash/crash" "$build" $rounds >"$out/said" 2>&1 || wrong "$(tail -n 1 "$out/said")"
    result "H101" h101_killed "jobs of a daemon whose processes are killed, stopped and drained end \
with the same pictures (rounds of make crash)" "undisturbed run, byte for byte"
fi

jq -s '{rows: .}' "$facts" >"$out/matrix.json"
rm -f "$facts" "$out/films" "$out/said" "$out/accumulators"
exit $failed
