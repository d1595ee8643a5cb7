/* SPDX-License-Identifier: MIT */
/* Single keys of a terminal, for a display that is redrawn until the user ends it. */
#ifndef PEN_CMD_CLIENT_KEYS_H
#define PEN_CMD_CLIENT_KEYS_H

#include <signal.h>
#include <stdbool.h>
#include <termios.h>

enum { PEN_KEYS_SIGNALS = 3 };

struct pen_keys {
    bool on; /* standard input is a terminal, and this process is in its foreground */
    struct termios before;
    struct sigaction actions_before[PEN_KEYS_SIGNALS];
    sigset_t mask_before;
};

/* Begins to read keys without waiting for a line and without showing them. From now on, signals of
 * the terminal (Ctrl-C) and SIGTERM end pen_keys_wait instead of the process. */
void pen_keys_begin(struct pen_keys *keys);

/* Waits for some milliseconds. Returns false as soon as q is pressed or such a signal arrives. */
bool pen_keys_wait(const struct pen_keys *keys, int milliseconds);

/* Restores the terminal. If a signal has arrived, ends the process as the signal would have. */
void pen_keys_end(struct pen_keys *keys);

#endif
