#!/bin/sh
# SPDX-License-Identifier: MIT
# The command line against a daemon: from submit to delete, and what it says when something is
# wrong.
. "$(dirname "$0")/lib.sh"
daemon_start
export PENUMBRA_URL="$url"
cd "$work" || exit 1
"$penumbra" scenes spheres >scene.json
set -- --set width=60 --set height=40

# Submit, wait, fetch: the bytes are those of a render without a daemon
ends "submit a file" 0 "$penumbra" submit scene.json "$@" --name first --label shot=12 --priority 5
id=$(cat stdout)
expect_match "prints the id" "$id" '????????-????-7???-????-????????????'
ends "wait" 0 "$penumbra" wait "$id"
says "prints the end" stdout "$id succeeded"
expect "and nothing else" "$(cat stdout stderr)" "$id succeeded"
for out in a.png a.pfm; do
    ends "fetch $out" 0 "$penumbra" fetch "$id" -o $out
    "$penumbra" render scene.json "$@" -o local.${out#a.}
    check "is the same as rendered here" cmp $out local.${out#a.}
done
ends "fetch 16 bits" 0 "$penumbra" fetch "$id" -o deep.png --format png16
"$penumbra" render scene.json "$@" -o local16.png --format png16
check "is the same as rendered here" cmp deep.png local16.png
ends "fetch to standard output" 0 "$penumbra" fetch "$id" -o - --format png
check "is the same" cmp stdout a.png
ends "wait --json" 0 "$penumbra" wait "$id" --json
expect "is the job" "$(jq -c '[.name, .labels, .priority, .state]' stdout)" \
    '["first",{"shot":"12"},5,"succeeded"]'
ends "stats" 0 "$penumbra" stats "$id"
expect "count primary rays" "$(jq .rays.primary stdout)" 2400
ends "stats into a file" 0 "$penumbra" stats "$id" -o stats.json
expect "are the same" "$(jq .rays.primary stats.json)" 2400

# Accelerators: each does its work, and none changes the picture
for kind in auto none cbr manual median; do
    ends "submit with $kind" 0 "$penumbra" submit scene.json "$@" --set accelerator=$kind -o kind.png
    check "gives the same bytes" cmp kind.png a.png
    "$penumbra" stats "$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')" >stats.json
    expect "and is in the statistics" "$(jq -r .accelerator.kind stats.json)" $kind
done
ends "an accelerator that is none" 2 "$penumbra" submit scene.json --set accelerator=bvh
says "is answered with all there are" stderr '"auto", "none", "cbr", "manual", "median"'

# Views: one job, each fetched by name, and all on one sheet
jq '. + {views: [{name: "front"}, {name: "side", camera: {position: [5, 2, 9]}},
    {name: "above", camera: {position: [0, 9, 3]}}]}' scene.json >views.json
ends "submit a scene of views" 0 "$penumbra" submit views.json "$@" --wait
views=$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')
for view in front side above; do
    ends "fetch --view $view" 0 "$penumbra" fetch "$views" -o $view.pfm --view $view
    "$penumbra" render views.json "$@" -o local.pfm --view $view
    check "is the same as rendered here" cmp $view.pfm local.pfm
done
ends "fetch the first view by default" 0 "$penumbra" fetch "$views" -o first.pfm
check "is the first of the document" cmp first.pfm front.pfm
ends "fetch --view all" 0 "$penumbra" fetch "$views" -o sheet.pfm --view all
expect "is a sheet of two by two" "$(sed -n 2p sheet.pfm)" "121 81"
ends "fetch a view that is not there" 4 "$penumbra" fetch "$views" -o x.pfm --view below
ends "submit some of the views" 0 "$penumbra" submit views.json "$@" --view above --view side --wait
views=$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')
ends "fetch the first of them" 0 "$penumbra" fetch "$views" -o first.pfm --view above
check "is the same" cmp first.pfm above.pfm
ends "fetch one that was left out" 4 "$penumbra" fetch "$views" -o x.pfm --view front

# Ways to submit
ends "submit and wait" 0 "$penumbra" submit builtin:spheres "$@" --wait
ends "submit and fetch" 0 "$penumbra" submit builtin:spheres "$@" -o b.png
check "a built-in scene is the file" cmp b.png a.png
ends "submit from standard input" 0 sh -c "'$penumbra' submit - --json -w <scene.json"
expect "without options the scene's own size" "$(jq .progress.total stdout)" \
    "$(jq '.render.width * .render.height' scene.json)"
jq '{scene: ., render: {width: 60, height: 40}, name: "whole", priority: 1}' scene.json >job.json
ends "submit a whole job" 0 "$penumbra" submit job.json --json
expect "keeps its members" "$(jq -c '[.name, .priority, .progress.total]' stdout)" \
    '["whole",1,2400]'
ends "submit a whole job with options" 0 "$penumbra" submit job.json --json --name other \
    --set height=20
expect "the command line wins, the rest stays" \
    "$(jq -c '[.name, .priority, .progress.total]' stdout)" '["other",1,1200]'
ends "the same key" 0 "$penumbra" submit job.json --idempotency-key k1
cp stdout first
ends "and the same job again" 0 "$penumbra" submit job.json --idempotency-key k1
check "is the first job" cmp first stdout
ends "the same key for another job" 3 "$penumbra" submit scene.json --idempotency-key k1
ends "without a key" 0 "$penumbra" submit job.json
if cmp -s first stdout; then
    not_ok "each submit is a job of its own" "same id"
