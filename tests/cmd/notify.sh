#!/bin/sh
# SPDX-License-Identifier: MIT
# The supervisor's messages to a service manager: it is ready, its processes answer, it stops.
. "$(dirname "$0")/lib.sh"
python3 - "$build/penumbrad" "$work" >"$work/result" 2>"$work/errors" <<'END'
import os, signal, socket, subprocess, sys, time

penumbrad, work = sys.argv[1:]
WAIT = 60


def start(address, name):
    manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
    manager.bind(address)
    manager.settimeout(WAIT)
    env = dict(os.environ, NOTIFY_SOCKET=name, WATCHDOG_USEC='600000')
    env.pop('WATCHDOG_PID', None)
    daemon = subprocess.Popen([penumbrad, '--listen', '127.0.0.1:0', '--threads', '1', '--store',
                               work + '/store.db'], env=env, stdout=subprocess.DEVNULL,
                              stderr=open(work + '/log', 'a'))
    return manager, daemon


def child(daemon, name):
    out = subprocess.run(['pgrep', '-P', str(daemon.pid), name], capture_output=True, text=True)
    return int(out.stdout.split()[0])


def cease(manager):
    """Whether 2 s pass without a message. Before that there may be some, of answers that came earlier."""
    end = time.monotonic() + WAIT
    manager.settimeout(2)
    silent = False
    while not silent and time.monotonic() < end:
        try:
            manager.recv(1000)
        except socket.timeout:
            silent = True
    manager.settimeout(WAIT)
    return silent


manager, daemon = start(work + '/notify', work + '/notify')
print('first', manager.recv(1000).decode())
print('then', manager.recv(1000).decode(), manager.recv(1000).decode())
for name in 'penumbrad-work', 'penumbrad-api':
    pid = child(daemon, name)
    os.kill(pid, signal.SIGSTOP)
    print('stopped', name, 'silent' if cease(manager) else 'goes on')
    os.kill(pid, signal.SIGCONT)
    print('continued', name, manager.recv(1000).decode())
daemon.send_signal(signal.SIGTERM)
last = ''
while last != 'STOPPING=1':
    last = manager.recv(1000).decode()
print('last', last)
print('exit', daemon.wait(WAIT))
manager.close()

manager, daemon = start('\0penumbra-test-%d' % os.getpid(), '@penumbra-test-%d' % os.getpid())
print('abstract', manager.recv(1000).decode())
daemon.terminate()
daemon.wait(WAIT)
END
cat >"$work/expected" <<'END'
first READY=1
then WATCHDOG=1 WATCHDOG=1
stopped penumbrad-work silent
continued penumbrad-work WATCHDOG=1
stopped penumbrad-api silent
continued penumbrad-api WATCHDOG=1
last STOPPING=1
exit 0
abstract READY=1
END
expect "messages to a service manager" "$(cat "$work/result" "$work/errors")" "$(cat "$work/expected")"
finish
