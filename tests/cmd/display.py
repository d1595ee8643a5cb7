# SPDX-License-Identifier: MIT
"""Runs a command on a terminal of its own: display.py COLUMNS SECONDS KEYS COMMAND….

Presses KEYS as soon as the command has printed something, or KEYS of TIME@KEYS so many seconds after its
start; prints what the command printed. Ends with its exit code, with 128 and the signal that ended it, or
with 99 if it has not ended in time.
"""
import fcntl
import os
import pty
import select
import signal
import struct
import sys
import termios
import time

columns, seconds, command = int(sys.argv[1]), float(sys.argv[2]), sys.argv[4:]
press_after, at, keys = sys.argv[3].rpartition("@")
pid, terminal = pty.fork()
if pid == 0:
    # A shell in the background ignores these, and so would the command.
    for number in signal.SIGINT, signal.SIGQUIT:
        signal.signal(number, signal.SIG_DFL)
    fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    os.execvp(command[0], command)
start = time.monotonic()
end = start + seconds
text, code = b"", None
while code is None and time.monotonic() < end:
    if select.select([terminal], [], [], 0.05)[0]:
        try:
            text += os.read(terminal, 65536)
        except OSError:  # the command has closed the terminal
            pass
    if keys and (time.monotonic() >= start + float(press_after) if at else text):
        os.write(terminal, keys.encode())
        keys = ""
    done, status = os.waitpid(pid, os.WNOHANG)
    if done:
        code = os.waitstatus_to_exitcode(status)
        while select.select([terminal], [], [], 0)[0]:
            try:
                text += os.read(terminal, 65536)
            except OSError:
                break
if code is None:
    os.kill(pid, signal.SIGKILL)
    code = 99
sys.stdout.write(text.decode(errors="replace").replace("\r\n", "\n"))
if code == 0 and termios.tcgetattr(terminal)[3] & termios.ECHO == 0:
    sys.stdout.write("the terminal shows no keys any more\n")
    code = 98
sys.exit(code if code >= 0 else 128 - code)
