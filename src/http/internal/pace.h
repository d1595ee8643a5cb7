/* SPDX-License-Identifier: MIT */
/* When the acceptor accepts connections, and how many at once. Where more than 4000 come in a
 * second it pays to let several come: to wake the acceptor and a loop takes longer than to accept
 * and to answer. But clients that each wait for their answer before they connect again come no
 * faster than the pauses let them. So pauses are as long as it takes to gather some twenty
 * connections, 0.5 to 2 ms; where fewer than 8000 come in a second in spite of that, they are short
 * for a second; and where even short ones gather nothing, since few clients send one request after
 * the other, there are none for a second. After a full burst there is none either, since more are
 * waiting.
 *
 * Threads: one. */
#ifndef PEN_HTTP_INTERNAL_PACE_H
#define PEN_HTTP_INTERNAL_PACE_H

#include <stdbool.h>
#include <stdint.h>

enum {
    PACE_BURST = 32, /* connections accepted at once, so that a loop is woken for the first soon */
    PACE_ARRIVING = 64 /* accepted ones that the loops have not looked at: with so many, others wait
                        * in the kernel */
};

/* All zero: nothing was counted yet. */
struct pace {
    int64_t begun_ns;       /* of the window over which connections are counted */
    int accepted, wakes;    /* connections in it, and bursts of them */
    int burst;              /* connections of the last one */
    int64_t pause_ns;       /* before each of them; 0: none */
    int64_t none_until_ns;  /* no pauses before that time */
    int64_t short_until_ns; /* none but short ones */
    bool rush;              /* in the last window they came fast: more than 4000 in a second */
};

/* How many nanoseconds the acceptor is to wait now (pen_clock_ns), whatever comes; 0: until a
 * connection comes. arriving: accepted ones that the loops have not looked at. */
int64_t pen_http_pace_wait(struct pace *pace, int64_t now_ns, int arriving);

/* Counts a burst of so many connections. */
void pen_http_pace_count(struct pace *pace, int accepted);

#endif
