#!/bin/sh
# SPDX-License-Identifier: MIT
# A daemon with TLS, and clients that stall in their handshakes. They must cost no processor time, and other
# clients must be served. `make load` runs it.
. "$(dirname "$0")/../e2e/lib.sh"
. "$(dirname "$0")/lib.sh"
command -v openssl >/dev/null || {
    skip command-openssl 'it makes the certificate'
    exit 77
}
openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=localhost \
    -keyout "$work/key.pem" -out "$work/cert.pem" 2>/dev/null
chmod 600 "$work/key.pem"
token=$("$build/penumbrad" token add load --scope submit --tokens "$work/tokens")
daemon_start --tokens "$work/tokens" --tls-cert "$work/cert.pem" --tls-key "$work/key.pem"
api=$(pgrep -P "$daemon" -x penumbrad-api)

"$build/tests/load/stall" "${url##*:}" 100 10 "$api" >"$work/values" &
stalled=$!
sleep 1
set -- -k -H "Authorization: Bearer $token"
submit "$small" "$@"
begun=$(now_ms)
call "$job?wait=60" "$@"
expect poll-beside-stalled-handshakes "$status $(body .state)" '200 succeeded'
timed poll-beside-stalled-handshakes-in-time "$(($(now_ms) - begun))" 2000
wait $stalled
cat "$work/values"
expect handshakes-begun "$(value made)" 100
below processor-percent 2
finish
