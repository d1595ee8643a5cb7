# SPDX-License-Identifier: MIT
"""Runs a command on a terminal of its own: display.py COLUMNS SECONDS KEYS COMMAND….

Presses KEYS as soon as the command has printed something, and prints what it printed. Ends with the
command's exit code, 128 and the signal that ended it, or 99 if it has not ended in time.
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

columns, seconds, keys, command = int(sys.argv[1]), float(sys.argv[2]), sys.argv[3], sys.argv[4:]
pid, terminal = pty.fork()
if pid == 0:
    fcntl.ioctl(0, termios.TIOCSWINSZ, struct.pack("HHHH", 50, columns, 0, 0))
    os.execvp(command[0], command)
end = time.monotonic() + seconds
text, code = b"", None
while code is None and time.monotonic() < end:
    if select.select([terminal], [], [], 0.05)[0]:
        try:
            text += os.read(terminal, 65536)
        except OSError:  # the command has closed the terminal
            pass
    if text and keys:
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
