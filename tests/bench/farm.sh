#!/bin/sh
# SPDX-License-Identifier: MIT
# Renders scenes over 1, 2 and 4 workers of one thread that share a PostgreSQL server. Compares picture,
# floats and ray counts with those of `penumbra render`: tests/bench/farm.sh BUILD [SPP [SCENE…]]. Prints the
# seconds from the first claim to the end.
set -eu
build=$(cd "$1" && pwd)
if [ -z "${PENUMBRA_TEST_POSTGRES:-}" ]; then
    PENUMBRA_TEST_FSYNC=on exec sh "$(dirname "$0")/../support/postgres.sh" sh "$0" "$@"
fi
spp=${2:-64}
shift
[ $# -eq 0 ] || shift
[ $# -gt 0 ] || set -- room room-soft
work=$(mktemp -d)
pids=
stop() {
    [ -z "$pids" ] || kill $pids 2>/dev/null || :
    wait
    rm -rf "$work"
}
trap stop EXIT
cd "$work"
PENUMBRA_STORE=$PENUMBRA_TEST_POSTGRES
export PENUMBRA_STORE
"$build/penumbrad" --role api --listen 127.0.0.1:0 >api.out 2>api.log &
pids=$!
until [ -s api.out ]; do sleep 0.1; done
PENUMBRA_URL=$(sed -n 's/^listening on //p' api.out)
export PENUMBRA_URL
rays() { jq -cS .rays "$1"; }
for scene; do
    "$build/penumbra" render "builtin:$scene" --set samples_per_pixel="$spp" -o own.png --stats own.json
    "$build/penumbra" render "builtin:$scene" --set samples_per_pixel="$spp" -o own.pfm
    one=
    for workers in 1 2 4; do
        running=
        for _ in $(seq "$workers"); do
            "$build/penumbrad" --role worker --threads 1 >/dev/null 2>>worker.log &
            running="$running $!"
        done
        pids="$pids $running"
        sleep 3
        id=$("$build/penumbra" submit "builtin:$scene" --set samples_per_pixel="$spp")
        "$build/penumbra" wait "$id" >/dev/null 2>&1
        "$build/penumbra" fetch "$id" -o farm.png
        "$build/penumbra" fetch "$id" -o farm.pfm --format pfm
        curl -s "$PENUMBRA_URL/v1/jobs/$id/stats" >farm.json
        cmp own.png farm.png
        cmp own.pfm farm.pfm
        [ "$(rays own.json)" = "$(rays farm.json)" ] || echo "other rays: $(rays own.json) $(rays farm.json)"
        seconds=$(curl -s "$PENUMBRA_URL/v1/jobs/$id" | jq '
            def s: sub("\\.(?<ms>[0-9]+)Z"; "Z") | fromdate; def f: capture("\\.(?<ms>[0-9]+)Z").ms | tonumber / 1000;
            (.finished_at | s + 0) - (.started_at | s + 0) + (.finished_at | f) - (.started_at | f)')
        one=${one:-$seconds}
        batches=$(psql -qXtAd test -c "SELECT count(*) FROM batch JOIN job ON job.number = batch.job WHERE job.id = '$id'")
        echo "$scene, $workers workers: $seconds s, $(echo "$one / $seconds" | bc -l | cut -c1-5) times as fast as one; $batches batches"
        kill $running
        for pid in $running; do wait "$pid" || :; done
        pids=${pids%%" $running"*}
    done
done
