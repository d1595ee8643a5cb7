# SPDX-License-Identifier: MIT
"""Three hundred listeners on one running job: events.py URL JOB-PATH API-PID.

Half of them vanish, some politely and some not, while plain GETs are timed. The others hear the
job to its end, and the api process is left with as many descriptors and threads as before.
"""
import http.client
import os
import select
import socket
import statistics
import struct
import sys
import time
import urllib.parse

LISTENERS = 300
url = urllib.parse.urlsplit(sys.argv[1])
job, api = sys.argv[2], int(sys.argv[3])


def check(name, wrong):
    print(f"not ok {name}: {wrong}" if wrong else f"ok {name}")


def descriptors():
    return len(os.listdir(f"/proc/{api}/fd"))


def of_process(field):
    with open(f"/proc/{api}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(field + ":"))


class Listener:
    def __init__(self):
        self.socket = socket.create_connection((url.hostname, url.port))
        self.socket.sendall(f"GET {job}/events HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
        self.text = b""
        self.ended = False

    def hear(self):
        part = self.socket.recv(1 << 16)
        self.text += part
        self.ended = not part

    def vanish(self, rudely):
        if rudely:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.socket.close()

    def count(self, event):
        return self.text.count(b"event: " + event)


def hear_until(listeners, done, seconds):
    """Reads what comes; whether `done` became true of all in time."""
    until = time.monotonic() + seconds
    while not all(done(one) for one in listeners):
        waiting = {one.socket: one for one in listeners if not one.ended}
        if time.monotonic() > until or not waiting:
            return False
        for readable in select.select(list(waiting), [], [], 0.2)[0]:
            waiting[readable].hear()
    return True


def time_gets(connection, paths, rounds):
    times = []
    for i in range(rounds):
        begun = time.monotonic()
        connection.request("GET", paths[i % len(paths)])
        answer = connection.getresponse()
        answer.read()
        times.append(1000 * (time.monotonic() - begun))
        if answer.status != 200:
            check("plain-get", f"{paths[i % len(paths)]}: {answer.status}")
        time.sleep(0.002)
    return times


plain = http.client.HTTPConnection(url.hostname, url.port, timeout=30)
time_gets(plain, [job, "/v1/jobs", "/healthz"], 30)  # also has threads make what they need
files, threads, memory = descriptors(), of_process("Threads"), of_process("VmRSS")

ears = [Listener() for _ in range(LISTENERS)]
check("all-hear-the-state", None if hear_until(ears, lambda e: e.count(b"state") > 0, 30) else "no")
check("a-thread-serves-many", None if of_process("Threads") == threads else of_process("Threads"))
leaving, staying = ears[::2], ears[1::2]
for i, ear in enumerate(leaving):
    ear.vanish(rudely=i % 2)
times = time_gets(plain, [job, "/v1/jobs?limit=5", "/healthz"], 300)
print(f"plain GETs while 150 of 300 streams vanish: median {statistics.median(times):.2f} ms, "
      f"99 % {sorted(times)[296]:.2f} ms, largest {max(times):.2f} ms")
check("plain-gets-are-answered", None if max(times) < 2000 else f"{max(times):.0f} ms")

heard = [one.count(b"progress") for one in staying]
check("the-others-hear-on", None if hear_until(
    staying, lambda e: e.count(b"progress") > heard[0] + 3 and e.count(b"tile") > 0, 60) else "no")
until = time.monotonic() + 30
while descriptors() > files + len(staying) and time.monotonic() < until:
    hear_until(staying, lambda e: False, 0.2)
check("vanished-are-let-go", None if descriptors() <= files + len(staying) else descriptors())

plain.close()  # idle by now for longer, perhaps, than the daemon waits
plain.request("POST", job + "/cancel")
plain.getresponse().read()
check("all-hear-the-end", None if hear_until(staying, lambda e: e.ended, 30) else "no")
last = {one.text.rstrip().rsplit(b"event: ", 1)[1][:5] for one in staying}
cancelled = all(b'"state":"cancelled"' in one.text[-3000:] for one in staying)
check("the-end-is-a-state", None if last == {b"state"} and cancelled else last)
for ear in staying:
    ear.socket.close()
until = time.monotonic() + 30
while descriptors() > files and time.monotonic() < until:
    time.sleep(0.1)
check("no-descriptor-is-left", None if descriptors() <= files else f"{files} to {descriptors()}")
grown = of_process("VmRSS") - memory
print(f"resident: {memory} KiB before, {grown} KiB more after")
with open(f"/proc/{api}/maps", encoding="utf-8") as maps:
    text = maps.read()
    sanitized = "libasan" in text or "libtsan" in text  # which keep what was freed
check("little-memory-is-left", None if grown < 16384 or sanitized else f"{grown} KiB")
