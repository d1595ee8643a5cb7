/* SPDX-License-Identifier: MIT */
#include "http/internal/pace.h"

enum {
    WINDOW_NS = 50000000,
    RUSH_EVERY_NS = 250000, /* 4000 connections in a second */
    SHORT_NS = 500000,      /* the shortest pause */
    SHORT_GATHERS = 3,      /* connections at each wake: with fewer, pauses are of no use */
    LONGEST_NS = 2000000,
    GATHERS = 20,
    LONG_EVERY_NS = 125000, /* 8000 connections in a second come through longer pauses */
    AGAIN_NS = 1000000000,  /* until a longer pause is tried again */
    BEHIND_NS = 500000      /* for the loops, to look at what they were given */
};

/* Notes which pauses were of no use in the window that ends now. */
static void judge(struct pace *pace, int64_t now_ns)
{
    const int64_t passed_ns = now_ns - pace->begun_ns;
    if (pace->pause_ns > 0 && pace->accepted < SHORT_GATHERS * pace->wakes)
        pace->none_until_ns = now_ns + AGAIN_NS;
    if (pace->pause_ns > SHORT_NS && pace->accepted < passed_ns / LONG_EVERY_NS)
        pace->short_until_ns = now_ns + AGAIN_NS;
}

/* The next pause where connections come fast. */
static int64_t next_pause(const struct pace *pace, int64_t now_ns)
{
    if (now_ns < pace->none_until_ns)
        return 0;
    if (now_ns < pace->short_until_ns || pace->pause_ns == 0)
        return SHORT_NS;
    const bool gathered = pace->accepted > GATHERS * pace->wakes;
    const int64_t pause_ns = gathered ? pace->pause_ns / 4 * 3 : pace->pause_ns / 2 * 3;
    return pause_ns < SHORT_NS ? SHORT_NS : pause_ns < LONGEST_NS ? pause_ns : LONGEST_NS;
}

/* Where a window has passed, sets the pauses of the next one. */
static void turn_window(struct pace *pace, int64_t now_ns)
{
    const int64_t passed_ns = now_ns - pace->begun_ns;
    if (passed_ns < WINDOW_NS)
        return;
    judge(pace, now_ns);
    pace->rush = pace->accepted > passed_ns / RUSH_EVERY_NS;
    pace->pause_ns = pace->rush ? next_pause(pace, now_ns) : 0;
    pace->begun_ns = now_ns;
    pace->accepted = pace->wakes = 0;
}

int64_t pen_http_pace_wait(struct pace *pace, int64_t now_ns, int arriving)
{
    turn_window(pace, now_ns);
    if (arriving >= PACE_ARRIVING)
        return BEHIND_NS;
    /* Where some have come and more will, a pause ends by itself: that spares a wake. */
    return pace->burst > 0 && pace->burst < PACE_BURST ? pace->pause_ns : 0;
}

void pen_http_pace_count(struct pace *pace, int accepted)
{
    pace->burst = accepted;
    pace->accepted += accepted;
    pace->wakes += accepted > 0;
}
