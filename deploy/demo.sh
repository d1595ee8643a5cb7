#!/bin/sh
# SPDX-License-Identifier: MIT
# The whole way once. demo.sh BUILD starts a daemon with a temporary store, POSTs scenes/room.json with curl,
# follows the job, and leaves BUILD/demo/room.png and stats.json. It always stops the daemon.
set -eu
build=${1:-build}
cd "$(dirname "$0")/.."
case $build in /*) ;; *) build=$PWD/$build ;; esac
demo=$build/demo
work=$(mktemp -d)
daemon=

finish() {
    code=$?
    trap - EXIT
    if [ -n "$daemon" ]; then
        kill "$daemon" 2>/dev/null || :
        wait "$daemon" 2>/dev/null || :
    fi
    if [ "$code" -ne 0 ]; then
        echo "demo: failed" >&2
        [ ! -s "$work/log" ] || { echo "demo: the daemon's last words:" && tail -n 20 "$work/log"; } >&2
    fi
    rm -rf "$work"
    exit "$code"
}
trap finish EXIT
trap 'exit 130' INT
trap 'exit 143' TERM HUP

fail() {
    echo "demo: $*" >&2
    exit 1
}
for program in "$build/penumbrad" "$build/penumbra"; do
    [ -x "$program" ] || fail "there is no $program: run make first"
done
command -v curl >/dev/null || fail "there is no curl: run sh deploy/install-deps.sh"
unset PENUMBRA_URL PENUMBRA_TOKEN PENUMBRA_LISTEN PENUMBRA_STORE PENUMBRA_ROLE PENUMBRA_THREADS \
    PENUMBRA_MAX_TIMEOUT PENUMBRA_TOKENS PENUMBRA_CONFIG PENUMBRA_LOG_FILE PENUMBRA_LOG_FORMAT \
    PENUMBRA_LOG_LEVEL PENUMBRA_UNTIL_IDLE
mkdir -p "$demo"
rm -f "$demo/room.png" "$demo/stats.json"

: >"$work/first"
"$build/penumbrad" --listen 127.0.0.1:0 --store "$work/penumbra.db" >"$work/first" 2>"$work/log" &
daemon=$!
tries=0
until url=$(sed -n '1s/^listening on //p' "$work/first") && [ -n "$url" ]; do
    kill -0 "$daemon" 2>/dev/null || fail "the daemon did not start"
    tries=$((tries + 1))
    [ "$tries" -lt 200 ] || fail "the daemon does not say where it listens"
    sleep 0.05
done
echo "demo: the daemon listens on $url"

# It listens before its store is open.
tries=0
until curl -sf --noproxy '*' -o /dev/null "$url/readyz"; do
    kill -0 "$daemon" 2>/dev/null || fail "the daemon has ended"
    tries=$((tries + 1))
    [ "$tries" -lt 200 ] || fail "the daemon does not become ready: $(curl -s --noproxy '*' "$url/readyz")"
    sleep 0.05
done

echo "demo: curl --data-binary @scenes/room.json $url/v1/jobs"
answer=$(curl -sS --noproxy '*' -o "$work/job" -D "$work/head" -w '%{http_code}' \
    --data-binary @scenes/room.json "$url/v1/jobs") || fail "curl cannot reach the daemon"
if [ "$answer" != 202 ]; then
    cat "$work/job" >&2
    fail "the daemon answered $answer"
fi
job=$(tr -d '\r' <"$work/head" | sed -n 's/^[Ll]ocation: //p')
id=${job##*/}
echo "demo: job $id is on disk, rendering"

"$build/penumbra" wait "$id" --server "$url" >/dev/null || fail "the job did not succeed"
curl -sS --noproxy '*' --fail -o "$demo/room.png" "$url$job/image" || fail "cannot fetch the picture"
"$build/penumbra" stats "$id" --server "$url" -o "$demo/stats.json" || fail "no statistics"

# One number of the statistics, which have one key a line.
number() {
    sed -n "s/^ *\"$1\": \\([0-9.e+-]*\\),*\$/\\1/p" "$demo/stats.json" | head -n 1
}
render=$(number render_ms) total=$(number total_ms) threads=$(number threads)
rate=$(number mrays_per_second)
awk -v r="$render" -v t="$total" -v m="$rate" -v n="$threads" 'BEGIN {
    printf "demo: rendered in %.2f s with %d threads, %.2f s from submit to end, ", r / 1e3, n, t / 1e3
    printf "%.0f rays per second\n", m * 1e6 }'
echo "demo: $demo/room.png"
echo "demo: $demo/stats.json"