else
    ok "each submit is a job of its own"
fi

# Errors of a document: places are those of the file, whether it was wrapped in a job or not
sed 's/"radius": *[0-9.]*/"radius": -1/; s/"ambient"/"ambiant"/' scene.json >bad.json
ends "a bad scene" 3 "$penumbra" submit bad.json
says "is located" stderr "penumbra: bad.json: "
says "by pointer" stderr "/ambiant"
cp stderr bare
ends "a bad scene with options" 3 "$penumbra" submit bad.json "$@"
check "has its errors in the same places" cmp stderr bare
ends "and with --json" 3 "$penumbra" submit bad.json --json
expect "a problem document" "$(jq .status stdout)" 422
printf '{"format": "penumbra-scene/1",\n  "camera": nonsense}' >broken.json
ends "a malformed scene" 3 "$penumbra" submit broken.json "$@"
says "is located by line" stderr "broken.json:2:"
ends "a wrong setting" 2 "$penumbra" submit scene.json --set widht=3
says "is answered here" stderr '--set widht=3: '
ends "a label without a value" 2 "$penumbra" submit scene.json --label x
ends "a view that is not there" 3 "$penumbra" submit scene.json --view nowhere
ends "a built-in scene that is not there" 4 "$penumbra" submit builtin:nowhere

# List
ends "list" 0 "$penumbra" list
says "has a head" stdout "STATE"
says "has the first job" stdout "$id  succeeded"
says "has its name" stdout "first"
total=$(($(wc -l <stdout) - 1))
ends "list --limit" 0 "$penumbra" list --limit 2 --json
expect "shows that many" "$(jq '.jobs | length' stdout)" 2
ends "list --state" 0 "$penumbra" list --state failed
expect "shows nothing if there is none" "$(cat stdout)" ""
for i in 1 2 3; do
    "$penumbra" submit job.json --name "$(printf 'bell\007')" >>ids
done
ends "list all" 0 "$penumbra" list --limit 1000 --json
expect "goes beyond" "$(jq '.jobs | length' stdout)" $((total + 3))
ends "list shows names" 0 "$penumbra" list
expect "without control characters" "$(tr -d '[:print:]\n' <stdout | wc -c | tr -d ' ')" 0

# Cancel and delete
printf '%s' "$long" >long.json
long_id=$("$penumbra" submit long.json)
ends "fetch from an unfinished job" 4 "$penumbra" fetch "$long_id" -o x.png
check "writes nothing" test ! -e x.png
ends "delete an unfinished job" 4 "$penumbra" delete "$long_id"
ends "cancel" 0 "$penumbra" cancel "$long_id"
says "says so" stdout "$long_id cancelled"
ends "cancel again" 0 "$penumbra" cancel "$long_id"
ends "wait for a cancelled job" 6 "$penumbra" wait "$long_id"
says "says so" stdout "$long_id cancelled"
says "and why" stderr "was cancelled"
ends "wait for a cancelled job, in JSON" 6 "$penumbra" wait "$long_id" --json
expect "prints one line, the job" "$(jq -r .state stdout)" cancelled
ends "cancel a finished job" 0 "$penumbra" cancel "$id"
says "it stays as it is" stdout "$id succeeded"
ends "wait for several, one of them cancelled" 6 "$penumbra" wait "$id" "$long_id"
says "tells of all" stdout "$id succeeded"
ends "delete" 0 "$penumbra" delete "$id" "$long_id"
ends "a deleted job" 4 "$penumbra" wait "$id"
ends "an id that is none" 4 "$penumbra" wait nonsense/../x --json
expect "prints a problem document" "$(jq .status stdout)" 404

# Top, and a wait that is told how the job goes on, also by the next api process
long_id=$("$penumbra" submit long.json)
"$penumbra" wait "$long_id" >waited 2>waited.err &
waiter=$!
working() {
    "$penumbra" top --json >top.json &&
        [ "$(jq -r '.workers[0].batches[0].job' top.json)" = "$long_id" ] &&
        [ "$(jq '.running[0].progress.done > 0' top.json)" = true ]
}
check "top --json shows a worker at its job" within 30 working
expect "and its threads" "$(jq '.workers[0].threads' top.json)" 2
ends "top" 0 "$penumbra" top
says "counts" stdout "workers 1, running 1, queued 0"
says "shows the worker" stdout "render of main, attempt 1"
says "and the job" stdout "$long_id ["
kill -KILL "$(child api)"
sleep 1.5
check "wait outlives the api process" kill -0 "$waiter"
"$penumbra" cancel "$long_id" >/dev/null
wait "$waiter"
expect "and hears of the end" "$? $(cat waited)" "6 $long_id cancelled"
ends "top with nothing to do" 0 "$penumbra" top --once
says "says so" stdout "running 0, queued 0"

# A daemon that is not there, is something else, or comes late
ends "no daemon" 5 "$penumbra" list --server http://127.0.0.1:9 --retry 0
says "names the server" stderr "http://127.0.0.1:9"
daemon_stop
ends "a daemon that was stopped" 5 "$penumbra" list --retry 0.2
port=${url##*:}
(
    sleep 1
    exec "$build/penumbrad" --listen "127.0.0.1:$port" --store "$store" >/dev/null 2>>"$work/log"
) &
daemon=$!
ends "a daemon that comes a second late" 0 "$penumbra" list --retry 20 --json
expect "has its jobs still" "$(jq '.jobs | length > 3' stdout)" true
daemon_stop

finish
