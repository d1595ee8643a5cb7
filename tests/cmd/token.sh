#!/bin/sh
# SPDX-License-Identifier: MIT
# `penumbrad token`, and the options that a daemon for other machines needs before it starts.
. "$(dirname "$0")/lib.sh"
penumbrad=$build/penumbrad
cd "$work" || exit 1
token() { "$penumbrad" token "$@"; }
lines() { # FILE: the lines that are no comments
    grep -c '^[^#]' "$1"
}

# Adding
exits "a token is added" 0 token add ci --scope submit --tokens tokens
cp stdout ci
prints "a note says that it is shown once" stderr "the only time"
check "it is the only line on standard output" grep -qxE 'pen_[A-Za-z0-9_-]{43}' ci
expect "which is one line" "$(wc -l <ci | tr -d ' ')" 1
expect "only the owner may read the new file" "$(stat -c %a tokens)" 600
exits "another is added, which expires" 0 env PENUMBRA_TOKENS=tokens "$penumbrad" token add lena --scope=admin --expires 30
cp stdout lena
expect "no token is in the file" "$(grep -c -f ci -f lena tokens)" 0
expect "but its hash is" "$(tr -d '\n' <ci | b2sum -l 256 | cut -d ' ' -f 1)" "$(sed -n 's/^ci submit never //p' tokens)"
expect "two tokens differ" "$(cat ci lena | sort -u | wc -l | tr -d ' ')" 2
date -u -d '+29 days 23 hours' +%FT%TZ >from
date -u -d '+30 days' +%FT%TZ >to
expiry=$(awk '$1 == "lena" { print $3 }' tokens)
expect "the expiry is so many days ahead" "$(printf '%s\n' "$(cat from)" "$expiry" "$(cat to)" | sort | sed -n 2p)" "$expiry"

# Listing
echo "old read 2020-01-01T00:00:00Z $(printf '%064d' 1)" >>tokens
exits "tokens are listed" 0 token list --tokens tokens
expect "with name, scope, expiry, and whether they have expired" "$(tr -s ' ' <stdout)" "ci submit never
lena admin $expiry
old read 2020-01-01T00:00:00Z expired"
expect "but without hashes" "$(grep -cE '[0-9a-f]{16}' stdout)" 0

# Removing
exits "a token is removed" 0 token remove ci --tokens tokens
exits "the others stay" 0 token list --tokens tokens
expect "in their order" "$(cut -d ' ' -f 1 stdout | tr '\n' ' ')" "lena old "
exits "a removed token cannot be removed again" 4 token remove ci --tokens tokens
prints "the error names it" stderr 'tokens: found no token "ci"'
expect "the file is still its owner's alone" "$(stat -c %a tokens)" 600

# Wrong inputs change nothing
cp tokens before
exits "a word that is no action" 2 token ad ci --tokens tokens
prints "the error lists them" stderr 'found "ad", allowed is add, list or remove'
exits "no action" 2 token --tokens tokens
exits "no file" 2 token list
prints "the error names the option" stderr "found no --tokens FILE"
exits "no name to add" 2 token add --scope read --tokens tokens
prints "the error says so" stderr "token add: found no NAME"
exits "no name to remove" 2 token remove --tokens tokens
exits "a name to list" 2 token list ci --tokens tokens
exits "two names" 2 token add a b --scope read --tokens tokens
exits "no scope" 2 token add ci --tokens tokens
prints "the error lists scopes" stderr "found no --scope, which is needed: read, submit or admin"
exits "a wrong scope" 2 token add ci --scope all --tokens tokens
prints "the error lists scopes" stderr 'found "all", allowed is read, submit or admin'
exits "a scope for list" 2 token list --scope read --tokens tokens
exits "an expiry for remove" 2 token remove lena --expires 1 --tokens tokens
prints "the error names the option" stderr "found --expires, which only add takes"
for days in 0 -1 36501 soon 1.5; do
    exits "the expiry $days" 2 token add ci --scope read --expires=$days --tokens tokens
    prints "the error shows what is allowed" stderr "found \"$days\", allowed is an integer from 1 to 36500"
done
for wrong in CI 1ci c.i 'c i' '' ci/x n23456789012345678901234567890123; do
    exits "the name <$wrong>" 2 token add "$wrong" --scope read --tokens tokens
    prints "the error shows what is allowed" stderr "found the name \"$wrong\", allowed is a letter from a to z"
