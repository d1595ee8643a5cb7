/* SPDX-License-Identifier: MIT */
/* A progress bar with the time left, in one line of standard error, redrawn at most ten times a
 * second. It prints only on a terminal. */
#ifndef PEN_CMD_CLIENT_PROGRESS_H
#define PEN_CMD_CLIENT_PROGRESS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct pen_progress {
    bool on;
    int64_t start_ns, drawn_ns; /* drawn_ns: the last redraw; 0: none */
    char label[64];
};

/* Begins a bar. It is on only if standard error is a terminal and `quiet` is false. */
void pen_progress_begin(struct pen_progress *progress, const char *label, bool quiet);

/* Shows a fraction in 0…1. eta_seconds is the time left. If it is negative, the bar estimates it
 * from the time spent so far. */
void pen_progress_show(struct pen_progress *progress, double fraction, double eta_seconds);

/* Shows a note instead of the bar ("queued", "the daemon does not answer, trying again"). */
void pen_progress_note(struct pen_progress *progress, const char *note);

/* Clears the line. */
void pen_progress_end(struct pen_progress *progress);

/* Writes a duration: "1:05", "2:00:03". */
void pen_progress_time(double seconds, char out[16]);

/* Writes a count in about three digits: "950", "6.8 M". */
void pen_progress_count(double count, char out[16]);

/* Writes a bar of at most `columns` columns, such as "room [#####     ]  50 %  0:10 left". It
 * leaves out label and bar if there is no space for them. */
void pen_progress_text(const char *label, double fraction, double eta_seconds, int columns,
                       char *out, size_t bytes);

#endif
