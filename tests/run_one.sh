#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs one test program or script and judges it, for run.sh:
#   tests/run_one.sh LOG BUILD FILE
# prints a line, and adds a line to LOG/results: passed, failed, skipped, seconds of processor time, FILE,
# seconds. It writes the test's output to LOG/FILE.out and, after a failure, LOG/FILE.failure. A program or
# script ends with libcheck's line `P%: Checks: N, Failures: F, Errors: E`. Without this line it counts as one
# failure. For each check that it skipped, it has printed a line `skipped: NEED: WHY` (tests/needs.sh). A
# script that skips all checks ends with code 77.
set -u
log=$1 build=$2 file=$3
out=$log/$file.out
mkdir -p "$(dirname "$out")"

# The program that a test compares with.
PENUMBRA_PROGRAM=$build/penumbra
export PENUMBRA_PROGRAM

start=$(date +%s)
case $file in
*.c) timeout -k 10 3600 "$build/${file%.c}" >"$out" 2>&1 </dev/null ;;
*) timeout -k 10 3600 sh "$file" "$build" >"$out" 2>&1 </dev/null ;;
esac
code=$?
seconds=$(($(date +%s) - start))
times >"$out.times" # of this shell, and of the processes that it waited for, as 1m2.3s
cpu=$(awk 'NR == 2 { gsub(/[ms]/, " "); print $1 * 60 + $2 + $3 * 60 + $4 }' "$out.times")
rm "$out.times"

line=$(grep -aE '^[0-9]+%: Checks: [0-9]+, Failures: [0-9]+, Errors: [0-9]+' "$out" | tail -n 1)
checks=$(printf '%s' "$line" | sed -n 's/.*Checks: \([0-9]*\),.*/\1/p')
bad=$(printf '%s' "$line" | sed -n 's/.*Failures: \([0-9]*\), Errors: \([0-9]*\).*/\1 + \2/p')
checks=${checks:-0} bad=$((${bad:-0}))
skipped=$(grep -ac '^skipped: ' "$out")
if [ "$code" -eq 77 ] && [ "$skipped" -gt 0 ]; then
    checks=$skipped bad=0
elif [ "$code" -ne 0 ] && [ "$bad" -eq 0 ]; then
    echo "ended with code $code" >>"$out"
    bad=1 checks=$((checks + 1))
elif [ "$checks" -eq 0 ]; then
    echo 'printed no closing line' >>"$out"
    bad=1 checks=1
fi
case $file in *.sh) [ "$code" -eq 77 ] || checks=$((checks + skipped)) ;; esac # a skipped test of libcheck counts as one

word=ok
[ "$bad" -eq 0 ] || word=FAIL
[ "$skipped" -lt "$checks" ] || word=skip
printf '%-4s %-40s %4d checks %6.1f s of %3d\n' "$word" "$file" "$checks" "$cpu" "$seconds"
if [ "$bad" -gt 0 ]; then
    {
        grep -aE '^not ok|:[FE]:' "$out" | head -n 30
        echo '… the end of what it printed, but for these:'
        grep -avE '^not ok|^ok |:[FEP]:' "$out" | tail -n 30
    } >"$log/$file.failure"
fi
echo "$((checks - bad - skipped)) $bad $skipped $cpu $file $seconds" >>"$log/results"