done
exits "a name that is taken" 4 token add lena --scope read --tokens tokens
prints "the error names it" stderr 'the token "lena" is there already'
expect "nothing has changed" "$(cat tokens)" "$(cat before)"
expect "no token was printed" "$(cat stdout)" ""
exits "a file that is not there has no tokens to list" 4 token list --tokens none
exits "and none to remove" 4 token remove ci --tokens none
prints "the error names the file" stderr "none: cannot open"
check "and is not made" test ! -e none
exits "a folder that is not there" 8 token add ci --scope read --tokens none/tokens
prints "the error names the file" stderr "none/tokens"
echo "ci read never 5ec7e7" >broken && chmod 600 broken
exits "a broken file is not changed" 3 token add x --scope read --tokens broken
prints "the error names file, line and column" stderr "penumbrad: broken:1:15: wrong hash"
expect "and does not quote the line" "$(grep -c 5ec7e7 stderr)" 0
cp tokens open && chmod 640 open
exits "a file that others may read" 11 token add x --scope read --tokens open
prints "the error names the mode" stderr "open: found the mode 0640, allowed is 0600"
exits "the help" 0 token add --help
prints "shows the usage" stdout "Usage: penumbrad token add|list|remove [NAME] [options]"

# Changes at the same time exclude each other
for i in 1 2 3 4 5 6 7 8 9 10 11 12; do
    token add "t$i" --scope read --tokens many >>printed 2>>log &
done
for i in 1 2 3 4; do
    (token add same --scope read --tokens many >>printed 2>>log && echo $i >>won) &
done
wait
expect "no token is lost" "$(lines many)" 13
expect "all are printed" "$(sort -u printed | wc -l | tr -d ' ')" 13
expect "of the same name one is added" "$(wc -l <won | tr -d ' ')" 1
expect "no temporary file is left" "$(ls many*)" "many
many.lock"
ln -s many link
exits "a link to a file" 0 token remove same --tokens link
expect "stays a link" "$(stat -c %F link)" "symbolic link"
expect "whose file has changed" "$(lines many)" 12
if [ "$(id -u)" -eq 0 ]; then
    chown 12345:12345 many
    exits "root changes a daemon's file" 0 token add root --scope read --tokens many
    expect "which stays the daemon's" "$(stat -c %u:%g:%a many)" 12345:12345:600
else
    skip setuid "whether root leaves a file to its owner"
fi

# What a daemon needs before it starts. It prints the first line only when all is well.
certificate() { # NAME
    openssl req -x509 -newkey ec -pkeyopt ec_paramgen_curve:prime256v1 -nodes -days 2 -subj /CN=localhost \
        -keyout "$1.key" -out "$1.crt" 2>>log
}
certificate one
certificate two
refused() { # NAME TEXT OPTION…
    name=$1
    text=$2
    shift 2
    exits "$name: refused" 2 timeout 20 "$penumbrad" --listen "$address" --store s.db "$@"
    prints "$name: the error says why" stderr "$text"
    expect "$name: nothing listens" "$(cat stdout)" ""
}
for address in 0.0.0.0:0 '[::]:0' 127.0.0.2:0; do
    refused "$address without tokens" "needs --tokens FILE" --plain-http
    refused "$address without TLS" "give --tls-cert FILE and --tls-key FILE, or --trusted-proxy ADDRESS" --tokens tokens
    refused "$address with plain HTTP in the file, but no" "or --plain-http" --tokens tokens --plain-http=false
done
address=127.0.0.1:0
refused "a token file that is not there" "none: cannot open" --tokens none
refused "one that others may read" "open: found the mode 0640" --tokens open
refused "one with a wrong line" "broken:1:15: wrong hash" --tokens broken
refused "one that is a folder" ".: not a regular file" --tokens .
refused "a certificate without key" "found --tls-cert without --tls-key FILE" --tls-cert one.crt
refused "a key without certificate" "found --tls-key without --tls-cert FILE" --tls-key one.key
refused "a certificate that is not there" "none: cannot open" --tls-cert none --tls-key one.key
refused "a key that is not there" "none: cannot open" --tls-cert one.crt --tls-key none
refused "a certificate that is a folder" ".: not a regular file" --tls-cert . --tls-key one.key
refused "a certificate that is none" "one.key: found no certificate" --tls-cert one.key --tls-key one.key
refused "a key that is none" "one.crt: found no private key" --tls-cert one.crt --tls-key one.crt
refused "a key of another certificate" "two.key: this key does not fit the certificate one.crt" \
    --tls-cert one.crt --tls-key two.key
