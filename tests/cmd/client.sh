#!/bin/sh
# SPDX-License-Identifier: MIT
# The subcommands that talk to a daemon, from submit to delete, and their error messages.
. "$(dirname "$0")/lib.sh"
threads=2
daemon_start
export PENUMBRA_URL="$url"
cd "$work" || exit 1
"$penumbra" scenes spheres >scene.json
set -- --set width=60 --set height=40

# Submit, wait, fetch: the bytes are those of a render without a daemon
exits "submit a file" 0 "$penumbra" submit scene.json "$@" --name first --label shot=12 --priority 5
id=$(cat stdout)
expect_match "submit prints the job's id" "$id" '????????-????-7???-????-????????????'
exits "wait" 0 "$penumbra" wait "$id"
prints "wait prints the last state" stdout "$id succeeded"
expect "wait prints nothing else" "$(cat stdout stderr)" "$id succeeded"
for out in a.png a.pfm; do
    exits "fetch $out" 0 "$penumbra" fetch "$id" -o $out
    "$penumbra" render scene.json "$@" -o local.${out#a.}
    check "the fetched picture equals a render without a daemon" cmp $out local.${out#a.}
done
exits "fetch 16 bits" 0 "$penumbra" fetch "$id" -o deep.png --format png16
"$penumbra" render scene.json "$@" -o local16.png --format png16
check "the fetched 16-bit picture equals a render without a daemon" cmp deep.png local16.png
exits "fetch to standard output" 0 "$penumbra" fetch "$id" -o - --format png
check "standard output has the same picture" cmp stdout a.png
exits "wait --json" 0 "$penumbra" wait "$id" --json
expect "wait --json prints the job" "$(jq -c '[.name, .labels, .priority, .state]' stdout)" \
    '["first",{"shot":"12"},5,"succeeded"]'
exits "stats" 0 "$penumbra" stats "$id"
expect "stats count primary rays" "$(jq .rays.primary stdout)" 2400
exits "stats into a file" 0 "$penumbra" stats "$id" -o stats.json
expect "the file has the same statistics" "$(jq .rays.primary stats.json)" 2400

# libcurl is loaded by the commands that talk to a daemon, and by no others
mkdir no-curl
: >no-curl/libcurl.so.4
exits "render without libcurl" 0 env LD_LIBRARY_PATH="$work/no-curl" "$penumbra" render scene.json "$@" -o alone.png
check "gives the same picture" cmp alone.png a.png
exits "list without libcurl" 5 env LD_LIBRARY_PATH="$work/no-curl" "$penumbra" list
prints "the error says what is missing" stderr "talking to a daemon needs libcurl: "

# Accelerators: each runs, and none changes the picture
for kind in auto none cbr manual median; do
    exits "submit with $kind" 0 "$penumbra" submit scene.json "$@" --set accelerator=$kind -o kind.png
    check "the accelerator gives the same bytes" cmp kind.png a.png
    "$penumbra" stats "$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')" >stats.json
    expect "the statistics name the accelerator" "$(jq -r .accelerator.kind stats.json)" $kind
done
exits "submit with an unknown accelerator" 2 "$penumbra" submit scene.json --set accelerator=bvh
prints "the error lists all accelerators" stderr '"auto", "none", "cbr", "manual", "median"'

# Views: one job, each fetched by name, and all on one sheet
jq '. + {views: [{name: "front"}, {name: "side", camera: {position: [5, 2, 9]}},
    {name: "above", camera: {position: [0, 9, 3]}}]}' scene.json >views.json
exits "submit a scene of views" 0 "$penumbra" submit views.json "$@" --wait
views=$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')
for view in front side above; do
    exits "fetch --view $view" 0 "$penumbra" fetch "$views" -o $view.pfm --view $view
    "$penumbra" render views.json "$@" -o local.pfm --view $view
    check "the view equals a render without a daemon" cmp $view.pfm local.pfm
done
exits "fetch the first view by default" 0 "$penumbra" fetch "$views" -o first.pfm
check "it is the first view of the document" cmp first.pfm front.pfm
exits "fetch --view all" 0 "$penumbra" fetch "$views" -o sheet.pfm --view all
expect "--view all gives a sheet of two by two views" "$(sed -n 2p sheet.pfm)" "121 81"
exits "fetch an unknown view" 4 "$penumbra" fetch "$views" -o x.pfm --view below
exits "submit some of the views" 0 "$penumbra" submit views.json "$@" --view above --view side --wait
views=$("$penumbra" list --limit 1 --json | jq -r '.jobs[0].id')
exits "fetch the first of them" 0 "$penumbra" fetch "$views" -o first.pfm --view above
check "it is the view of that name" cmp first.pfm above.pfm
exits "fetch a view that was not submitted" 4 "$penumbra" fetch "$views" -o x.pfm --view front

