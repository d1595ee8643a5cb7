#!/bin/sh
# SPDX-License-Identifier: MIT
# A fifth of what `make load` does: clients that hold connections without using them do not keep others
# from their answers, and what they hold is free when they have gone. Times are wide, since the machine
# may be busy; `make load` has the real ones.
. "$(dirname "$0")/lib.sh"
. "$(dirname "$0")/../load/lib.sh"
ulimit -n "$(ulimit -Hn)"
[ "$(ulimit -n)" = unlimited ] || [ "$(ulimit -n)" -ge 4096 ] || {
    echo "skipped: needs 4096 open files"
    exit 77
}
load_start

# 2200 connections with halves of heads, more than the limit of those that trickle would need.
"$load" half "$port" 1100 3 >"$work/values"
expect half-health-failed "$(value health-failed)" 0
below health-p99-ms $((2000 * patience))

"$load" crowd "$port" "$api" "$job" "$picture" 20 4 >"$work/values"
expect idle "$(value idle)" 1000
expect polls "$(value polls)" 102
expect streams "$(value streams)" 100
expect readers "$(value readers)" 20
expect health-failed "$(value health-failed)" 0
expect job-failed "$(value job-failed)" 0
below health-p99-ms $((2000 * patience))
below job-p99-ms $((2000 * patience))
below closed-freed-s $((10 * patience))
vanished_s=45
[ "$patience" -eq 1 ] || vanished_s=59 # `load` waits for 60
below vanished-freed-s $vanished_s
# Sanitizers need more memory than the program.
case $build in *san) ;; *) below resident-mib 150 ;; esac
finish
