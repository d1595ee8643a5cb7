#!/bin/sh
# SPDX-License-Identifier: MIT
# `make check-all`: everything, part by part, each with its own command, log and row in the table at the end.
#   tests/all.sh BUILD [PART…]      only these parts; `plan` prints the plan alone
# Passed parts are not run again while the tree is unchanged, and `mutants` continues where it was stopped;
# BUILD/all/TREE has their results. The minutes of the plan are those of the last run on this machine, or else
# those of the list, for two cores.
set -u
build=${1:-build}
shift
cd "$(dirname "$0")/.."
make="make -s BUILD=$build"

# Part, minutes, command, of which $make, $build and $timed are known. Its last line goes into the table.
list='
cases     11 PEN_CASES=all sh tests/run.sh $build
timed     12 PEN_TIMED=1 sh tests/run.sh $build $timed
asan      35 $make asan
tsan      60 $make tsan TESTS="tests/base/ tests/render/ tests/accel/ tests/store/ tests/jobs/ tests/access/ tests/http/ tests/study/"
load      10 PEN_TIMED=1 $make load
mutate    12 $make mutate MINUTES=10
front      2 $make front
page       3 $make page
soak      11 $make soak MINUTES=10
crash      5 PEN_TIMED=1 $make crash ROUNDS=200
postgres  15 $make postgres POSTGRES_ROUNDS=100
effects    3 $make effects-proof
promises  15 $make accuracy-promise audit-promise
eta        5 $make eta-promise
mutants  150 $make mutants
stability 60 $make stability
fuzz      26 $make fuzz MINUTES=2
models     1 sh tests/io/models.sh $build
'
# The tests that judge times.
timed=$(grep -lE 'PEN_TIMED|ck_assert_timed|suite_timed|^ *timed "' tests/*/*.c tests/*/*.sh | grep -vE '^tests/(support|crash|load)/|/lib\.sh')
timed=$(echo $timed)
known() { echo "$list" | awk 'NF { print $1 }'; }

[ "$*" != plan ] && only="$*" plan= || only='' plan=1
for part in $only; do
    known | grep -qx "$part" || {
        echo "check-all: there is no part \"$part\"; parts are:" $(known) >&2
        exit 2
    }
done
files() {
    if git rev-parse >/dev/null 2>&1; then
        git ls-files -co --exclude-standard
    else
        find . -type f ! -path './build*'
    fi
}
tree=$(files | sort | tr '\n' '\0' | xargs -0 sha1sum 2>/dev/null | sha1sum | cut -c 1-12)
here=$build/all/$tree
mkdir -p "$here/kept" "$build/all/minutes"
export MUTANTS_KEPT="$PWD/$here/kept"

wanted=$(known)
[ -z "$only" ] || wanted=$only
echo "The plan, for tree $tree:"
total=0
for part in $wanted; do
    minutes=$(echo "$list" | awk -v part="$part" '$1 == part { print $2 }')
    [ ! -s "$build/all/minutes/$part" ] || minutes=$(cat "$build/all/minutes/$part")
    if [ -s "$here/$part" ]; then
        echo "  $part: has passed"
    else
        total=$((total + minutes))
        echo "  $part: $minutes minutes:$(echo "$list" | sed -n "s/^$part  *[0-9]*//p")"
    fi
done
echo "  in all $total minutes, until $(date -d "+$total minutes" '+%H:%M')"
[ -z "$plan" ] || exit 0

failed=
for part in $wanted; do
    [ ! -s "$here/$part" ] || continue
    command=$(echo "$list" | sed -n "s/^$part  *[0-9]* //p")
    echo "== $part, since $(date '+%H:%M')"
    start=$(date +%s)
    (
        export make build timed
        nice -n 5 sh -c "$command" </dev/null >"$here/$part.log" 2>&1
        echo "$?" >"$here/$part.code"
        times >"$here/$part.times"
    )
    seconds=$(($(date +%s) - start))
    echo $((seconds / 60 + 1)) >"$build/all/minutes/$part"
    cpu=$(awk 'NR == 2 { gsub(/[ms]/, " "); printf "%d", $1 * 60 + $2 + $3 * 60 + $4 }' "$here/$part.times")
    code=$(cat "$here/$part.code")
    rm "$here/$part.code" "$here/$part.times"
    word=ok
    [ "$code" -eq 0 ] || word=FAILED failed="$failed $part"
    printf '%-6s %-9s %6d s %7d s of processor time   %s\n' "$word" "$part" "$seconds" "$cpu" \
        "$(grep -avE '^make|^$' "$here/$part.log" | tail -n 1 | cut -c 1-70)" >"$here/$part.row"
    [ "$code" -ne 0 ] || cp "$here/$part.row" "$here/$part"
    cat "$here/$part.row"
done
echo
echo "check-all of tree $tree ($(git describe --always --dirty 2>/dev/null || echo 'no git')):"
for part in $wanted; do
    cat "$here/$part.row"
done
[ -z "$failed" ] || {
    echo "failed:$failed; their logs are in $here"
    exit 1
}
