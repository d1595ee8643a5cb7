# SPDX-License-Identifier: MIT
"""Holds a running daemon against api/openapi.yaml: openapi.py URL.

Each row of `samples` is a request to an operation and the status it must get. A status that is
documented and not sampled is an error, except those that need a failing or draining store: tests of
module store and tests/http provoke these.
"""
import http.client
import json
import os
import ssl
import sys
import time
import urllib.parse

import yaml

NEEDS_FAULT = {"429", "503", "507"}
SMALL = '{"scene": "builtin:spheres", "render": {"width": 32, "height": 24}}'
XML = '<scene><render width="8" height="8"/></scene>'
LONG = ('{"scene": "builtin:spheres",'
        ' "render": {"width": 4000, "height": 4000, "samples_per_pixel": 64}}')
BENCHMARK = ('{"scene": "builtin:spheres", "kind": "benchmark", "render": {"width": 16, "height": 12},'
             ' "matrix": {"accelerator": ["none", "auto"], "threads": [1, 64]}, "repeats": 1}')
BILL = '{"scene": "builtin:glass", "kind": "effects", "render": {"width": 16, "height": 12}, "repeats": 1}'
# These take another client that cancels the job, or a worker that fails.
NOT_SAMPLED = {("explain", "409"), ("explain", "500")}
NOBODY = "01890a5d-ac96-774b-bcce-b302099a8057"

url = urllib.parse.urlsplit(sys.argv[1])
# With a token that the environment has (lib.sh).
TOKEN = {"Authorization": "Bearer " + os.environ["PENUMBRA_TOKEN"]} if "PENUMBRA_TOKEN" in os.environ else {}
with open("api/openapi.yaml", encoding="utf-8") as file:
    definition = yaml.safe_load(file)


def check(name, wrong):
    print(f"not ok {name}: {wrong}" if wrong else f"ok {name}")


def connect():
    if url.scheme == "http":
        return http.client.HTTPConnection(url.hostname, url.port, timeout=90)
    context = ssl.create_default_context(cafile=os.environ["PENUMBRA_CA"])
    return http.client.HTTPSConnection(url.hostname, url.port, timeout=90, context=context)


def ask(method, path, body=None, **fields):
    connection = connect()
    fields = {name.replace("_", "-"): value for name, value in fields.items()} | TOKEN
    chunked = fields.pop("chunked", False)
    if method == "POST" and body is None and not chunked:
        connection.putrequest(method, path)  # without Content-Length
        for name, value in fields.items():
            connection.putheader(name, value)
        connection.endheaders()
    else:
        data = (part for part in [b"{}"]) if chunked else body
        connection.request(method, path, data, fields, encode_chunked=bool(chunked))
    answer = connection.getresponse()
    answer.content = answer.read()
    connection.close()
    return answer


def submit(body):
    return json.loads(ask("POST", "/v1/jobs", body).content)["id"]


def wait_for(job):
    """Waits until the job has ended, for ten minutes at most."""
    for _ in range(10):
        if json.loads(ask("GET", f"/v1/jobs/{job}?wait=60").content)["state"] not in ("queued", "running"):
            return


def wait_for_all():
    """Waits until no job waits or runs, for ten minutes at most."""
    until = time.monotonic() + 600
    while time.monotonic() < until and any(json.loads(ask("GET", f"/v1/jobs?state={state}").content)["jobs"]
                                           for state in ("queued", "running")):
        time.sleep(0.1)


def resolve(node):
    while isinstance(node, dict) and "$ref" in node and node["$ref"].startswith("#/"):
        target = definition
        for key in node["$ref"][2:].split("/"):
            target = target[key]
        node = target
    return node


def compare(value, schema, at=""):
    """What is wrong with a JSON value, by the part of JSON Schema that the definition uses."""
    schema = resolve(schema)
    if "$ref" in schema:
        return None  # the scene schema: tests of module io hold it against the reader
    if "const" in schema and value != schema["const"]:
        return f"{at} is {value!r}"
    if "enum" in schema and value not in schema["enum"]:
        return f"{at} is {value!r}"
    if "oneOf" in schema:
        wrongs = [compare(value, option, at) for option in schema["oneOf"]]
        return None if None in wrongs else wrongs[-1]
    types = schema.get("type", [])
    types = [types] if isinstance(types, str) else types
    python = {"object": dict, "array": list, "string": str, "integer": int, "null": type(None),
              "number": (int, float), "boolean": bool}
    if types and not any(isinstance(value, python[name]) for name in types):
        return f"{at} is {value!r}, no {types}"
    if isinstance(value, dict):
        properties = schema.get("properties", {})
        for key in schema.get("required", []):
            if key not in value:
                return f"{at} lacks {key}"
        for key, part in value.items():
            if key in properties:
                wrong = compare(part, properties[key], f"{at}/{key}")
                if wrong:
                    return wrong
            elif properties and "additionalProperties" not in schema:
                return f"{at}/{key} is not documented"
    if isinstance(value, list) and "items" in schema:
        for i, part in enumerate(value):
            wrong = compare(part, schema["items"], f"{at}/{i}")
            if wrong:
                return wrong
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        if value < schema.get("minimum", value) or value > schema.get("maximum", value):
            return f"{at} is {value}"
    return None


