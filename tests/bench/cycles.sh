#!/bin/sh
# SPDX-License-Identifier: MIT
# Batches a second that a store in PostgreSQL takes, beside transactions of pgbench. Such a transaction
# updates a row and inserts 64 KiB. Both run in turns: tests/bench/cycles.sh BUILD [RUNS [SECONDS
# [CONNECTIONS]]]. The server waits for the disk.
set -eu
build=$1 runs=${2:-3} seconds=${3:-10} connections=${4:-16}
if [ -z "${PENUMBRA_TEST_POSTGRES:-}" ]; then
    PENUMBRA_TEST_FSYNC=on exec sh "$(dirname "$0")/../support/postgres.sh" sh "$0" "$@"
fi
script=$(mktemp)
trap 'rm -f "$script"' EXIT
cat >"$script" <<'EOF'
\set id random(1, 10000)
BEGIN;
UPDATE plain SET n = n + 1 WHERE id = :id;
INSERT INTO value (data) SELECT data FROM sample;
END;
EOF
createdb plain
psql -qXd plain <<'EOF'
CREATE TABLE plain (id BIGINT PRIMARY KEY, n BIGINT);
INSERT INTO plain SELECT i, 0 FROM generate_series(1, 10000) AS i;
CREATE TABLE sample (data BYTEA);
CREATE TABLE value (data BYTEA);
ALTER TABLE sample ALTER data SET STORAGE EXTERNAL;
ALTER TABLE value ALTER data SET STORAGE EXTERNAL;
INSERT INTO sample SELECT decode(string_agg(md5(i::text), ''), 'hex') FROM generate_series(1, 4096) AS i;
EOF
for run in $(seq "$runs"); do
    base=$(/usr/lib/postgresql/*/bin/pgbench -n -d plain -f "$script" -c "$connections" -j 2 -T "$seconds" 2>/dev/null |
        sed -n 's/^tps = \([0-9.]*\).*/\1/p')
    psql -qXtd test -c 'SET client_min_messages = error; DROP SCHEMA public CASCADE; CREATE SCHEMA public'
    own=$("$build/tests/bench/bench_cycles" "$PENUMBRA_TEST_POSTGRES" "$connections" "$seconds" 2>&1 |
        sed -n 's/.*: \([0-9]*\) batches.*/\1/p')
    bytes=$(psql -qXtAd test -c "SELECT CAST(avg(bytes) AS BIGINT) FROM object WHERE format = 'pixels'")
    echo "$run: pgbench $base/s, store $own/s with $bytes bytes each, ratio $(echo "$own / $base" | bc -l | cut -c1-5)"
done
