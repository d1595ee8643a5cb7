/* SPDX-License-Identifier: MIT */
/* The signals that end the daemon or make it read its configuration again: SIGTERM, SIGINT, SIGHUP.
 * The supervisor blocks them and reads them from a descriptor. In its children they stay
 * blocked. */
#ifndef PEN_CMD_DAEMON_SIGNALS_H
#define PEN_CMD_DAEMON_SIGNALS_H

/* Keeps these signals pending until pen_signals_open. So from the moment the daemon begins to
 * change anything, a SIGTERM drains it. */
void pen_signals_hold(void);

/* Keeps these signals pending and unblocks all others. The supervisor starts its children in this
 * state, which they keep. So none of these signals ends a process at any moment. */
void pen_signals_hold_alone(void);

/* Blocks these signals and SIGCHLD in the calling thread. Ignores SIGPIPE, and programs that it
 * starts inherit this. Returns a descriptor to read the signals from (signalfd(2)).
 * Owns: the caller closes it.
 * Fails: -1 with errno. */
int pen_signals_open(void);

#endif
