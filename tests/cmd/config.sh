#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon's configuration: sources, precedence, what is refused, where the store goes.
. "$(dirname "$0")/lib.sh"
penumbrad=$build/penumbrad
cd "$work" || exit 1

# What is refused: always with exit code 2, what was found, and what is allowed
ends "an unknown option" 2 "$penumbrad" --lisen x
says "is answered with the nearest" stderr "nearest is --listen"
ends "an argument" 2 "$penumbrad" start
ends "a wrong role" 2 "$penumbrad" --role boss
says "is answered with the roles" stderr 'found "boss", allowed is all, api or worker'
ends "a wrong number" 2 "$penumbrad" --threads many
for address in 8080 127.0.0.1 127.0.0.1: 127.0.0.1:70000 example.org:80 '[::1:80' :8080; do
    ends "the address $address" 2 "$penumbrad" --listen "$address"
    says "is answered with what is allowed" stderr "allowed is HOST:PORT"
done
for address in 0.0.0.0:8080 127.0.0.2:80 192.168.1.2:80 '[::]:80' '[2001:db8::1]:80'; do
    ends "the open address $address" 2 timeout 20 "$penumbrad" --listen "$address"
    says "is answered with loopback" stderr "allowed is a loopback address"
done
ends "tokens" 2 "$penumbrad" --tokens tokens.json
says "are known" stderr "--tokens: known, not supported yet"
ends "a wrong environment variable" 2 env PENUMBRA_THREADS=-1 "$penumbrad"
says "is named" stderr "PENUMBRA_THREADS: found"
ends "a wrong address of the environment" 2 env PENUMBRA_LISTEN=nowhere "$penumbrad"
says "is not taken for an option" stderr "penumbrad: listen: found"

# The file
echo '{"threads": "4", "lisen": "x", "log_level": "loud", "listen": 8080, "config": "y"}' >bad.json
ends "a file with errors" 2 "$penumbrad" --config bad.json
says "names the file and the key" stderr "bad.json: "
says "says what a key takes" stderr 'found "4", allowed is an integer from 0 to 1024'
says "names the nearest key" stderr 'nearest is "listen"'
says "lists choices" stderr 'found "loud"'
expect "all errors together" "$(grep -c bad.json stderr)" 5
ends "a file that environment and options override is checked too" 2 \
    env PENUMBRA_THREADS=1 "$penumbrad" --config bad.json --listen 127.0.0.1:0
echo '{"threads": 1, "threads": 2}' >twice.json
ends "a key given twice" 2 "$penumbrad" --config twice.json
echo '[]' >list.json
ends "a file that is no object" 2 "$penumbrad" --config list.json
ends "a file that is not there" 2 "$penumbrad" --config none.json
ends "a file of the environment" 2 env PENUMBRA_CONFIG=bad.json "$penumbrad"

# A store or a socket that cannot be had is said before anything starts
ends "a store that cannot be made" 8 "$penumbrad" --listen 127.0.0.1:0 --store /proc/none/x.db
echo "this is no database, and long enough not to be taken for an empty one" >text.db
ends "a store that is something else" 8 "$penumbrad" --listen 127.0.0.1:0 --store text.db
expect "is left as it is" "$(head -c 19 text.db)" "this is no database"

# Precedence: command line, environment, file, default. The log's form tells which one won.
log_form() { # VARIABLES-AND-COMMAND…: starts, stops, says whether the log was JSON
    rm -f form.log
    : >form.out
    env "$@" --listen 127.0.0.1:0 --store form.db --log-file form.log >form.out 2>&1 &
    daemon=$!
    within 20 grep -q '^listening on' form.out
    daemon_stop
    case $(head -c 1 form.log) in
    '{') echo json ;;
    2) echo text ;;
    *) echo "neither: $(head -c 300 form.log form.out)" ;;
    esac
}
echo '{"log_format": "json", "threads": 1}' >json.json
echo '{"log_format": "text"}' >text.json
expect "the default" "$(log_form "$penumbrad")" text
expect "the file over the default" "$(log_form "$penumbrad" --config json.json)" json
expect "the environment over the file" \
    "$(log_form PENUMBRA_LOG_FORMAT=json "$penumbrad" --config text.json)" json
expect "the command line over the environment" \
    "$(log_form PENUMBRA_LOG_FORMAT=json "$penumbrad" --log-format text --config json.json)" text
expect "an empty variable is none" \
    "$(log_form PENUMBRA_LOG_FORMAT= "$penumbrad" --config json.json)" json
check "a log in JSON is JSON to the last line" sh -c "jq -e .message form.log"

# Where the store goes by default
unset XDG_STATE_HOME
default_store() { # VARIABLES…
    : >form.out
    env "$@" "$penumbrad" --listen 127.0.0.1:0 >form.out 2>&1 &
    daemon=$!
    within 20 grep -q '^listening on' form.out
    daemon_stop
}
default_store XDG_STATE_HOME="$work/state"
check "the state folder" test -s "$work/state/penumbra/penumbra.db"
default_store XDG_STATE_HOME= HOME="$work/home"
check "the home folder" test -s "$work/home/.local/state/penumbra/penumbra.db"
default_store XDG_STATE_HOME=relative HOME="$work/home2"
check "a relative state folder is none" test -s "$work/home2/.local/state/penumbra/penumbra.db"
default_store STATE_DIRECTORY="$work/systemd:$work/other" HOME="$work/home3"
check "systemd's folder" test -s "$work/systemd/penumbra.db"

# The first line
store=$work/first.db
for address in 127.0.0.1:0 localhost:0; do
    : >form.out
    "$penumbrad" --listen $address --store first.db >form.out 2>>log &
    daemon=$!
    within 20 grep -q '^listening on' form.out
    expect "$address is served" \
        "$(curl -s -o body -w '%{http_code}' "$(sed -n '1s/^listening on //p' form.out)/healthz")" 200
    expect "$address keeps its name" "$(sed 's/[0-9]*$//' form.out)" \
        "listening on http://${address%0}"
    ends "a port that is taken" 5 "$penumbrad" --store first.db \
        --listen "$(sed -n '1s#^listening on http://##p' form.out)"
    daemon_stop
    expect "and it is the only line" "$(wc -l <form.out | tr -d ' ')" 1
done

finish
