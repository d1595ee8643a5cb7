#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon over TLS with tokens: what it serves as usual, and what is special with TLS.
export PEN_TLS=1
here=$(dirname "$0")
. "$here/lib.sh"
scripts=service
[ "${PEN_CASES:-}" != all ] || scripts="service openapi jobs" # a handshake for each request takes its time
for script in $scripts; do
    sh "$here/$script.sh" "$build" >"$work/output" 2>&1
    expect "$script over TLS" "$?" 0
    grep '^not ok' "$work/output"
done

daemon_start
submit "$small"
expect submitted "$status" 202
call "$job?wait=60"
expect rendered "$(body .state)" succeeded
call "$job/image" -H 'Range: bytes=0-7'
expect part-of-the-picture "$status $(wc -c <"$work/body")" "206 8"
head -c 20000000 /dev/zero >"$work/large"
call /v1/jobs -H 'Expect:' -H 'Content-Type: application/json' --data-binary "@$work/large"
expect early-refusal "$status" 413
call /v1/jobs -H 'Expect:' -H 'Transfer-Encoding: chunked' -H 'Content-Type: application/json' \
    --data-binary "@$work/large"
expect early-refusal-of-chunks "$status" 413
events=$(curl -sN -m "$hang" "$url$job/events" | grep -c '^event: ')
expect events-end-with-the-job "$([ "$events" -gt 0 ] && echo yes)" yes
expect plain-http-is-refused "$(curl -s -o /dev/null -w '%{http_code}' "http${url#https}/healthz")" 000
expect tls-1-1-is-refused "$(curl -s -o /dev/null -w '%{http_code}' --tls-max 1.1 "$url/healthz")" 000
expect tls-1-2-is-served "$(curl -s -o /dev/null -w '%{http_code}' --tls-max 1.2 "$url/healthz")" 200

# A killed api process loses nothing.
submit "$small"
for child in $(pgrep -P "$daemon"); do
    [ "$(cat "/proc/$child/comm")" != penumbrad-api ] || kill -KILL "$child"
done
is_there() { call "$job?wait=1" && [ "$(body .state)" = succeeded ]; }
check_within() { within "$@" && ok "$1" || not_ok "$1" "$status"; }
check_within is_there

# A renewed certificate is served without a restart; one that does not fit its key is not.
serial() { echo | openssl s_client -connect "${url#https://}" 2>/dev/null | openssl x509 -noout -serial; }
before=$(serial)
cp "$work/key.pem" "$work/old.pem"
make_certificate
is_renewed() { [ "$(serial)" != "$before" ]; }
check_within is_renewed
after=$(serial)
cp "$work/old.pem" "$work/key.pem"
within grep -q 'the certificate stays as it was: .*does not fit' "$work/log"
expect wrong-key-changes-nothing "$(serial)" "$after"
call /healthz
expect served-with-the-last-one "$status" 200
finish
