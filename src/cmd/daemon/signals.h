/* SPDX-License-Identifier: MIT */
/* The signals that end the daemon's processes or have them read their configuration again: SIGTERM,
 * SIGINT, SIGHUP. They are blocked and read from a descriptor. */
#ifndef PEN_CMD_DAEMON_SIGNALS_H
#define PEN_CMD_DAEMON_SIGNALS_H

/* Keeps these signals pending until pen_signals_open, so that a SIGTERM drains the daemon as soon
 * as it has said that it listens. */
void pen_signals_hold(void);

/* The same, and blocks no other signals any more: so the supervisor starts its children. There is
 * no moment in which one of these signals ends the process. */
void pen_signals_hold_alone(void);

/* Blocks these signals, and signal `also` unless it is 0, in the calling thread, and ignores
 * SIGPIPE. Returns a descriptor to read them from (signalfd(2)). Owns: the caller closes it. Fails:
 * returns -1 with errno. */
int pen_signals_open(int also);

#endif