# Ways to submit
exits "submit and wait" 0 "$penumbra" submit builtin:spheres "$@" --wait
exits "submit and fetch" 0 "$penumbra" submit builtin:spheres "$@" -o b.png
check "the built-in scene equals the file" cmp b.png a.png
exits "submit to standard output" 0 "$penumbra" submit builtin:spheres "$@" -o -
check "it has the picture and nothing else" cmp stdout a.png
check "standard error has the job's id" grep -qx "[0-9a-f-]\{36\}" stderr
jobs() { "$penumbra" list --json | jq '.jobs | length'; }
before=$(jobs)
exits "submit a render to a report" 2 "$penumbra" submit builtin:spheres "$@" -o x.json
prints "it says what a picture may be named" stderr '--output: found "x.json", allowed is a name ending in .png or .pfm'
expect "and sends nothing" "$(jobs)" "$before"
exits "submit to standard output with --json" 2 "$penumbra" submit builtin:spheres "$@" -o - --json
exits "submit from standard input" 0 sh -c "'$penumbra' submit - --json -w <scene.json"
expect "without options the picture has the scene's size" "$(jq .progress.total stdout)" \
    "$(jq '.render.width * .render.height' scene.json)"
jq '{scene: ., render: {width: 60, height: 40}, name: "whole", priority: 1}' scene.json >job.json
exits "submit a whole job" 0 "$penumbra" submit job.json --json
expect "a whole job keeps its members" "$(jq -c '[.name, .priority, .progress.total]' stdout)" \
    '["whole",1,2400]'
exits "submit a whole job with options" 0 "$penumbra" submit job.json --json --name other \
    --set height=20
expect "options override the job's members, the others stay" \
    "$(jq -c '[.name, .priority, .progress.total]' stdout)" '["other",1,1200]'
exits "submit with a key" 0 "$penumbra" submit job.json --idempotency-key k1
cp stdout first
exits "submit the same job with the same key" 0 "$penumbra" submit job.json --idempotency-key k1
check "prints the id of the first job" cmp first stdout
exits "submit another job with the same key" 3 "$penumbra" submit scene.json --idempotency-key k1
exits "submit without a key" 0 "$penumbra" submit job.json
if cmp -s first stdout; then
    not_ok "each submit is a job of its own" "same id"
else
    ok "each submit is a job of its own"
fi

# Errors of a document have their places in the file, also if the document is sent inside a job
sed 's/"radius": *[0-9.]*/"radius": -1/; s/"ambient"/"ambiant"/' scene.json >bad.json
exits "submit an invalid scene" 3 "$penumbra" submit bad.json
prints "the error names the file" stderr "penumbra: bad.json: "
prints "and has a JSON Pointer" stderr "/ambiant"
cp stderr bare
exits "submit an invalid scene with options" 3 "$penumbra" submit bad.json "$@"
check "the errors have the same places" cmp stderr bare
exits "submit an invalid scene with --json" 3 "$penumbra" submit bad.json --json
expect "prints a problem document" "$(jq .status stdout)" 422
printf '{"format": "penumbra-scene/1",\n  "camera": nonsense}' >broken.json
exits "submit malformed JSON" 3 "$penumbra" submit broken.json "$@"
prints "the error has the line in the file" stderr "broken.json:2:"
exits "submit an unknown setting" 2 "$penumbra" submit scene.json --set widht=3
prints "the error names the option --set" stderr '--set widht=3: '
exits "submit a label without a value" 2 "$penumbra" submit scene.json --label x
for option in --name --view --label; do
    exits "submit with $option that is not UTF-8" 2 "$penumbra" submit scene.json $option "$(printf 'a=\377')"
    prints "the error names the option" stderr "$option: must be text in UTF-8"
done
exits "submit an unknown view" 3 "$penumbra" submit scene.json --view nowhere
exits "submit an unknown built-in scene" 4 "$penumbra" submit builtin:nowhere

# List
exits "list" 0 "$penumbra" list
prints "list prints a heading" stdout "STATE"
prints "list prints the first job" stdout "$id  render     succeeded"
prints "list prints the job's name" stdout "first"
total=$(($(wc -l <stdout) - 1))
exits "list --limit" 0 "$penumbra" list --limit 2 --json
expect "list --limit prints that many jobs" "$(jq '.jobs | length' stdout)" 2
exits "list --state" 0 "$penumbra" list --state failed
expect "list --state prints nothing if no job has that state" "$(cat stdout)" ""
for i in 1 2 3; do
    "$penumbra" submit job.json --name "$(printf 'bell\007')" >>ids
done
exits "list all" 0 "$penumbra" list --limit 1000 --json
expect "list continues beyond the first page" "$(jq '.jobs | length' stdout)" $((total + 3))

