# SPDX-License-Identifier: MIT
"""Two thousand clients whose requests have heads of 31 KB: heads.py PORT API-PID PATIENCE.

First they do not read their answers, then they do not send their bodies. Prints how much the api
process has grown, in KiB: meanwhile, and when they have closed.
"""
import socket
import sys
import time

CLIENTS = 2000
PAD = 31000
port, api, patience = (int(text) for text in sys.argv[1:])


def resident_kib():
    with open(f"/proc/{api}/status") as status:
        return next(int(line.split()[1]) for line in status if line.startswith("VmRSS:"))


def crowd(line, fields):
    """Sends the request on as many connections. Returns them."""
    request = f"{line}?{'&' * PAD} HTTP/1.1\r\nHost: localhost\r\n{fields}\r\n".encode()
    connections = []
    for _ in range(CLIENTS):
        connection = socket.socket()
        connection.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
        connection.connect(("127.0.0.1", port))
        connection.sendall(request)
        connections.append(connection)
    return connections


def growth(before, enough, seconds):
    """The growth since `before`, once it is as little as `enough`; else the least of so many seconds:
    a daemon that is halted answers, or returns memory, later."""
    least = resident_kib() - before
    end = time.monotonic() + seconds * patience
    while time.monotonic() < end and least > enough:
        time.sleep(0.1)
        least = min(least, resident_kib() - before)
    return least


def measure(name, line, fields, enough):
    before = resident_kib()
    connections = crowd(line, fields)
    time.sleep(1)
    print(f"{name}-kib {growth(before, enough, 10)}")
    for connection in connections:
        connection.close()
    print(f"{name}-closed-kib {growth(before, 2048, 25)}")


measure("unread", "GET /openapi.yaml", "", 16000)
measure("unsent", "POST /v1/jobs", "Content-Length: 100\r\n", 98000)
