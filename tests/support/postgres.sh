#!/bin/sh
# SPDX-License-Identifier: MIT
# Starts its own PostgreSQL server in a new folder, on a Unix socket alone, runs a command, and stops the
# server. For root the server belongs to the user postgres.
#   tests/support/postgres.sh COMMAND [ARGUMENT…]
# The command's environment has PENUMBRA_TEST_POSTGRES, the URL of an empty database; PGHOST and PGUSER for
# psql; PENUMBRA_TEST_POSTGRES_DATA, the server's folder; and PENUMBRA_TEST_PG_CTL, a command for it. With
# PENUMBRA_TEST_FSYNC=on the server waits for the disk.
set -eu
bin=$(ls -d /usr/lib/postgresql/*/bin 2>/dev/null | sort -V | tail -1)
[ -n "$bin" ] || { echo "postgres.sh: no PostgreSQL: run sh deploy/install-deps.sh --all" >&2; exit 77; }
folder=$(mktemp -d /tmp/penumbra-postgres-XXXXXX)
as_owner=
if [ "$(id -u)" -eq 0 ]; then
    chown postgres "$folder"
    as_owner="runuser -u postgres --"
fi
PENUMBRA_TEST_POSTGRES_DATA=$folder/data
PENUMBRA_TEST_PG_CTL="$as_owner $bin/pg_ctl -D $folder/data -w -s -l $folder/log"
PGHOST=$folder
PGUSER=penumbra
PENUMBRA_TEST_POSTGRES="postgresql://penumbra@/test?host=$folder"
export PENUMBRA_TEST_POSTGRES_DATA PENUMBRA_TEST_PG_CTL PGHOST PGUSER PENUMBRA_TEST_POSTGRES
stop() {
    cd /
    $PENUMBRA_TEST_PG_CTL -m immediate stop >/dev/null 2>&1 || :
    rm -rf "$folder"
}
trap stop EXIT
trap 'exit 130' INT TERM
(cd "$folder" && $as_owner "$bin/initdb" -D data -U penumbra -A trust -E UTF8 --locale=C.UTF-8 -N >/dev/null)
cat >>"$folder/data/postgresql.conf" <<EOF
listen_addresses = ''
unix_socket_directories = '$folder'
fsync = ${PENUMBRA_TEST_FSYNC:-off}
max_connections = 200
shared_buffers = 128MB
EOF
(cd "$folder" && $PENUMBRA_TEST_PG_CTL start >/dev/null)
createdb -T template0 -E UTF8 test
"$@"
