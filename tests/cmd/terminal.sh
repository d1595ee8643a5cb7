#!/bin/sh
# SPDX-License-Identifier: MIT
# Names from scenes, files and servers cannot control a terminal: no control or bidirectional character
# of theirs is printed, by the command line or by the log.
. "$(dirname "$0")/lib.sh"
cd "$work" || exit 1
# U+202E, U+2066, an escape sequence, C1's CSI, a carriage return.
evil=$(printf 'n\342\200\256\342\201\246\033[31m\302\2331m\r')
harmless() { # NAME FILE…: no such character is in the files
    name=$1
    shift
    if LC_ALL=C grep -qP '\xe2\x80\xae|\xe2\x81\xa6|\x1b|\xc2\x9b|\r' "$@"; then
        not_ok "$name" "$(cat -v "$@" | head -c 600)"
    else
        ok "$name"
    fi
}
json=$(jq -n --arg e "$evil" '$e')
printf '{"format": "penumbra-scene/1", "name": %s, "camera": {"position": [0, 0, 5], "look_at": [0, 0, 0]},
 "materials": {%s: {"kd": 1}}, "objects": [{"type": "sphere", "name": %s, "center": [0, 0, 0], "radius": 1,
 "material": %s}], "render": {"width": 8, "height": 8}}' "$json" "$json" "$json" "$json" >good.json
jq -c --arg e "$evil" '.objects[0].material = $e + "x" | .[$e] = 1' good.json >bad.json
jq -c --arg e "$evil" 'del(.objects[0].material)' good.json >"warn$evil.json"

exits "a scene with such names is refused for its error" 3 "$penumbra" validate bad.json
prints "and the name is shown escaped" stderr 'n\u202e'
harmless "validate: errors" stdout stderr
exits "validate, with a name of a file and a warning" 0 "$penumbra" validate "warn$evil.json"
prints "which names a material" stderr "no object uses"
harmless "validate: warnings and the name of a file" stdout stderr
exits "validate --json" 3 "$penumbra" validate --json bad.json
harmless "JSON on standard output" stdout
expect "which means the same" "$(jq -r '[.errors[].pointer] | any(contains("\u202e"))' stdout)" true
for command in "explain" "bench --repeats 1 --warmup 0 -m threads=1" "effects --repeats 1"; do
    # shellcheck disable=SC2086
    exits "$command" 0 "$penumbra" $command good.json
    harmless "$command" stdout stderr
done
exits "render of a file with such a name" 0 "$penumbra" render "warn$evil.json" -o out.png
harmless "render" stdout stderr

# Jobs whose names another client has chosen, and a daemon's log
daemon_start --log-level debug
export PENUMBRA_URL="$url"
id=$("$penumbra" submit good.json --name "$evil" --label "$evil=$evil")
exits "wait" 0 "$penumbra" wait "$id"
exits "list" 0 "$penumbra" list
prints "the name is shown escaped" stdout 'n\u202e'
harmless "list" stdout stderr
exits "list --json" 0 "$penumbra" list --json
harmless "list --json" stdout
exits "top" 0 "$penumbra" top --once
harmless "top" stdout stderr
exits "wait for a job that is not there" 4 "$penumbra" wait "$evil"
harmless "wait" stdout stderr
curl -s -o answer -H "X-Request-Id: $(printf 'a\342\200\256b')" "$url/v1/jobs/%E2%80%AE%1B"
harmless "the daemon's log" log

# A server that is no friend
cat >server.py <<'END'
import http.server, json, sys
evil = sys.argv[1]
job = {"id": evil, "state": evil, "kind": evil, "name": evil, "created_at": evil, "progress": {"fraction": 0.5}}
answers = {"/v1/workers": {"workers": [{"host": evil, "pid": 1, "threads": 1, "last_seen_at": evil,
           "batches": [{"job": evil, "kind": evil, "view": evil, "attempt": 1}]}]}}
class Handler(http.server.BaseHTTPRequestHandler):
    def answer(self):
        path = self.path.split("?")[0]
        status, body = (200, answers[path]) if path in answers else (200, {"jobs": [job]}) \
            if path == "/v1/jobs" and self.command == "GET" else (422, {"type": evil, "title": evil, "status": 422,
            "detail": evil, "errors": [{"pointer": "/" + evil, "detail": evil}]})
        if path.endswith("/cancel"):
            status, body = 202, job
        data = json.dumps(body).encode()
        self.send_response(status)
        self.send_header("Content-Type", "application/json" if status < 400 else "application/problem+json")
        self.send_header("Content-Length", str(len(data)))
        self.end_headers()
        self.wfile.write(data)
    do_GET = do_POST = do_DELETE = answer
    def log_message(self, *arguments):
        pass
server = http.server.HTTPServer(("127.0.0.1", 0), Handler)
print(server.server_port, flush=True)
server.serve_forever()
END
python3 server.py "$evil" >port &
server=$!
within test -s port
export PENUMBRA_URL="http://127.0.0.1:$(cat port)"
exits "list from a hostile server" 0 "$penumbra" list --retry 0
harmless "list from a hostile server" stdout stderr
exits "top from a hostile server" 0 "$penumbra" top --once --retry 0
harmless "top from a hostile server" stdout stderr
exits "cancel at a hostile server" 0 "$penumbra" cancel x --retry 0
harmless "cancel at a hostile server" stdout stderr
exits "submit to a hostile server" 3 "$penumbra" submit good.json --retry 0
harmless "submit to a hostile server" stdout stderr
kill $server
wait $server 2>/dev/null
finish
