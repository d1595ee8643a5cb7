#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs every test program and test script of a build and ends with `N passed, N failed`.
#   tests/run.sh BUILD [NAME-PART]      only those whose path contains NAME-PART
# A program or script closes with libcheck's line `P%: Checks: N, Failures: F, Errors: E`; one that
# does not counts as one failure, whatever it printed.
set -u
build=${1:-build}
part=${2:-}
cd "$(dirname "$0")/.."
passed=0 failed=0 broken=
out=$(mktemp)
trap 'rm -f "$out"' EXIT

run_one() { # name command...
    name=$1
    shift
    case $name in *"$part"*) ;; *) return ;; esac
    start=$(date +%s)
    "$@" >"$out" 2>&1 </dev/null
    code=$?
    line=$(grep -aE '^[0-9]+%: Checks: [0-9]+, Failures: [0-9]+, Errors: [0-9]+' "$out" | tail -n 1)
    checks=$(printf '%s' "$line" | sed -n 's/.*Checks: \([0-9]*\),.*/\1/p')
    bad=$(printf '%s' "$line" | sed -n 's/.*Failures: \([0-9]*\), Errors: \([0-9]*\).*/\1 + \2/p')
    bad=$((${bad:-0}))
    checks=${checks:-0}
    if [ "$code" -ne 0 ] && [ "$bad" -eq 0 ]; then
        bad=1
        checks=$((checks + 1))
    elif [ "$checks" -eq 0 ]; then
        bad=1 checks=1
        echo "printed no closing line" >>"$out"
    fi
    passed=$((passed + checks - bad))
    failed=$((failed + bad))
    if [ "$bad" -gt 0 ]; then
        broken="$broken $name"
        printf 'FAIL %-44s %4d of %d failed (exit %d)\n' "$name" "$bad" "$checks" "$code"
        grep -aE '^not ok|:[FE]:' "$out" | head -n 30 | sed 's/^/    /'
        echo "    … the end of what it printed:"
        tail -n 25 "$out" | sed 's/^/    /'
    else
        printf 'ok   %-44s %4d checks %4d s\n' "$name" "$checks" "$(($(date +%s) - start))"
    fi
}

for source in tests/*/test_*.c; do
    [ -e "$source" ] || continue
    name=${source%.c}
    run_one "$name" "$build/$name"
done
for script in tests/cmd/*.sh tests/e2e/*.sh tests/*/check_*.sh; do
    [ -e "$script" ] || continue
    [ "$(basename "$script")" = lib.sh ] && continue
    run_one "${script%.sh}" sh "$script" "$build"
done

[ -z "$broken" ] || echo "failed:$broken"
echo "$passed passed, $failed failed"
[ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
