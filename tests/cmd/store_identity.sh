#!/bin/sh
# SPDX-License-Identifier: MIT
# A store that is moved away, locked or in use under a running daemon: it is never replaced by an empty
# one, and the error says what is the matter.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1

# One of the two processes alone makes no store
exits "a worker alone does not start without a store" 4 "$build/penumbrad" --role worker --store new/typo.db
prints "and says why" stderr "there is no store new/typo.db"
exits "nor does an api alone" 4 "$build/penumbrad" --role api --listen 127.0.0.1:0 --store new/typo.db
check "and no folder is made" test ! -e new

daemon_start
export PENUMBRA_URL="$url"
for n in 1 2 3; do
    submit "$small"
    expect "a job is accepted" "$status" 202
done
exits "the jobs succeed" 0 "$penumbra" wait $("$penumbra" list --json | jq -r '.jobs[].id')

# A second daemon
exits "a second daemon on the same store does not start" 5 "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
prints "and says why" stderr "another penumbrad uses this store"
ln -s "$store" link.db
exits "nor one by a link to it" 5 "$build/penumbrad" --listen 127.0.0.1:0 --store link.db
rm "$store-wake"
exits "nor one after the file ending in -wake was removed" 5 "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
call /readyz
expect "the first one is not disturbed" "$status" 200

# The store is moved away, and each child dies
mv "$store" "$store.away"
submit "$small"
expect_problem "a submit into a store that was moved away is refused" 503
# The process that writes first finds it moved. Others look for it again, or say what that one found.
case $(body .detail) in
*'was moved or removed while it was in use'* | *'is gone, and no new one is made'* | *'(No such file or directory)'*)
    ok "and the refusal says why"
    ;;
*) not_ok "and the refusal says why" "$(body .detail)" ;;
esac
kill -KILL "$(child api)"
gone_away() {
    call /readyz
    [ "$status" = 503 ] && body .detail | grep -q 'the store .* is gone, and no new one is made'
}
check "the api that takes its place reports the reason" within gone_away
slowly() {
    while printf x; do sleep 0.1; done
}
slowly | curl -s -o /dev/null "telnet://${url#http://}" &
slow=$!
sleep 0.3
answered() { curl -s "$url/readyz" | jq -r .detail | grep -q 'is gone'; }
check "a client that sends a byte at a time does not hold up others" within answered
kill $slow 2>/dev/null
kill -KILL "$(child work)" 2>/dev/null
sleep 1
check "no new store was made" test ! -e "$store"
check "the log has the reason" grep -q 'is gone, and no new one is made in its place' log
mv "$store.away" "$store"
is_ready() { [ "$(curl -s -m 5 -o ready.json -w '%{http_code}' "$url/readyz")" = 200 ]; }
check "the daemon is ready once the store is back" within is_ready
submit "$small"
expect "jobs are accepted again" "$status" 202
exits "the jobs succeed" 0 "$penumbra" wait $("$penumbra" list --json | jq -r '.jobs[].id')
expect "no job was lost" "$("$penumbra" list --json | jq '.jobs | length')" 4

# A daemon by a link uses the files beside the store, and a link that changes leads nobody elsewhere
daemon_stop
cp "$store" other.db
first=$store store=link.db
daemon_start
check "nothing is made beside the link" test ! -e link.db-wal -a ! -e link.db-wake
ln -sf other.db link.db
kill -KILL "$(child api)"
check "a new api process opens the same store" within is_ready
export PENUMBRA_URL="$url"
exits "a job is rendered after that" 0 "$penumbra" submit builtin:spheres --set width=20 --set height=20 --wait -q
daemon_stop
store=$first
daemon_start
expect "and is in the store" "$(PENUMBRA_URL=$url "$penumbra" list --json | jq '.jobs | length')" 5

# A daemon that was stopped leaves a store that needs no other file
daemon_stop
mv "$store" "$store.away"
exits "a daemon makes no new store where one was" 8 "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
prints "and says why" stderr "is missing, but its file ending in -wake is there"
cp "$store.away" copy.db
mv "$store.away" "$store"
first=$store store=$work/copy.db
daemon_start
PENUMBRA_URL=$url "$penumbra" list --json >list.json
expect "a copy of the stopped store's file alone is complete" "$(jq '.jobs | length' list.json)" 5

# The log of a killed daemon is removed
children="$(child api) $(child work)"
daemon_stop KILL
# shellcheck disable=SC2086
within gone $children
mv "$store-wal" "$store.wal"
exits "a store whose log is missing is refused" 8 "$build/penumbrad" --listen 127.0.0.1:0 --store "$store"
prints "and the message says so" stderr "the log of the store's last changes, is missing"
mv "$store.wal" "$store-wal"

# Someone holds the lock
held() { ! flock -n "$first-wake" true; }
flock --no-fork "$first-wake" sleep $((2 * hang)) &
holder=$!
within held
exits "a held lock is reported" 5 timeout "$hang" "$build/penumbrad" --listen 127.0.0.1:0 --store "$first"
prints "with the process that holds it" stderr "process $holder holds the lock"
kill "$holder"
finish
