# SPDX-License-Identifier: MIT
# Runs the curl session of README.md as printed there, with this test's own daemon, and checks its
# results. Also checks the README's example of an error with a place.
. "$(dirname "$0")/lib.sh"
root=$(cd "$(dirname "$0")/../.." && pwd)

daemon_start
awk '/^<!-- session:/ { found = 1 } found && /^```sh$/ { on = 1; next } on && /^```$/ { exit } on' \
    "$root/README.md" >"$work/session.sh"
expect session-found "$(grep -c '^URL=http://127.0.0.1:8080$' "$work/session.sh")" 1
sed -i "s|^URL=.*|URL=$url|; s|@scenes/|@$root/scenes/|" "$work/session.sh"

# On a slow machine a job takes more than the minute that the session waits for it, and the answer to an
# explain may be its job (202). So this script waits for each job first, and explains up to three times.
cd "$work" || exit 1
export PENUMBRA_URL="$url"
sed -i "/^curl -s .*?wait=60\" | jq .state\$/i sh '$root/api/examples/wait.sh' \"/v1/jobs/\$JOB\" >ended" session.sh
expect session-waits-for-each-job "$(grep -c '/wait\.sh' session.sh)" 4
sed -i '/^curl -s .*\/explain"/i explain() {
/^    jq .*\.because\]/a } >explained\
explain 2>failed || explain 2>failed || explain\
cat explained' session.sh
expect session-explains "$(grep -A 1 '^explain()' session.sh | grep -c '^curl') $(grep -A 1 '^} >' session.sh | grep -c ^explain)" "1 1"
sh -eu session.sh >session.out 2>session.err
expect session-exit "$?" 0
expect session-prints-no-errors "$(cat session.err)" ""
answer() { # NUMBER FILTER: the n-th JSON value that the session printed
    jq -c . session.out 2>/dev/null | sed -n "$1p" | jq "$2"
}
expect validate-answers "$(answer 1 .valid)" true
expect job-succeeded "$(answer 2 .)" '"succeeded"'
expect statistics "$(answer 3 '.timing.render_ms > 0 and .rays.primary == 1400000')" true
expect same-scene-queued "$(answer 4 '.render | [.width, .height, .samples_per_pixel]' | tr -d ' \n')" "[300,420,4]"
# The second job comes first, behind the answer to its submit, and has perhaps been rendered meanwhile
expect_match list-names-the-jobs "$(grep -o '[0-9a-f-]\{36\} [a-z]*$' session.out | cut -d ' ' -f 2 | tr '\n' ' ')" \
    '[qrs]* succeeded '
expect picture-is-png "$(head -c 8 room.png | od -An -tx1 | tr -d ' ')" 89504e470d0a1a0a
expect pixels-are-pfm "$(head -c 12 room.pfm | tr '\n' ' ')" "PF 1000 1400"
expect studies-succeeded "$(grep -c '^"succeeded"$' session.out)" 4
expect accuracy-recommends-or-says-why "$(grep -c -e '"light_samples": [0-9]*$' -e '"spoiled": [1-9]' session.out | sed 's/2/1/')" 1
expect study-is-a-page "$(head -n 1 study.html)" "<!doctype html>"
expect explanation "$(grep -c '^\["refraction","objects glass, ' session.out)" 1
expect bill-is-a-page "$(head -n 1 effects.html)" "<!doctype html>"
expect report-is-a-page "$(head -n 1 report.html)" "<!doctype html>"

# The error example: the text between "$ curl" and the next fence, against the daemon's answer.
sed -n '/^\$ curl -s localhost:8080\/v1\/validate/,/^```$/p' "$root/README.md" >example
sed -n "1,/jq .errors\$/p" example | tr -d '\n' | sed "s/^[^']*'//; s/'.*//" >example.json
sed '1,/jq .errors$/d; /^```$/d' example >example.wanted
curl -s "$url/v1/validate" --data-binary @example.json | jq .errors >example.got
expect error-example "$(cat example.got)" "$(cat example.wanted)"
# The scene in JSON and its twin in XML have one picture.
for kind in json xml; do
    awk -v fence="^\`\`\`$kind\$" '$0 ~ fence { on = 1; next } on && /^```$/ { exit } on' "$root/README.md" >"scene.$kind"
    "$build/penumbra" render "scene.$kind" --set width=200 --set height=150 -o "$kind.png" 2>/dev/null
done
expect twins "$(cmp json.png xml.png && echo same)" same
finish
