# SPDX-License-Identifier: MIT
"""Three hundred event streams of one running job: events.py URL JOB-PATH API-PID HANG TIMED, where HANG is when to give up, in s, and TIMED is
empty if times are not judged.

Half of the listeners close their connections, every second one with a reset, while plain GETs are
timed. The others receive events until the job ends. The api process then has as many descriptors and
threads as before.
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
job, api, hang, timed = sys.argv[2], int(sys.argv[3]), int(sys.argv[4]), sys.argv[5]


def check(name, wrong):
    """wrong: what is wrong, or None."""
    print(f"not ok {name}: {wrong}" if wrong else f"ok {name}")


def descriptors():
    return len(os.listdir(f"/proc/{api}/fd"))


def process_status(field):
    with open(f"/proc/{api}/status", encoding="ascii") as file:
        return next(int(line.split()[1]) for line in file if line.startswith(field + ":"))


class Listener:
    def __init__(self):
        self.socket = socket.create_connection((url.hostname, url.port))
        self.socket.sendall(f"GET {job}/events HTTP/1.0\r\nHost: localhost\r\n\r\n".encode())
        self.text = b""
        self.ended = False

    def receive(self):
        part = self.socket.recv(1 << 16)
        self.text += part
        self.ended = not part

    def close(self, reset):
        if reset:
            self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        self.socket.close()

    def count(self, event):
        return self.text.count(b"event: " + event)


def receive_until(listeners, done, seconds=hang):
    """Receives until `done` is true for all listeners. Returns whether it is, in so many seconds."""
    until = time.monotonic() + seconds
    while not all(done(one) for one in listeners):
        waiting = {one.socket: one for one in listeners if not one.ended}
        if time.monotonic() > until or not waiting:
            return False
        for readable in select.select(list(waiting), [], [], 0.2)[0]:
            waiting[readable].receive()
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


plain = http.client.HTTPConnection(url.hostname, url.port, timeout=hang)
time_gets(plain, [job, "/v1/jobs", "/healthz"], 30)  # also makes threads allocate what they keep
files, threads, memory = descriptors(), process_status("Threads"), process_status("VmRSS")

listeners = [Listener() for _ in range(LISTENERS)]
check("every-listener-gets-the-state", None if receive_until(listeners, lambda e: e.count(b"state") > 0) else "no")
check("streams-need-no-more-threads", None if process_status("Threads") == threads else process_status("Threads"))
leaving, staying = listeners[::2], listeners[1::2]
for i, listener in enumerate(leaving):
    listener.close(reset=i % 2)
plain.close()  # perhaps idle for longer than the daemon keeps a connection
times = time_gets(plain, [job, "/v1/jobs?limit=5", "/healthz"], 300)
most = sorted(times)[296]  # a few may meet a moment in which the machine does something else
print(f"plain GETs while 150 of 300 streams are closed: median {statistics.median(times):.2f} ms, "
      f"99 % {most:.2f} ms, largest {max(times):.2f} ms")
if timed:
    check("plain-gets-are-answered", None if most < 2000 else f"{most:.0f} ms")

before = [one.count(b"progress") for one in staying]
check("the-others-get-further-events", None if receive_until(
    staying, lambda e: e.count(b"progress") > before[0] + 3 and e.count(b"tile") > 0) else "no")
until = time.monotonic() + hang
while descriptors() > files + len(staying) and time.monotonic() < until:
    receive_until(staying, lambda e: False, 0.2)
check("closed-streams-free-descriptors", None if descriptors() <= files + len(staying) else descriptors())

plain.close()  # perhaps idle as long again
plain.request("POST", job + "/cancel")
plain.getresponse().read()
check("every-stream-ends-with-the-job", None if receive_until(staying, lambda e: e.ended) else "no")
last = {one.text.rstrip().rsplit(b"event: ", 1)[1][:5] for one in staying}
cancelled = all(b'"state":"cancelled"' in one.text[-3000:] for one in staying)
check("the-last-event-is-the-state", None if last == {b"state"} and cancelled else last)
for listener in staying:
    listener.socket.close()
until = time.monotonic() + hang
while descriptors() > files and time.monotonic() < until:
    time.sleep(0.1)
check("no-descriptor-is-left", None if descriptors() <= files else f"{files} to {descriptors()}")
grown = process_status("VmRSS") - memory
print(f"resident: {memory} KiB before, {grown} KiB more after")
with open(f"/proc/{api}/maps", encoding="utf-8") as maps:
    text = maps.read()
    sanitized = "libasan" in text or "libtsan" in text  # a sanitizer keeps freed memory
check("little-memory-is-left", None if grown < 16384 or sanitized else f"{grown} KiB")