# A page of the daemon's ends at 1 MiB, so that list reads several of jobs with long labels
jq -n '{scene: {format: "penumbra-scene/1", camera: {position: [0, 0, 9], look_at: [0, 0, 0]}, objects: []},
    render: {width: 1, height: 1}, labels: ([range(32) | {key: tostring, value: ("x" * 200)}] | from_entries)}' >labels.json
curl -s -o /dev/null -H 'Content-Type: application/json' -d @labels.json "$url/v1/jobs#[1-120]"
check "the daemon's page is shorter than asked for" \
    test "$(curl -s "$url/v1/jobs?limit=120" | jq '.jobs | length')" -lt 120
exits "list jobs with long labels" 0 "$penumbra" list --limit 120 --label "0:$(jq -r '.labels."0"' labels.json)" --json
expect "list reads all pages" "$(jq '[.jobs[].id] | unique | length' stdout)" 120
exits "list of jobs with control characters in their names" 0 "$penumbra" list
expect "prints no control characters" "$(tr -d '[:print:]\n' <stdout | wc -c | tr -d ' ')" 0

# Cancel and delete
printf '%s' "$long" >long.json
long_id=$("$penumbra" submit long.json)
exits "fetch from an unfinished job" 4 "$penumbra" fetch "$long_id" -o x.png
check "fetch from an unfinished job writes no file" test ! -e x.png
exits "delete an unfinished job" 4 "$penumbra" delete "$long_id"
exits "cancel" 0 "$penumbra" cancel "$long_id"
prints "cancel prints the state" stdout "$long_id cancelled"
exits "cancel again" 0 "$penumbra" cancel "$long_id"
exits "wait for a cancelled job" 6 "$penumbra" wait "$long_id"
prints "wait prints the state cancelled" stdout "$long_id cancelled"
prints "wait says that the job was cancelled" stderr "was cancelled"
exits "wait for a cancelled job, in JSON" 6 "$penumbra" wait "$long_id" --json
expect "wait --json prints the cancelled job" "$(jq -r .state stdout)" cancelled
exits "cancel a finished job" 0 "$penumbra" cancel "$id"
prints "a finished job does not change" stdout "$id succeeded"
exits "wait for several, one of them cancelled" 6 "$penumbra" wait "$id" "$long_id"
prints "wait prints the state of each job" stdout "$id succeeded"
exits "delete" 0 "$penumbra" delete "$id" "$long_id"
exits "wait for a deleted job" 4 "$penumbra" wait "$id"
exits "statistics stay" 0 "$penumbra" stats "$id"
exits "unless they are deleted, too" 0 "$penumbra" delete --stats "$id"
exits "then there are none" 4 "$penumbra" stats "$id"
exits "wait for an id that is no UUID" 4 "$penumbra" wait nonsense/../x --json
expect "prints a problem document with status 404" "$(jq .status stdout)" 404

# `top`, and a `wait` that goes on with the next api process
long_id=$("$penumbra" submit long.json)
"$penumbra" wait "$long_id" >waited 2>waited.err &
waiter=$!
working() {
    "$penumbra" top --json >top.json &&
        [ "$(jq -r '.workers[0].batches[0].job' top.json)" = "$long_id" ] &&
        [ "$(jq '.running[0].progress.done > 0' top.json)" = true ] &&
        [ "$(jq -c '[.running, .queued] | map(length)' top.json)" = '[1,0]' ] # the short jobs before it have ended
}
check "top --json shows the worker's batch" within working
expect "top --json shows the worker's threads" "$(jq '.workers[0].threads' top.json)" 2
exits "top" 0 "$penumbra" top
prints "top counts workers and jobs" stdout "workers 1, running 1, queued 0"
prints "top shows the worker's batch" stdout "render of main"
prints "top shows the job" stdout "$long_id ["
kill -KILL "$(child api)"
sleep 1.5
check "wait goes on after the api process was killed" kill -0 "$waiter"
"$penumbra" cancel "$long_id" >/dev/null
wait "$waiter"
expect "wait reports the end of the job" "$? $(cat waited)" "6 $long_id cancelled"
exits "top without running jobs" 0 "$penumbra" top --once
prints "top counts no running jobs" stdout "running 0, queued 0"

# No daemon, a stopped daemon, and a daemon that starts late
exits "list without a daemon" 5 "$penumbra" list --server http://127.0.0.1:9 --retry 0
prints "the error names the server" stderr "http://127.0.0.1:9"
daemon_stop
exits "list after the daemon has stopped" 5 "$penumbra" list --retry 0.2
port=${url##*:}
(
    sleep 1
    exec "$build/penumbrad" --listen "127.0.0.1:$port" --store "$store" >/dev/null 2>>"$work/log"
) &
daemon=$!
exits "list while the daemon starts a second later" 0 "$penumbra" list --retry 20 --json
expect "the restarted daemon has its jobs" "$(jq '.jobs | length > 3' stdout)" true
daemon_stop

finish
