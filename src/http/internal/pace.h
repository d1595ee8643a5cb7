/* SPDX-License-Identifier: MIT */
/* How long to wait before accepting connections. Where more than 4000 come in a second it pays to
 * let several come: to wake the acceptor and a loop takes longer than to accept and to answer. But
 * clients that each wait for their answer before they connect again come no faster than the pauses
 * let them. So pauses are as long as it takes to gather some twenty connections, 0.5 to 2 ms; where
 * fewer than 8000 come in a second in spite of that, they are short for a second; and where even
 * short ones gather nothing, since few clients send one request after the other, there are none for
 * a second.
 *
 * Threads: one. */
#ifndef PEN_HTTP_INTERNAL_PACE_H
#define PEN_HTTP_INTERNAL_PACE_H

#include <stdbool.h>
#include <stdint.h>

/* All zero: nothing was counted yet. */
struct pace {
    int64_t begun_ns;       /* of the window over which connections are counted */
    int accepted, wakes;    /* connections in it, and wakes of the acceptor that found some */
    int64_t pause_ns;       /* before each of them; 0: none */
    int64_t none_until_ns;  /* no pauses before that time */
    int64_t short_until_ns; /* none but short ones */
    bool rush;              /* in the last window they came fast: more than 4000 in a second */
};

/* How many nanoseconds the acceptor is to wait for more connections, now (pen_clock_ns) and where
 * it has just found some; 0: until the next one comes. */
int64_t pen_http_pace_pause(struct pace *pace, int64_t now_ns);

/* The acceptor has woken and accepted so many. */
void pen_http_pace_count(struct pace *pace, int accepted);

#endif
