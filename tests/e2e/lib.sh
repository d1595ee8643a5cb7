# SPDX-License-Identifier: MIT
# Helpers of the end-to-end tests: a daemon of the script's own on a free port with a temporary store,
# requests through curl, and checks that print `ok NAME` or `not ok NAME: reason`.
# A script reads this file with `.` and ends with `finish`; its first argument is the build folder. A
# trap stops the daemon when the script ends.
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
hang=300 # seconds after which a test gives up
# What must be shorter or longer than something else is so many times as long on a build with sanitizers,
# which runs several times slower.
patience=1
[ -z "${PEN_FEWER:-}" ] || patience=4 # see tests/support/random.h

# With PEN_TLS=1 the daemon serves HTTPS, and its clients need a token, which curl then sends by itself.
access=
make_certificate() {
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=localhost \
        -addext subjectAltName=DNS:localhost,IP:127.0.0.1 -keyout "$work/key.pem" -out "$work/cert.pem" \
        2>>"$work/log"
}
if [ -n "${PEN_TLS:-}" ]; then
    make_certificate
    PENUMBRA_TOKEN=$("$build/penumbrad" token add test --scope admin --tokens "$work/tokens" 2>>"$work/log")
    export PENUMBRA_TOKEN PENUMBRA_CA="$work/cert.pem" CURL_HOME="$work"
    printf 'cacert = "%s"\nheader = "Authorization: Bearer %s"\n' "$PENUMBRA_CA" "$PENUMBRA_TOKEN" >"$work/.curlrc"
    access="--tokens $work/tokens --tls-cert $work/cert.pem --tls-key $work/key.pem"
fi

daemon_stop() { # [SIGNAL]: stops the daemon, and sets $stopped to its exit code
    [ -n "$daemon" ] || return 0
    kill "-${1:-TERM}" "$daemon" 2>/dev/null
    for _ in $(seq $((hang * 20))); do
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.05
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

# daemon_start [ARGUMENT…]: starts a daemon with these arguments and $threads threads (default 1), and
# sets $daemon and $url once it is ready. It listens on $listen, if that is set, else on a free port.
daemon_start() {
    : >"$work/out"
    "$build/penumbrad" --listen "${listen:-127.0.0.1:0}" --store "$store" --threads "${threads:-1}" $access "$@" \
        >"$work/out" 2>>"$work/log" &
    daemon=$!
    for _ in $(seq $((hang * 20))); do
        url=$(sed -n 's/^listening on \(https*:.*\)$/\1/p' "$work/out")
        if [ -n "$url" ] && [ "$(curl -sk -o /dev/null -w '%{http_code}' "$url/readyz")" = 200 ]; then
            return 0
        fi
        kill -0 "$daemon" 2>/dev/null || break
        sleep 0.05
    done
    if kill -0 "$daemon" 2>/dev/null; then
        echo "the daemon does not become ready: $(curl -sk -m 9 "$url/readyz")"
    else
        wait "$daemon"
        echo "the daemon does not start, exit code $?:"
        daemon=
    fi
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

# expect NAME ACTUAL EXPECTED: the two are equal.
expect() {
    if [ "$2" = "$3" ]; then
        ok "$1"
    else
        not_ok "$1" "got \"$2\", expected \"$3\""
    fi
}

# expect_match NAME ACTUAL PATTERN: the text matches the shell pattern.
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
    : >"$work/body" # curl does not write it if the answer has no body
    status=$(curl -sS -m "$hang" -o "$work/body" -D "$work/head" -w '%{http_code}' "$@" "$url$path" \
        2>"$work/curl") || status="curl: $(cat "$work/curl")"
}

# header NAME: prints the field's value in the last answer.
header() {
    tr -d '\r' <"$work/head" | sed -n "s/^$1: //Ip" | tail -n 1
}

# body FILTER: prints the output of jq on the last answer.
body() {
    jq -r "$1" "$work/body" 2>/dev/null
}

# expect_problem NAME STATUS [DETAIL-PATTERN]: the last answer is a problem document with this status
# and a matching detail.
expect_problem() {
    got="$status $(header content-type) $(body '"\(.status) \(has("type") and has("title"))"')"
    expect "$1" "$got" "$2 application/problem+json $2 true"
    [ $# -lt 3 ] || expect_match "$1-detail" "$(body .detail)" "$3"
}

# within COMMAND…: repeats the command until it succeeds. Fails after $hang seconds, since then it seems
# never to succeed; no time that a test judges is so long.
within() {
    give_up=$(($(date +%s) + hang))
    while ! "$@" >/dev/null 2>&1; do
        [ "$(date +%s)" -lt "$give_up" ] || return 1
        sleep 0.1
    done
}

# timed NAME MS LIMIT-MS: something took less than the limit. Judged only with PEN_TIMED, which `make
# check-all PARTS=timed` sets, since a slow machine would fail.
timed() {
    if [ -z "${PEN_TIMED:-}" ] || [ "$2" -lt "$3" ]; then
        [ -z "${PEN_TIMED:-}" ] || ok "$1"
    else
        not_ok "$1" "took $2 ms, allowed are $3"
    fi
}

now_ms() { # since the machine's start
    awk '{ printf "%d", $1 * 1000 }' /proc/uptime
}

# skip NEED WHY: says that a check is skipped; NEED is a word that tests/needs.sh knows.
skip() {
    echo "skipped: $1: $2"
}

# submit JSON [CURL-ARGUMENT...]: sets $job to the new job's path.
submit() {
    json=$1
    shift
    call /v1/jobs -H 'Content-Type: application/json' --data-binary "$json" "$@"
    job=$(header location)
}

# A job of a few milliseconds, and one that is still running whenever a test checks it.
small='{"scene": "builtin:spheres", "render": {"width": 64, "height": 48}}'
long='{"scene": "builtin:spheres", "render": {"width": 4000, "height": 4000, "samples_per_pixel": 64}}'

# Removes from the log a sanitizer's report of the null pointer that an injected segv writes to: of the
# sanitizer for undefined behaviour, or of that for threads.
forget_injected_segv() {
    sed -i '/fault_injection\.c:.*runtime error: store to null pointer/d' "$work/log"
    perl -0pi -e 's/ThreadSanitizer:DEADLYSIGNAL\n(?:(?!ABORTING).)*?fault_injection\.c.*?ABORTING\n//gs' "$work/log"
}

# Stops the daemon and checks that no sanitizer reported an error or a leak in its log.
check_sanitizer_reports() {
    daemon_stop
    [ -e "$work/log" ] || return 0
    if grep -q -e 'Sanitizer' -e 'runtime error:' "$work/log"; then
        not_ok no-sanitizer-reports "$(grep -A 12 -e 'Sanitizer' -e 'runtime error:' "$work/log" |
            head -n 40)"
    else
        ok no-sanitizer-reports
    fi
}

# Prints the summary and ends the script; exit code 0 if all checks passed.
finish() {
    check_sanitizer_reports
    good=100
    [ "$checks" -eq 0 ] || good=$(((checks - failures) * 100 / checks))
    echo "$good%: Checks: $checks, Failures: $failures, Errors: 0"
    [ "$failures" -eq 0 ] && exit 0
    exit 1
}
