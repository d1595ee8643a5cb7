#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs every test program and test script of a build and ends with `N passed, N failed`.
#   tests/run.sh BUILD [NAME-PART]      only those whose path contains NAME-PART
# JOBS of them and one more run at a time, since many wait for a disk or for a time to pass, and not
# more than 4, since they have threads of their own. Reports are printed whole, in the order of the
# list; run_one.sh decides what has passed.
set -u
build=${1:-build}
part=${2:-}
cd "$(dirname "$0")/.."
jobs=$((${JOBS:-2} + 1))
[ "$jobs" -le 4 ] || jobs=4

# Mostly wait, with limits of seconds that a busy machine keeps as well: one at a time beside the others.
waiting='tests/cmd/crash_loop'

# The others hold times against limits or against each other, and so would judge their neighbours.
# They run when all of the above are done. Two at a time, since they need little of a processor:
#   test_server, test_connections
#                          connections that must be closed within seconds, not before and not after
#   quarantine, supervisor deadlines of seconds for what takes many processes
#   connections            thousands of clients, who must be answered within seconds
#   readme                 waits a minute for large pictures, as the README's text does
paired='tests/http/test_server tests/http/test_connections tests/cmd/quarantine tests/cmd/supervisor
tests/e2e/connections tests/e2e/readme'
# And one at a time:
#   test_events, events    when changes are told, in milliseconds
#   test_traffic           how often a worker calls the store, which depends on how long work takes
#   test_bench, bench      measure, and compare what they measured
alone='tests/http/test_events tests/jobs/test_traffic tests/study/test_bench tests/cmd/bench
tests/e2e/events'

work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
trap 'exit 130' INT
trap 'exit 143' TERM

# Scripts come first: they take longest, and long ones at the end would leave processors idle.
for file in tests/*/check_*.sh tests/cmd/*.sh tests/e2e/*.sh tests/*/test_*.c; do
    name=${file%.*}
    case $file in *'*'* | */lib.sh) continue ;; esac
    case $name in *"$part"*) ;; *) continue ;; esac
    list=together
    for special in waiting paired alone; do
        eval "names=\$$special"
        case " $(echo $names) " in *" $name "*) list=$special ;; esac
    done
    echo "$file" >>"$work/$list"
done
touch "$work/together" "$work/waiting" "$work/paired" "$work/alone"

# Reads the names of those that are done, and prints their lines as soon as their turn has come.
report() {
    passed=0 failed=0 broken=
    set -- $(cat "$work/together" "$work/waiting" "$work/paired" "$work/alone")
    while read -r _; do
        while [ $# -gt 0 ] && [ -e "$work/$1/report" ]; do
            count "$1"
            shift
        done
    done
    for file; do # never happens unless a process is killed from outside
        failed=$((failed + 1)) broken="$broken $file"
    done
    for file in $broken; do
        echo
        cat "$work/$file/report" 2>/dev/null || echo "FAIL $file did not end"
    done
    echo "$passed passed, $failed failed"
    [ "$failed" -eq 0 ] && [ "$passed" -gt 0 ]
}

count() { # FILE: prints its line and adds it up
    head -n 1 "$work/$1/report"
    read -r good bad <"$work/$1/counts"
    passed=$((passed + good)) failed=$((failed + bad))
    [ "$bad" -eq 0 ] || broken="$broken $1"
}

each() { # LIST COUNT: runs the files of a list, so many at a time
    xargs -r -P "$2" -n 1 sh tests/run_one.sh "$work" "$build" <"$work/$1"
}
{
    each waiting 1 &
    each together "$jobs"
    wait
    each paired 2
    each alone 1
} | report
