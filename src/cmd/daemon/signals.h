/* SPDX-License-Identifier: MIT */
/* The signals that end the daemon or have it read its configuration again: SIGTERM, SIGINT, SIGHUP.
 * The supervisor blocks them and reads them from a descriptor; its children have them blocked. */
#ifndef PEN_CMD_DAEMON_SIGNALS_H
#define PEN_CMD_DAEMON_SIGNALS_H

/* Keeps these signals pending until pen_signals_open, so that a SIGTERM drains the daemon from the
 * moment on when it begins to change anything. */
void pen_signals_hold(void);

/* The same, and blocks no other signals any more: so the supervisor starts its children, for whom
 * it stays so. There is no moment in which one of these signals ends the process. */
void pen_signals_hold_alone(void);

/* Blocks these signals and SIGCHLD in the calling thread, and ignores SIGPIPE, which programs that
 * it starts then do, too. Returns a descriptor to read them from (signalfd(2)). Owns: the caller
 * closes it. Fails: returns -1 with errno. */
int pen_signals_open(void);

#endif
