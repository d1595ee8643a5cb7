#!/bin/sh
# SPDX-License-Identifier: MIT
# deploy/nginx.conf, with ports and a certificate of this script, before a backend that records requests and
# before a daemon. `make front` runs it; it takes a minute. For Caddy, only its file is checked.
. "$(dirname "$0")/../e2e/lib.sh"
deploy=$(dirname "$0")/../../deploy
for command in nginx openssl; do
    command -v "$command" >/dev/null || {
        skip "command-$command" 'it is the front, or makes its certificate'
        exit 77
    }
done
front= # process id
trap 'front_stop; clean_up' EXIT

openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=localhost \
    -addext subjectAltName=DNS:localhost -keyout "$work/key.pem" -out "$work/cert.pem" 2>/dev/null

front_stop() {
    [ -z "$front" ] || kill "$front" 2>/dev/null
    [ -z "$front" ] || wait "$front"
    front=
}

# Starts nginx before a backend. Sets $plain, a port without TLS for raw bytes, and $url, which has TLS.
front_start() { # PORT of the backend
    for _ in 1 2 3 4 5; do
        plain=$(shuf -i 20000-32000 -n 1)
        sed -e "s|listen 443 ssl;|listen 127.0.0.1:$plain; listen 127.0.0.1:$((plain + 1)) ssl;|" \
            -e '/listen \[::\]/d' -e "s|127.0.0.1:8080;|127.0.0.1:$1;|" -e "s|/etc/penumbra/tls|$work|" \
            "$deploy/nginx.conf" >"$work/front.conf"
        {
            [ "$(id -u)" -ne 0 ] || echo 'user root;'
            echo "daemon off; pid $work/nginx.pid; events { worker_connections 4096; }"
            echo "http { access_log off; client_body_temp_path $work/bodies; proxy_temp_path $work/answers;"
            echo "fastcgi_temp_path $work/f; uwsgi_temp_path $work/u; scgi_temp_path $work/s;"
            echo "include $work/front.conf; }"
        } >"$work/nginx.conf"
        nginx -p "$work" -e "$work/nginx.log" -c "$work/nginx.conf" &
        front=$!
        url=https://localhost:$((plain + 1))
        for _ in $(seq 100); do
            [ "$(get / -o /dev/null -w '%{http_code}')" = 000 ] || return 0
            kill -0 "$front" 2>/dev/null || break
            sleep 0.1
        done
        front_stop # a port was taken
    done
    not_ok nginx-starts "$(cat "$work/nginx.log")"
    finish
}

get() { # PATH [CURL-ARGUMENT…]
    path=$1
    shift
    curl -s -m "$hang" --cacert "$work/cert.pem" "$@" "$url$path"
}

# What reaches a backend.
"$build/tests/front/record" >"$work/requests" &
recorder=$!
within grep -q '^port ' "$work/requests"
front_start "$(sed -n 's/^port //p' "$work/requests")"
"$build/tests/load/strict" "$plain" front >"$work/table"
expect malformed-heads-are-refused "$?" 0
cat "$work/table"
get /v1/jobs -o /dev/null -H 'X-Forwarded-For: 9.9.9.9' -H 'X-Forwarded-Host: other' -H 'Authorization: Bearer pen_a'
kill "$recorder"
front_stop
sed -i '/^port /d' "$work/requests"
expect backend-sees-plain-requests "$(grep -v '^plain' "$work/requests" | head -n 3)" ''
# Of each case, at most the request before it, its own and the request behind it.
expect backend-sees-no-other-requests \
    "$(cut -f 2 "$work/requests" | grep -vE '^(GET /healthz|GET /|POST /v1/validate|GET /v1/jobs) HTTP/1.1\\r' | head -n 3)" ''
expect backend-sees-good-requests "$([ "$(wc -l <"$work/requests")" -gt 28 ] && echo yes)" yes
last=$(tail -n 1 "$work/requests")
expect_match authorization-passes "$last" '*Authorization: Bearer pen_a\\r*'
expect_match forwarded-for-the-peer "$last" '*X-Forwarded-For: 127.0.0.1\\r*'
expect_match forwarded-host "$last" "*X-Forwarded-Host: localhost:$((plain + 1))\\\\r*"
expect nothing-forged-passes "$(printf '%s' "$last" | grep -cE '9\.9\.9\.9|other')" 0

