#!/bin/sh
# SPDX-License-Identifier: MIT
# A store in PostgreSQL, with programs: what a start refuses and advises, that no password is shown, and an
# api with two workers whose database stops and starts again.
if [ -z "${PENUMBRA_TEST_POSTGRES:-}" ]; then
    ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || {
        echo "skipped: postgresql: no server of PostgreSQL"
        exit 77
    }
    exec sh "$(dirname "$0")/../support/postgres.sh" sh "$0" "$@"
fi
. "$(dirname "$0")/../cmd/lib.sh"
cd "$work" || exit 1
folder=$PGHOST
server_bin=${PENUMBRA_TEST_PG_CTL%%/pg_ctl *} # with what runs it as the server's owner
as_owner() { # PROGRAM…: runs it as the server's owner, in a folder that this user may read
    # shellcheck disable=SC2086
    (cd / && ${server_bin%/usr/lib/*} "$@")
}
pg() { # PROGRAM…: one of the server's programs
    as_owner "${server_bin##* }/$@"
}
database() { # start, stop or reload
    (cd / && $PENUMBRA_TEST_PG_CTL -m immediate "$1")
}
workers=
pooler= # process id
stop_all() { # what runs, if the script ends early
    # shellcheck disable=SC2086 # process ids
    [ -z "$workers$pooler" ] || kill $workers $pooler
    [ ! -e "$folder/standby/postmaster.pid" ] || pg pg_ctl -D "$folder/standby" -s -m immediate stop
    clean_up
}
trap stop_all EXIT

url_of() { # DATABASE [USER[:PASSWORD]] [FOLDER]
    echo "postgresql://${2:-$PGUSER}@/$1?host=${3:-$folder}"
}
sql() { # DATABASE STATEMENT…
    base=$1
    shift
    for statement; do
        psql -q -X -v ON_ERROR_STOP=1 -d "$base" -c "$statement"
    done
}
fsync_warning='warn .*the database has fsync or synchronous_commit off' # of the tests' database

# refused NAME URL TEXT…: a worker does not start with this store. It ends with code 8 and prints one line
# with each text.
refused() {
    what=$1
    exits "$what: no worker starts" 8 env PENUMBRA_STORE="$2" "$build/penumbrad" --role worker
    expect "$what: the message is one line" "$(grep -cv "$fsync_warning" stderr)" 1
    expect "$what: nothing is on standard output" "$(wc -c <stdout)" 0
    shift 2
    for text; do
        prints "$what: the message says \"$text\"" stderr "$text"
    done
}
# works NAME URL: a worker starts with this store and ends when it is idle.
works() {
    exits "$1" 0 env PENUMBRA_STORE="$2" "$build/penumbrad" --role worker --until-idle 1 --threads 1 --log-file works.log
}

# The connection
refused "an unknown host" postgresql://nowhere.invalid/test "nowhere.invalid" "check the host's name"
refused "no server" "$(url_of test '' /nonexistent)" "check the host and the port"
refused "an unknown database" "$(url_of nothing)" '"nothing" does not exist' "createdb -E UTF8"
refused "an unknown user" "$(url_of test nobody)" '"nobody" does not exist' "createuser"

# Passwords
sql test "CREATE USER guarded PASSWORD 'hush-hush'"
createdb -T template0 -E UTF8 -O guarded guarded
{
    echo "local all guarded scram-sha-256"
    cat "$PENUMBRA_TEST_POSTGRES_DATA/pg_hba.conf"
} >hba
cat hba >"$PENUMBRA_TEST_POSTGRES_DATA/pg_hba.conf"
database reload
refused "no password" "$(url_of guarded guarded)" "no password supplied" ".pgpass"
refused "a wrong password" "$(url_of guarded guarded:hush-hash)" "password authentication failed" ".pgpass"
exits "a password on the command line is refused" 2 \
    "$build/penumbrad" --role worker --store "$(url_of guarded guarded:hush-hush)"
prints "and the message says where it belongs" stderr ".pgpass"
cat stdout stderr >told
exits "so is one among the parameters" 2 \
    "$build/penumbrad" --role worker --store "$(url_of guarded guarded)&password=hush-hush"
cat stdout stderr >>told
refused "an unknown host and a password" postgresql://guarded:hush-hush@nowhere.invalid/guarded "check the host's name"
cat stdout stderr >>told
works "the right password works" "$(url_of guarded guarded:hush-hush)"
check "a server with fsync off: the log warns" grep -q "$fsync_warning" works.log
printf '%s\n' "*:*:*:*:hush-hush" >pgpass
chmod 600 pgpass
export PGPASSFILE="$work/pgpass"
works "so does a file of passwords" "$(url_of guarded guarded)"
unset PGPASSFILE
cat stdout stderr ./*.log >>told
expect "no password is shown" "$(grep -c hush told)" 0

# The database
sql guarded "UPDATE meta SET value = '999' WHERE name = 'schema_version'"
refused "a store of a later version" "$(url_of guarded guarded:hush-hush)" "version 999" "this build reads version"
createdb -T template0 -E UTF8 other
sql other "CREATE TABLE meta (key TEXT)"
refused "tables of another program" "$(url_of other)" "another program" "createdb -E UTF8"
sql test "CREATE USER plain" "REVOKE CREATE ON SCHEMA public FROM PUBLIC"
refused "no right to make tables" "$(url_of test plain)" "permission denied" "GRANT CREATE ON SCHEMA public"
createdb -T template0 -E SQL_ASCII --locale=C ascii
refused "another encoding" "$(url_of ascii)" "SQL_ASCII" "createdb -E UTF8 -T template0"

# A standby
pg pg_basebackup -h "$folder" -U "$PGUSER" -D "$folder/standby" -R -N -c fast -X stream
pg pg_ctl -D "$folder/standby" -w -s -l "$folder/standby.log" -o "-c unix_socket_directories=$folder/standby" start
refused "a standby" "$(url_of test '' "$folder/standby")" "standby" "target_session_attrs=read-write"
works "of a standby and its primary, the primary is found" \
    "postgresql://$PGUSER@/test?host=$folder/standby,$folder&target_session_attrs=read-write"
pg pg_ctl -D "$folder/standby" -w -s -m immediate stop

# A pooler
pooler_start() { # MODE
    cat >"$folder/pooler.ini" <<END
[databases]
test = host=$folder
[pgbouncer]
pool_mode = $1
listen_addr =
unix_socket_dir = $folder
listen_port = 6432
auth_type = trust
auth_file = $folder/users
logfile = $folder/pooler.log
pidfile = $folder/pooler.pid
END
    echo "\"$PGUSER\" \"\"" >"$folder/users"
    as_owner pgbouncer -q -d "$folder/pooler.ini"
    within test -S "$folder/.s.PGSQL.6432"
    within test -s "$folder/pooler.pid"
    pooler=$(cat "$folder/pooler.pid")
}
pooler_stop() {
    kill -INT "$pooler"
    within gone "$pooler"
    rm -f "$folder/.s.PGSQL.6432" "$folder/pooler.pid"
    pooler=
}
if command -v pgbouncer >/dev/null; then
    pooler_start transaction
    refused "a pooler in transaction mode" "$(url_of test)&port=6432" "pooler in transaction mode" "session mode"
    pooler_stop
    pooler_start session
    works "a pooler in session mode works" "$(url_of test)&port=6432"
    pooler_stop
else
    skip command-pgbouncer "the store behind a pooler"
fi

# Commands about files
exits "penumbrad backup does not copy a database" 3 "$build/penumbrad" backup copy.db --store "$PENUMBRA_TEST_POSTGRES"
prints "and names the command that does" stderr pg_basebackup
exits "penumbrad check does not look at a database" 3 "$build/penumbrad" check --store "$PENUMBRA_TEST_POSTGRES"
prints "and names the command that does" stderr pg_amcheck

# An api and two workers
store=$PENUMBRA_TEST_POSTGRES
daemon_start --role api
export PENUMBRA_URL="$url"
for name in 1 2; do
    "$build/penumbrad" --role worker --store "$store" --threads 1 2>>log &
    workers="$workers $!"
done
set -- builtin:room --set width=64 --set height=48
exits "a job succeeds" 0 "$penumbra" submit "$@" --wait -q -o farm.png
"$penumbra" render "$@" -q -o local.png
check "its picture has the same bytes as that of penumbra render" cmp farm.png local.png

# The database fails while a job runs
answers() { # PATH STATUS
    call "$1"
    [ "$status" = "$2" ]
}
set -- builtin:room --set width=300 --set height=420
id=$("$penumbra" submit "$@")
database stop
check "without its database the api is not ready" within answers /readyz 503
call /healthz
expect "but it answers" "$status" 200
submit "$small"
expect "and accepts no job" "$status" 503
database start
begun=$(now_ms)
accepts() {
    submit "${small%\}}, \"priority\": 1}"
    [ "$status" = 202 ]
}
check "after the database has started again, a job is accepted" within accepts
exits "and succeeds" 0 "$penumbra" wait "${job##*/}" -q
took=$(($(now_ms) - begun))
echo "# a job has succeeded $took ms after the start of the database"
timed "within 10 s" "$took" 10000
check "the api is ready" within answers /readyz 200
exits "the job that ran meanwhile succeeds" 0 "$penumbra" wait "$id" -q
"$penumbra" fetch "$id" -o farm.png
"$penumbra" render "$@" -q -o local.png
check "its picture has the same bytes" cmp farm.png local.png
expect "and its batches were held while the database was away" "$(grep -c 'leases ran out' log)" 0
# shellcheck disable=SC2086 # process ids
kill $workers
for one in $workers; do
    wait "$one"
    codes="${codes:-}$? "
done
workers=
expect "the workers end well" "$codes" "0 0 "
finish