def judge(operation, status, answer):
    """What is wrong with an answer to an operation that had to get this status."""
    if answer.reason in ("", "Status"):
        return f"{answer.status} without its reason phrase"
    if str(answer.status) != status:
        return f"{answer.status} {answer.content[:200]!r}"
    if status not in operation["responses"]:
        return "status not documented"
    response = resolve(operation["responses"][status])
    for name, header in response.get("headers", {}).items():
        header, value = resolve(header), answer.getheader(name)
        if header.get("required") and value is None:
            return f"no {name}"
        if value is not None and value != header.get("schema", {}).get("const", value):
            return f"{name} is {value!r}"
    content = response.get("content", {})
    if not content:
        return "a body" if answer.content else None
    kind = (answer.getheader("Content-Type") or "").split(";")[0]
    if kind not in content:
        return f"type {kind}"
    if kind.endswith("json"):
        return compare(json.loads(answer.content), content[kind].get("schema", {}))
    return None


done = submit(SMALL)
gone = submit(SMALL)
kept = submit(SMALL)
removed = json.loads(ask("POST", "/v1/jobs", SMALL, Idempotency_Key="removed").content)["id"]
for one in (done, gone, kept, removed):
    wait_for(one)
ask("DELETE", f"/v1/jobs/{removed}")
measured = submit(BENCHMARK)
wait_for(measured)
billed = submit(BILL)
wait_for(billed)
busy = submit(LONG)
late = submit(BENCHMARK)  # has to wait for `busy`
unrendered = submit(SMALL)
ask("POST", f"/v1/jobs/{unrendered}/cancel", b"")
ask("POST", "/v1/jobs", SMALL, Idempotency_Key="k")
everything = {"If_None_Match": "*"}
known = {"Last_Event_ID": None}
for line in ask("GET", f"/v1/jobs/{done}/events").content.decode().splitlines():
    if line.startswith("id: "):
        known["Last_Event_ID"] = line[4:]