# Before a daemon.
set -- --cacert "$work/cert.pem"
daemon_start --trusted-proxy 127.0.0.1
front_start "${url##*:}"
submit "$small" "$@"
call "$job?wait=60" "$@"
expect poll "$status $(body .state)" '200 succeeded'
picture=$job/image?format=pfm
submit "$long" "$@"
begun=$(now_ms)
get "$job/events" -N >"$work/events" &
stream=$!
within grep -q '^event: ' "$work/events"
expect first-event-at-once "$([ $(($(now_ms) - begun)) -lt 1000 ] && echo yes)" yes
call "$job/cancel" "$@" -X POST
wait $stream
expect stream-ends "$? $(sed -n 's/^data: //p' "$work/events" | tail -n 1 | jq -r .state)" '0 cancelled'

call "$picture" "$@" -r 0-99
expect range "$status $(header content-range) $(wc -c <"$work/body")" "206 bytes 0-99/36878 100"
etag=$(header etag)
call "$picture" "$@" -H "If-None-Match: $etag"
expect etag "$status" 304
call /openapi.yaml "$@" -H 'Accept-Encoding: gzip'
expect gzip-answer "$status $(header content-encoding) $(gzip -dc "$work/body" | head -c 8)" '200 gzip openapi:'
echo "$small" | gzip >"$work/small.gz"
call /v1/jobs "$@" -H 'Content-Type: application/json' -H 'Content-Encoding: gzip' --data-binary "@$work/small.gz"
expect gzip-body "$status" 202

# A body that is too long is refused early, and the client receives that.
"$build/tests/load/early" "$plain"
expect early-413 "$?" 0
truncate -s 20M "$work/large"
call /v1/jobs "$@" -H Expect: --data-binary "@$work/large"
expect early-413-over-tls "$status" 413
call /v1/jobs "$@" -H Expect: -T "$work/large" -X POST -H 'Transfer-Encoding: chunked'
expect early-413-of-chunks-over-tls "$status" 413

# A quiet stream and a poll of a minute are not cut: without a worker, a job waits.
front_stop
daemon_stop
daemon_start --role api --trusted-proxy 127.0.0.1
front_start "${url##*:}"
submit "$small" "$@"
get "$job/events" -N -m 45 >"$work/events" &
stream=$!
get "$job?wait=60" -o "$work/poll" -w '%{http_code} %{time_total}' >"$work/polled" &
poll=$!
wait $stream
expect quiet-stream-is-kept "$? $(grep -c '^:' "$work/events")" '28 4' # curl's time was over, after four heartbeats
wait $poll
expect_match poll-of-a-minute "$(cat "$work/polled")" '200 6[0-5].*'

# Limits of one client.
get '/healthz#[1-400]' -o /dev/null -w '%{http_code}\n' >"$work/codes"
expect some-served "$([ "$(grep -c 200 "$work/codes")" -ge 200 ] && echo yes)" yes
expect too-many-refused "$(grep -vcE '200|429' "$work/codes") $([ "$(grep -c 429 "$work/codes")" -gt 0 ] && echo yes)" '0 yes'
sleep 5 # the rate's budget comes back
get "$job/events#[1-120]" -m 3 -o /dev/null -w '%{http_code}\n' -Z --parallel-immediate --parallel-max 120 >"$work/codes" 2>/dev/null
expect waiting-at-a-time "$(grep -c 429 "$work/codes")" 20

if command -v caddy >/dev/null; then
    HOME=$work PENUMBRA_CERT=$work/cert.pem PENUMBRA_KEY=$work/key.pem \
        caddy validate --adapter caddyfile --config "$deploy/Caddyfile" >"$work/caddy" 2>&1
    expect caddy-accepts-its-file "$? $(tail -n 1 "$work/caddy")" '0 Valid configuration'
else
    skip command-caddy 'only Caddy can check deploy/Caddyfile'
fi
front_stop
finish
