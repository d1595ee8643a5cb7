#!/bin/sh
# SPDX-License-Identifier: MIT
# Runs the lines of the README's section "From another machine": over TLS, with the certificate that
# they make, with this machine in place of both, and a free port.
. "$(dirname "$0")/lib.sh"
if ! command -v openssl >/dev/null; then
    skip command-openssl "the README's lines about another machine"
    exit 77
fi
cd "$work" || exit 1
lines() { # NUMBER: prints the n-th block of lines of that section
    awk -v n="$1" '/^<!-- remote:/ { found = 1 } found && /^```sh$/ && ++block == n { on = 1; next }
        on && /^```$/ { exit } on' "$root/README.md"
}
PATH=$build:$PATH
lines 1 | sed 's|^build/||' >daemon.sh
lines 2 | sed 's|^build/||' >client.sh
expect "both machines have lines" "$(grep -c '^penumbrad .*--listen 0.0.0.0:8080' daemon.sh) \
$(grep -c '^export PENUMBRA_URL=https://render.example:8080' client.sh)" "1 1"

# The daemon's machine. Its last line starts the daemon, which goes on.
sed -e 's/render\.example/localhost/g' -e "s|0\.0\.0\.0:8080|127.0.0.1:0 --store $store --threads 2|" \
    -e 's/^penumbrad --listen.*/& >out 2>log \&\ndaemon=$!/' daemon.sh >daemon-here.sh
. ./daemon-here.sh >daemon.out 2>daemon.err
token=$(grep -o 'pen_[A-Za-z0-9_-]*' daemon.out | head -n 1)
expect_match "print a token" "$token" "pen_????????????????????*"
listens() { grep -q '^listening on https://' out || ! kill -0 "$daemon"; }
within listens
port=$(sed -n 's|^listening on https://.*:\([0-9]*\)$|\1|p' out)
if [ -z "$port" ]; then
    not_ok "the daemon listens" "$(cat daemon.err log)"
    finish
fi

# The other machine
sed -e "s|render\.example:8080|localhost:$port|" -e "s|pen_…|$token|" -e "s|scenes/|$root/scenes/|" \
    client.sh >client-here.sh
sh -eu client-here.sh >client.out 2>client.err
expect "the lines for the other machine" "$?" 0
expect "no warning and no error" "$(grep -c -i -e warning -e error client.err)" 0
expect "a picture" "$(head -c 8 room.png | od -An -tx1 | tr -d ' ')" 89504e470d0a1a0a
expect "a report" "$(head -n 1 report.html)" "<!doctype html>"
expect "which has the daemon's host" "$(grep -c "$(uname -n): " report.html)" 1
expect "the list of curl" "$(tail -n 1 client.out | jq '.jobs | length')" 2
expect "the token is in no output and no log" "$(cat client.out client.err out log | grep -c "$token")" 0

# Without it, or without the authority
export PENUMBRA_URL="https://localhost:$port"
exits "without a token" 11 "$penumbra" list --ca cert.pem
prints "the error says where tokens come from" stderr "no token was sent: it comes from --token, PENUMBRA_TOKEN or "
exits "without the authority" 5 "$penumbra" list --token "$token"
prints "the error says what to give" stderr "--ca FILE"
exits "http" 5 "$penumbra" list --retry 0 --server "http://localhost:$port"
prints "the error says what to give" stderr "give --server https://"
finish
