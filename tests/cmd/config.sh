#!/bin/sh
# SPDX-License-Identifier: MIT
# The daemon's configuration: its sources, their precedence, wrong values, the default store.
. "$(dirname "$0")/lib.sh"
penumbrad=$build/penumbrad
cd "$work" || exit 1

# Wrong values end the daemon with exit code 2 and a message of what was found and what is allowed
exits "an unknown option" 2 "$penumbrad" --lisen x
prints "the error names the nearest option" stderr "nearest is --listen"
exits "an argument, of which there are none" 2 "$penumbrad" start
exits "a wrong role" 2 "$penumbrad" --role boss
prints "the error lists the roles" stderr 'found "boss", allowed is all, api or worker'
exits "a wrong number" 2 "$penumbrad" --threads many
for address in 8080 127.0.0.1 127.0.0.1: 127.0.0.1:70000 example.org:80 '[::1:80' :8080; do
    exits "the address $address" 2 "$penumbrad" --listen "$address"
    prints "the error shows the form HOST:PORT" stderr "allowed is HOST:PORT"
done
for address in 0.0.0.0:8080 127.0.0.2:80 192.168.1.2:80 '[::]:80' '[2001:db8::1]:80'; do
    exits "the address $address, which other machines reach, without tokens" 2 timeout 20 "$penumbrad" --listen "$address"
    prints "the error names the option" stderr "needs --tokens FILE"
done
for address in localhost 127.0.0.1:80 10.0.0.0/8 ''; do
    exits "the proxy <$address>" 2 "$penumbrad" --trusted-proxy "$address"
    prints "the error shows what is allowed" stderr "a numeric IPv4 or IPv6 address is allowed"
done
exits "a wrong proxy in the environment" 2 env PENUMBRA_TRUSTED_PROXY=proxy "$penumbrad"
echo '{"trusted_proxy": "proxy"}' >proxy.json
exits "a wrong proxy in the file" 2 "$penumbrad" --config proxy.json
for value in '"yes"' 1 '"true"'; do
    echo "{\"plain_http\": $value}" >flag.json
    exits "a flag that is $value in the file" 2 "$penumbrad" --config flag.json
    prints "the error shows what is allowed" stderr "found $value, allowed is true or false"
done
exits "a wrong environment variable" 2 env PENUMBRA_THREADS=-1 "$penumbrad"
prints "the error names the variable" stderr "PENUMBRA_THREADS: found"
exits "a wrong address in the environment" 2 env PENUMBRA_LISTEN=nowhere "$penumbrad"
prints "the error names no option" stderr "penumbrad: listen: found"

# The file
echo '{"threads": "4", "lisen": "x", "log_level": "loud", "listen": 8080, "config": "y"}' >bad.json
exits "a file with errors" 2 "$penumbrad" --config bad.json
prints "names the file and the key" stderr "bad.json: "
prints "says which values a key takes" stderr 'found "4", allowed is an integer from 0 to 1024'
prints "names the nearest key" stderr 'nearest is "listen"'
prints "lists choices" stderr 'found "loud"'
expect "all errors together" "$(grep -c bad.json stderr)" 5
exits "a file that environment and options override is checked too" 2 \
    env PENUMBRA_THREADS=1 "$penumbrad" --config bad.json --listen 127.0.0.1:0
echo '{"threads": 1, "threads": 2}' >twice.json
exits "a key given twice" 2 "$penumbrad" --config twice.json
echo '[]' >list.json
exits "a file that is no object" 2 "$penumbrad" --config list.json
exits "a file that is not there" 2 "$penumbrad" --config none.json
exits "a wrong file named by the environment" 2 env PENUMBRA_CONFIG=bad.json "$penumbrad"

# A store that cannot be opened ends the daemon before any process starts
exits "a store in a folder that cannot be created" 8 "$penumbrad" --listen 127.0.0.1:0 --store /proc/none/x.db
echo "this is no database, and long enough not to be taken for an empty one" >text.db
exits "a store that is no database" 8 "$penumbrad" --listen 127.0.0.1:0 --store text.db
expect "the file is not changed" "$(head -c 19 text.db)" "this is no database"

# Precedence: command line, environment, file, default. The log's format shows which one counted.
log_format() { # VARIABLES-AND-COMMAND…: runs a daemon, and prints whether its log is JSON or text
    rm -f form.log
    : >form.out
    env "$@" --listen 127.0.0.1:0 --store form.db --log-file form.log >form.out 2>&1 &
    daemon=$!
    within grep -q '^listening on' form.out
    daemon_stop
    case $(head -c 1 form.log) in
    '{') echo json ;;
    2) echo text ;;
    *) echo "neither: $(head -c 300 form.log form.out)" ;;
    esac
}
echo '{"log_format": "json", "threads": 1}' >json.json
echo '{"log_format": "text"}' >text.json
expect "the default is text" "$(log_format "$penumbrad")" text
expect "the file overrides the default" "$(log_format "$penumbrad" --config json.json)" json
expect "the environment overrides the file" \
    "$(log_format PENUMBRA_LOG_FORMAT=json "$penumbrad" --config text.json)" json
expect "the command line overrides the environment" \
    "$(log_format PENUMBRA_LOG_FORMAT=json "$penumbrad" --log-format text --config json.json)" text
expect "an empty variable counts as absent" \
    "$(log_format PENUMBRA_LOG_FORMAT= "$penumbrad" --config json.json)" json
check "every line of a log in JSON is JSON" sh -c "jq -e .message form.log"

# The default store
unset XDG_STATE_HOME
default_store() { # VARIABLES…
    : >form.out
    env "$@" "$penumbrad" --listen 127.0.0.1:0 >form.out 2>&1 &
    daemon=$!
    within grep -q '^listening on' form.out
    daemon_stop
}
default_store XDG_STATE_HOME="$work/state"
check "the store is in \$XDG_STATE_HOME" test -s "$work/state/penumbra/penumbra.db"
default_store XDG_STATE_HOME= HOME="$work/home"
check "without \$XDG_STATE_HOME the store is in the home folder" test -s "$work/home/.local/state/penumbra/penumbra.db"
default_store XDG_STATE_HOME=relative HOME="$work/home2"
check "a relative \$XDG_STATE_HOME is ignored" test -s "$work/home2/.local/state/penumbra/penumbra.db"
default_store STATE_DIRECTORY="$work/systemd:$work/other" HOME="$work/home3"
check "the store is in the first of systemd's state folders" test -s "$work/systemd/penumbra.db"

# The first line
store=$work/first.db
for address in 127.0.0.1:0 localhost:0; do
    : >form.out
    "$penumbrad" --listen $address --store first.db >form.out 2>>log &
    daemon=$!
    within grep -q '^listening on' form.out
    expect "$address is served" \
        "$(curl -s -o body -w '%{http_code}' "$(sed -n '1s/^listening on //p' form.out)/healthz")" 200
    expect "the first line has the address as given: $address" "$(sed 's/[0-9]*$//' form.out)" \
        "listening on http://${address%0}"
    listening=$(sed -n '1s#^listening on http://##p' form.out)
    exits "a port that is in use" 5 "$penumbrad" --store other.db --listen "$listening"
    prints "the error names address and port" stderr "cannot listen on $listening: Address already in use"
    prints "and a way out" stderr "another port with --listen"
    daemon_stop
    expect "standard output has no other line" "$(wc -l <form.out | tr -d ' ')" 1
done

finish
