# SPDX-License-Identifier: MIT
# Shared by the end-to-end tests: a daemon of the script's own on a free port with a temporary store,
# requests through curl, and checks that print `ok NAME` or `not ok NAME: why`.
# A script whose first argument is the build folder reads this file with `.` and ends with `finish`.
# A trap ends the daemon.
set -u
build=${1:-build}
case $build in /*) ;; *) build=$PWD/$build ;; esac
work=$(mktemp -d)
store=$work/penumbra.db
daemon= # process id
url=
checks=0
failures=0
status= # of the last call

daemon_stop() { # [SIGNAL]
    [ -n "$daemon" ] || return 0
    kill "-${1:-TERM}" "$daemon" 2>/dev/null
    for _ in $(seq 500); do
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.02
    done
    kill -KILL "$daemon" 2>/dev/null
    wait "$daemon" 2>/dev/null
    stopped=$?
    daemon=
    return 0
}

clean_up() {
    daemon_stop
    rm -rf "$work"
}
trap clean_up EXIT
trap 'exit 129' HUP
trap 'exit 130' INT
trap 'exit 143' TERM

# Starts a daemon with $threads threads (2) and sets $url. Extra arguments go to it.
daemon_start() {
    : >"$work/out"
    "$build/penumbrad" --listen 127.0.0.1:0 --store "$store" --threads "${threads:-2}" "$@" \
        >"$work/out" 2>>"$work/log" &
    daemon=$!
    for _ in $(seq 500); do
        url=$(sed -n 's/^listening on \(http:.*\)$/\1/p' "$work/out")
        if [ -n "$url" ] && [ "$(curl -s -o /dev/null -w '%{http_code}' "$url/readyz")" = 200 ]; then
            return 0
        fi
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.02
    done
    echo "the daemon does not start:"
    tail -n 20 "$work/log"
    not_ok daemon-starts "see above"
    finish
}

ok() {
    checks=$((checks + 1))
    echo "ok $1"
}

not_ok() {
    checks=$((checks + 1))
    failures=$((failures + 1))
    echo "not ok $1: $2"
}

# expect NAME ACTUAL EXPECTED
expect() {
    if [ "$2" = "$3" ]; then
        ok "$1"
    else
        not_ok "$1" "got \"$2\", expected \"$3\""
    fi
}

# expect_match NAME ACTUAL PATTERN (of the shell)
expect_match() {
    # shellcheck disable=SC2254
    case $2 in
    $3) ok "$1" ;;
    *) not_ok "$1" "got \"$2\", expected a match of \"$3\"" ;;
    esac
}

# call PATH [CURL-ARGUMENT...]: sets $status, writes $work/head and $work/body.
call() {
    path=$1
    shift
    : >"$work/body" # curl leaves it alone when there is no body
    status=$(curl -sS -m 90 -o "$work/body" -D "$work/head" -w '%{http_code}' "$@" "$url$path" \
        2>"$work/curl") || status="curl: $(cat "$work/curl")"
}

# header NAME: the field's value in the last answer.
header() {
    tr -d '\r' <"$work/head" | sed -n "s/^$1: //Ip" | tail -n 1
}

# body FILTER: jq on the last answer.
body() {
    jq -r "$1" "$work/body" 2>/dev/null
}

# expect_problem NAME STATUS [DETAIL-PATTERN]: the last answer is a problem document that says so.
expect_problem() {
    got="$status $(header content-type) $(body .status) $(body 'has("type") and has("title")')"
    expect "$1" "$got" "$2 application/problem+json $2 true"
    [ $# -lt 3 ] || expect_match "$1-says-what" "$(body .detail)" "$3"
}

# submit JSON [CURL-ARGUMENT...]: sets $job to the new job's path.
submit() {
    json=$1
    shift
    call /v1/jobs -H 'Content-Type: application/json' --data-binary "$json" "$@"
    job=$(header location)
}

# A small job, done within milliseconds; and one that is still running whenever a test checks it.
small='{"scene": "builtin:spheres", "render": {"width": 64, "height": 48}}'
long='{"scene": "builtin:spheres", "render": {"width": 4000, "height": 4000, "samples_per_pixel": 64}}'

# Removes from the log what a sanitizer says of the null pointer that an injected segv writes to.
forget_injected_segv() {
    sed -i '/fault_injection\.c:.*runtime error: store to null pointer/d' "$work/log"
}

# Fails if a daemon built with sanitizers reported an error or a leak in its log.
look_for_reports() {
    daemon_stop
    [ -e "$work/log" ] || return 0
    if grep -q -e 'Sanitizer' -e 'runtime error:' "$work/log"; then
        not_ok no-sanitizer-reports "$(grep -A 12 -e 'Sanitizer' -e 'runtime error:' "$work/log" |
            head -n 40)"
    else
        ok no-sanitizer-reports
    fi
}

finish() {
    look_for_reports
    good=100
    [ "$checks" -eq 0 ] || good=$(((checks - failures) * 100 / checks))
    echo "$good%: Checks: $checks, Failures: $failures, Errors: 0"
    [ "$failures" -eq 0 ] && exit 0
    exit 1
}