body_samples = [
    ("400", "", {"body": "{"}), ("411", "", {}), ("422", "", {"chunked": True}),
    ("413", "", {"body": '{"scene": "builtin:spheres", "render": {"width": 60000, "height": 60000}}'}),
    ("415", "", {"body": "x", "Content_Type": "text/plain"}),
    ("400", "", {"body": "<scene>"}), ("422", "", {"body": "<fog/>", "Content_Type": "text/xml"}),
    ("422", "", {"body": "{}"}), ("422", "", {"body": '{"scene": "builtin:room", "fog": [1]}'}),
    ("404", "", {"body": '{"scene": "builtin:rom"}'}),
]
samples = {
    "submitJob": [("202", "", {"body": SMALL}), ("202", "", {"body": BENCHMARK}),
                  ("202", "", {"body": XML}), *body_samples,
                  ("422", "", {"body": SMALL + " ", "Idempotency_Key": "k"}),
                  ("410", "", {"body": SMALL, "Idempotency_Key": "removed"})],
    "listJobs": [("200", "", {}), ("200", "?limit=1", {}), ("400", "?limit=0", {}),
                 ("400", "?cursor=x", {})],
    "getJob": [("200", done, {}), ("200", busy, {}), ("200", measured, {}), ("200", billed, {}), ("304", done, everything),
               ("400", done + "?wait=99", {}), ("404", NOBODY, {}), ("410", gone, {})],
    "getEvents": [("200", done, {}), ("204", done, known), ("404", NOBODY, {}), ("410", gone, {})],
    "cancelJob": [("404", NOBODY, {}), ("410", gone, {})],
    "getImage": [("200", done, {}), ("404", measured, {}), ("200", done + "?format=pfm", {}), ("200", done + "?max_edge=64", {}),
                 ("206", done, {"Range": "bytes=0-9"}), ("304", done, everything),
                 ("400", done + "?format=gif", {}), ("404", done + "?view=x", {}),
                 ("404", done + "?view=" + "%C3%BC" * 200, {}), ("400", done + "?view=" + "x" * 201, {}),
                 ("404", done + "?layer=depth", {}), ("404", NOBODY, {}), ("409", busy, {}), ("410", gone, {}),
                 ("416", done, {"Range": "bytes=9999999-"})],
    "compareJobs": [("200", f"{done}?with={done}", {}), ("200", f"{done}?with={done}&format=png", {}),
                    ("304", f"{done}?with={done}", everything), ("400", done, {}), ("404", f"{done}?with={NOBODY}", {}),
                    ("409", f"{done}?with={busy}", {}), ("410", f"{done}?with={gone}", {})],
    "getPreview": [("200", done, {}), ("200", busy, {}), ("304", done, everything),
                   ("400", done + "?x", {}), ("404", NOBODY, {}), ("404", done + "?view=x", {}), ("410", gone, {})],
    "getStatistics": [("200", done, {}), ("200", busy + "?so_far=true", {}), ("400", done + "?so_far=1", {}), ("200", measured, {}), ("200", unrendered, {}), ("304", done, everything), ("404", NOBODY, {}),
                      ("409", busy, {}), ("200", kept, {}), ("410", gone, {})],
    "getReport": [("200", billed, {}), ("200", billed, {"Accept": "application/json"}),
                  ("200", billed, {"Accept": "text/csv"}), ("200", measured, {}), ("200", measured, {"Accept": "application/json"}),
                  ("200", measured, {"Accept": "text/csv"}),
                  ("200", measured, {"Accept": "text/markdown;q=0.5, image/*"}),
                  ("304", measured, everything), ("404", NOBODY, {}), ("404", done, {}),
                  ("406", measured, {"Accept": "image/png"}), ("409", late, {}), ("410", gone, {})],
    "getScene": [("200", done, {}), ("200", submit(XML), {}), ("304", done, everything),
                 ("404", NOBODY, {}), ("410", gone, {})],
    "validate": [("200", "", {"body": SMALL}), ("200", "", {"body": XML}), *body_samples],
    "explain": [("200", "", {"body": SMALL}), ("200", "", {"body": '{"analyze": true, ' + SMALL[1:]}),
                *body_samples,
                ("504", "", {"body": '{"analyze": true, "priority": 9, "timeout_seconds": 0.1, ' + LONG[1:]}),
                ("202", "", {"body": '{"analyze": true, ' + LONG[1:]})],  # last: it keeps the worker
    "listScenes": [("200", "", {}), ("400", "?x", {}), ("304", "", everything)],
    "getBuiltinScene": [("200", "spheres", {}), ("304", "spheres", everything), ("404", "x", {})],
    "listWorkers": [("200", "", {}), ("400", "?x", {})],
    "page": [("200", "", {}), ("400", "?x", {}), ("304", "", everything)],
    "pageFile": [("200", "app.js", {}), ("304", "index.html", everything), ("404", "x", {})],
    "health": [("200", "", {}), ("400", "?x", {})],
    "readiness": [("200", "", {}), ("400", "?x", {})],
    "metrics": [("200", "", {}), ("400", "?x", {})],
    "definition": [("200", "", {}), ("400", "?x", {}), ("304", "", everything)],
    "sceneSchema": [("200", "", {}), ("400", "?x", {}), ("304", "", everything)],
    "deleteJob": [("204", gone + "?stats=true", {}), ("410", gone, {}), ("204", kept, {}), ("400", busy + "?stats=1", {}),
                  ("404", NOBODY, {}), ("409", busy, {})],
}
samples["cancelJob"].append(("202", busy, {}))
order = ["deleteJob", "getReport", "getImage", "compareJobs", "getStatistics", "getPreview", "getJob"]  # while `busy` is busy
operations = {}
for path, item in definition["paths"].items():
    for method in ("get", "post", "delete", "put"):
        if method in item:
            operations[item[method]["operationId"]] = (method.upper(), path, item[method])
for name in sorted(operations, key=lambda n: order.index(n) if n in order else len(order)):
    method, path, operation = operations[name]
    rows = samples.get(name, [])
    if name == "explain":
        wait_for_all()  # `busy` is cancelled; an explanation that waits for others is answered 202
    for status, argument, request in rows:
        argument, _, query = argument.partition("?")
        where = path.replace("{id}", argument).replace("{name}", argument)
        if "{" not in path:
            where += argument
        answer = ask(method, where + ("?" + query if query else ""), **request)
        check(f"{name} {status} {query}", judge(operation, status, answer))
    unseen = set(operation["responses"]) - {row[0] for row in rows} - NEEDS_FAULT
    unseen -= {status for operation_id, status in NOT_SAMPLED if operation_id == name}
    check(f"{name} all statuses", f"not sampled: {sorted(unseen)}" if unseen else None)
