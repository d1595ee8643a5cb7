# SPDX-License-Identifier: MIT
# Runs the first own scene and the curl session of README.md as printed there, with this test's own daemon, and
# checks the results. Also checks its example of errors, and that the scene of scenes/README.md has an XML twin.
. "$(dirname "$0")/lib.sh"
root=$(cd "$(dirname "$0")/../.." && pwd)

daemon_start
awk '/^<!-- session:/ { found = 1 } found && /^```sh$/ { on = 1; next } on && /^```$/ { exit } on' \
    "$root/README.md" >"$work/session.sh"
expect session-found "$(grep -c '^URL=http://127.0.0.1:8080$' "$work/session.sh")" 1
sed -i "s|^URL=.*|URL=$url|; s|@scenes/|@$root/scenes/|" "$work/session.sh"

# On a slow machine a job takes more than the minute that the session waits for it. So this script waits for
# each job first.
cd "$work" || exit 1
export PENUMBRA_URL="$url"
sed -i "/^curl -s .*?wait=60\" | jq .state\$/i sh '$root/api/examples/wait.sh' \"/v1/jobs/\$JOB\" >ended" session.sh
expect session-waits-for-each-job "$(grep -c '/wait\.sh' session.sh)" 1
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

# The first own scene, with the programs of this build; then its second sphere is misspelt as the page has it.
awk '/^<!-- first:/ { found = 1 } found && /^```sh$/ { on = 1; next } on && /^```$/ { exit } on' "$root/README.md" |
    sed "s|^make .*||; s|^build/penumbra|'$build/penumbra' |" >first.sh
sh -eu first.sh >/dev/null 2>first.err
expect first-scene "$? $(head -c 8 scene.png | od -An -tx1 | tr -d ' ')" "0 89504e470d0a1a0a"
jq '.objects |= [.[1], (.[2] | .radios = .radius | del(.radius))]' scene.json >wrong.json
"$build/penumbra" validate wrong.json 2>wrong.err
expect error-example "$(sed -n '/^\$ build\/penumbra validate wrong/,/^```$/p' "$root/README.md" | sed '1d;$d')" "$(cat wrong.err)"
# The scene in JSON and its twin in XML have one picture.
for kind in json xml; do
    awk -v fence="^\`\`\`$kind\$" '$0 ~ fence { on = 1; next } on && /^```$/ { exit } on' "$root/scenes/README.md" >"scene.$kind"
    "$build/penumbra" render "scene.$kind" --set width=200 --set height=150 -o "$kind.png" 2>/dev/null
done
expect twins "$(cmp json.png xml.png && echo same)" same
finish
