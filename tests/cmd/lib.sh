# SPDX-License-Identifier: MIT
# Helpers of the command line's tests: `. "$(dirname "$0")/lib.sh"` first, `finish` last.
# Each check prints `ok NAME` or `not ok NAME: why`; finish prints the closing line tests/run.sh
# reads. $work is a folder that goes away with the script, as do the daemons it started.
set -u
build=$(cd "${1:-build}" && pwd) || exit 1
root=$(cd "$(dirname "$0")/../.." && pwd)
penumbra=$build/penumbra
penumbrad=$build/penumbrad
work=$(mktemp -d) || exit 1
checks=0
failures=0
daemons=
unset PENUMBRA_URL PENUMBRA_TOKEN PENUMBRA_LISTEN PENUMBRA_STORE PENUMBRA_ROLE PENUMBRA_THREADS \
    PENUMBRA_TOKENS PENUMBRA_CONFIG PENUMBRA_LOG_FILE PENUMBRA_LOG_FORMAT PENUMBRA_LOG_LEVEL \
    STATE_DIRECTORY http_proxy https_proxy all_proxy HTTP_PROXY HTTPS_PROXY ALL_PROXY

cleanup() {
    for pid in $daemons; do
        kill -KILL "$pid" 2>/dev/null
    done
    rm -rf "$work"
}
trap cleanup EXIT
trap 'exit 1' INT TERM

ok() {
    checks=$((checks + 1))
    echo "ok $1"
}
fail() { # NAME WHY…
    checks=$((checks + 1))
    failures=$((failures + 1))
    name=$1
    shift
    echo "not ok $name: $*"
}
# check NAME COMMAND…: the command succeeds
check() {
    name=$1
    shift
    if "$@" >"$work/check.out" 2>&1; then
        ok "$name"
    else
        fail "$name" "exit $? of: $* $(head -c 600 "$work/check.out")"
    fi
}
# ends NAME CODE COMMAND…: the command ends with this exit code; $work/out and $work/err keep what
# it printed
ends() {
    name=$1
    want=$2
    shift 2
    "$@" >"$work/out" 2>"$work/err" <"${input:-/dev/null}"
    got=$?
    if [ "$got" -eq "$want" ]; then
        ok "$name"
    else
        fail "$name" "exit $got, not $want, of: $* $(head -c 600 "$work/err")"
    fi
}
# says NAME FILE TEXT: the file has the text in it
says() {
    if grep -qF -- "$3" "$2"; then
        ok "$1"
    else
        fail "$1" "no \"$3\" in: $(head -c 600 "$2")"
    fi
}
# equal NAME GOT WANTED
equal() {
    if [ "$2" = "$3" ]; then
        ok "$1"
    else
        fail "$1" "got \"$2\", wanted \"$3\""
    fi
}
finish() {
    passed=$((checks - failures))
    echo "$((checks ? passed * 100 / checks : 0))%: Checks: $checks, Failures: $failures, Errors: 0"
    [ "$failures" -eq 0 ] || exit 1
    exit 0
}

# daemon ARGUMENTS…: starts penumbrad on a free port; sets $daemon (its process id) and $url.
# Its log is $work/log, which grows from daemon to daemon.
daemon() {
    : >"$work/first"
    "$penumbrad" --listen 127.0.0.1:0 "$@" >"$work/first" 2>>"$work/log" </dev/null &
    daemon=$!
    daemons="$daemons $daemon"
    within 20 grep -q '^listening on ' "$work/first" || {
        fail "the daemon starts" "$(tail -n 5 "$work/log")"
        finish
    }
    url=$(sed -n '1s/^listening on //p' "$work/first")
    export PENUMBRA_URL="$url"
}
# within SECONDS COMMAND…: whether the command succeeds before the time is over
within() {
    tries=$(($1 * 50))
    shift
    while ! "$@" >/dev/null 2>&1; do
        tries=$((tries - 1))
        [ "$tries" -gt 0 ] || return 1
        sleep 0.02
    done
}
# child ROLE: the process id of the daemon's child in that role (api or work)
child() {
    pgrep -P "$daemon" "^penumbrad-$1\$"
}
gone() { # PID…: none of the processes is there any more
    for pid; do
        kill -0 "$pid" 2>/dev/null && return 1
    done
    return 0
}
# stop_daemon: SIGTERM; sets $code to its exit code and $took to whole seconds
stop_daemon() {
    from=$(date +%s)
    kill -TERM "$daemon"
    wait "$daemon"
    code=$?
    took=$(($(date +%s) - from))
}
