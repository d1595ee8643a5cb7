#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs every test program and test script of a build. Prints a line for each as soon as it has ended, the
# output of the failed ones, the ten slowest, the whole time, and `N passed, N failed, N skipped`.
#   tests/run.sh BUILD [PART…]      only tests whose paths contain one of the parts
# Many tests wait for a disk or a time, so twice as many as JOBS run at once. With PEN_TIMED they judge times
# (tests/support/suite.h), and one runs at a time. BUILD/tests/log has the output of each.
set -u
build=${1:-build}
[ $# -eq 0 ] || shift
cd "$(dirname "$0")/.."
jobs=$((${JOBS:-2} * 2))
[ -z "${PEN_TIMED:-}" ] || jobs=1
log=$build/tests/log
rm -rf "$log"
mkdir -p "$log"
start=$(date +%s)

# Scripts come first: they take longest, and long ones at the end would leave processors idle.
for file in tests/*/check_*.sh tests/cmd/*.sh tests/e2e/*.sh tests/*/test_*.c; do
    case $file in */lib.sh) continue ;; esac
    [ $# -gt 0 ] || echo "$file"
    for part; do
        case $file in *"$part"*) echo "$file" && break ;; esac
    done
done >"$log/files"

xargs -r -P "$jobs" -n 1 sh tests/run_one.sh "$log" "$build" <"$log/files"

sort -k 5 "$log/results" >"$log/sorted" # passed failed skipped cpu file seconds
grep -vxFf - "$log/files" >"$log/missing" <<EOF
$(cut -d' ' -f5 "$log/results")
EOF
while read -r file; do # killed from outside
    echo "0 1 0 0 $file 0" >>"$log/sorted"
    echo 'did not end' >"$log/$file.failure"
done <"$log/missing"
while read -r _ failed _ _ file _; do
    [ "$failed" -gt 0 ] || continue
    printf '\n== %s\n' "$file"
    sed 's/^/    /' "$log/$file.failure"
done <"$log/sorted"
echo
grep -h '^skipped: ' "$log"/tests/*/*.out | sort | uniq -c | sed 's/^ *\([0-9]*\) skipped: /skipped: \1 times: /'
sh tests/slowest.sh "$(($(date +%s) - start))" <"$log/sorted"
awk '{ passed += $1; failed += $2; skipped += $3 }
    END {
        printf "%d passed, %d failed%s\n", passed, failed, skipped ? ", " skipped " skipped" : ""
        exit failed > 0 || passed == 0
    }' "$log/sorted"