for origin in null '*' example.org https:// https://example.org/ 'https://example.org:' https://example.org:70000 \
    HTTPS://example.org https://Example.org 'https://[::1' 'https://a https://b/c'; do
    refused "the origin $origin" "allowed is SCHEME://HOST[:PORT]" --cors "$origin"
done
expect "no store was made" "$(ls s.db* 2>/dev/null)" ""

started() { grep -q '^listening on' out || ! kill -0 $daemon; }
# start OPTION…: starts a daemon whose first line tells its address, and sets $first.
start() {
    : >out
    [ ! -e daemon.log ] || cat daemon.log >>log
    "$penumbrad" --store s.db --threads 1 "$@" >out 2>daemon.log &
    daemon=$!
    within started
    first=$(cat out)
}
start --listen 0.0.0.0:0 --tokens tokens --plain-http
expect_match "plain HTTP is served where it is allowed" "$first" "listening on http://0.0.0.0:[1-9]*"
check "and the log warns of it" grep -q "travel unencrypted" daemon.log
daemon_stop
start --listen '[::]:0' --tokens tokens --trusted-proxy 127.0.0.1
expect_match "a proxy is served" "$first" "listening on http://\[::\]:[1-9]*"
expect "without a warning" "$(grep -c "travel unencrypted" daemon.log)" 0
daemon_stop
start --listen 127.0.0.1:0 --plain-http
expect "nor is there one on the loopback interface" "$(grep -c "travel unencrypted" daemon.log)" 0
daemon_stop

# The file and the environment reach the api process, and so do several origins
cat >access.json <<END
{"listen": "0.0.0.0:0", "tokens": "$work/tokens", "tls_cert": "one.crt", "tls_key": "one.key",
 "cors": "https://a.example http://b:81"}
END
start --config access.json --cors 'https://[::1]:8443' --cors app://c
expect_match "HTTPS is served" "$first" "listening on https://0.0.0.0:[1-9]*"
expect "without a warning" "$(grep -c "travel unencrypted" daemon.log)" 0
settings() { tr '\0' '\n' <"/proc/$(child "$1")/environ" | grep -e ^PENUMBRA_T[LO] -e ^PENUMBRA_CORS | sort | paste -sd' '; }
# The children have their names, or the daemon has ended.
has_children() { (child api && child work) || ! kill -0 $daemon; }
within has_children
expect_match "the api process has the options of the file" "$(settings api)" \
    "* PENUMBRA_TLS_CERT=one.crt PENUMBRA_TLS_KEY=one.key PENUMBRA_TOKENS=$work/tokens"
expect_match "the command line overrides the file" "$(settings api)" "PENUMBRA_CORS=https://\[::1\]:8443 app://c *"
expect "the worker has none of them" "$(settings work)" ""
expect "no process has them on its command line" \
    "$(cat "/proc/$(child api)/cmdline" "/proc/$(child work)/cmdline" | grep -a -c -e "$work" -e one)" 0
sed 's/one\./two./g' access.json >access.new && mv access.new access.json
kill -HUP $daemon
check "a change of them waits for the next start" within grep -q 'tls-key changes only when' daemon.log
api=$(child api)
kill -KILL "$api"
has_other_api() { [ "$(child api)" != "$api" ] && has_children; }
within has_other_api
expect_match "also for an api process that is started again" "$(settings api)" "* PENUMBRA_TLS_CERT=one.crt *"
daemon_stop
export PENUMBRA_TOKENS=tokens PENUMBRA_TLS_CERT=one.crt PENUMBRA_TLS_KEY=one.key PENUMBRA_CORS="https://a https://b"
start --listen 0.0.0.0:0
within has_children
expect_match "the environment counts too" "$(settings api)" \
    "PENUMBRA_CORS=https://a https://b PENUMBRA_TLS_CERT=one.crt PENUMBRA_TLS_KEY=one.key *"
daemon_stop
export PENUMBRA_PLAIN_HTTP=maybe
address=127.0.0.1:0
refused "a flag in the environment" 'PENUMBRA_PLAIN_HTTP: found "maybe", allowed is true or false'
cat daemon.log >>log
grep -c -f ci -f lena log >shown
expect "no log shows a token" "$(cat shown)" 0
finish
