#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs one test program or script and judges it, for run.sh:
#   tests/run_one.sh FOLDER BUILD FILE
# writes FOLDER/FILE/counts (passed, failed) and then FOLDER/FILE/report (a line, and after a failure what
# it printed), and prints FILE when that is done.
# A program or script closes with libcheck's line `P%: Checks: N, Failures: F, Errors: E`; one that
# does not counts as one failure, whatever it printed. A script that cannot test a build of this kind
# prints `skipped: WHY` and ends with code 77; it counts neither as passed nor as failed.
set -u
folder=$1/$3 build=$2 file=$3
name=${file%.*}
out=$folder/out
mkdir -p "$folder"

# The program that a test compares with.
PENUMBRA_PROGRAM=$build/penumbra
export PENUMBRA_PROGRAM

start=$(date +%s)
case $file in
*.c) "$build/$name" >"$out" 2>&1 </dev/null ;;
*) sh "$file" "$build" >"$out" 2>&1 </dev/null ;;
esac
code=$?
seconds=$(($(date +%s) - start))

line=$(grep -aE '^[0-9]+%: Checks: [0-9]+, Failures: [0-9]+, Errors: [0-9]+' "$out" | tail -n 1)
checks=$(printf '%s' "$line" | sed -n 's/.*Checks: \([0-9]*\),.*/\1/p')
bad=$(printf '%s' "$line" | sed -n 's/.*Failures: \([0-9]*\), Errors: \([0-9]*\).*/\1 + \2/p')
bad=$((${bad:-0}))
checks=${checks:-0}
skipped=
[ "$code" -ne 77 ] || skipped=$(sed -n 's/^skipped: //p' "$out" | tail -n 1)
if [ -n "$skipped" ]; then
    bad=0 checks=0
elif [ "$code" -ne 0 ] && [ "$bad" -eq 0 ]; then
    bad=1
    checks=$((checks + 1))
elif [ "$checks" -eq 0 ]; then
    bad=1 checks=1
    echo "printed no closing line" >>"$out"
fi

if [ -n "$skipped" ]; then
    printf 'skip %-44s %s\n' "$name" "$skipped"
elif [ "$bad" -gt 0 ]; then
    printf 'FAIL %-44s %4d of %d failed (exit %d, %d s)\n' "$name" "$bad" "$checks" "$code" "$seconds"
    grep -aE '^not ok|:[FE]:' "$out" | head -n 30 | sed 's/^/    /'
    echo "    … the end of what it printed:"
    tail -n 40 "$out" | sed 's/^/    /'
else
    printf 'ok   %-44s %4d checks %4d s\n' "$name" "$checks" "$seconds"
fi >"$folder/report.part"
echo "$((checks - bad)) $bad" >"$folder/counts"
rm "$out"
mv "$folder/report.part" "$folder/report"
echo "$file"
