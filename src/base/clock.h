/* SPDX-License-Identifier: MIT */
/* Clocks. The monotonic clock measures durations; the wall clock gives time stamps. */
#ifndef PEN_BASE_CLOCK_H
#define PEN_BASE_CLOCK_H

#include <stdint.h>
#include <time.h>

/* The monotonic clock.
 * Units: ns since an arbitrary start; never goes back. */
int64_t pen_clock_ns(void);

/* The processor time of all threads of this process.
 * Units: ns. */
int64_t pen_clock_cpu_ns(void);

/* The wall clock.
 * Units: ms since 1970-01-01 UTC. */
int64_t pen_clock_wall_ms(void);

/* A moment, for durations that may outlast a process. Within one boot they are measured by a clock
 * that cannot be set and that continues while the machine sleeps.
 * Units: us since the boot. */
struct pen_moment {
    int64_t boot; /* identifies a boot of a machine; 0: not known, so not comparable */
    int64_t us;
};
struct pen_moment pen_clock_moment(void);

/* The time at which this fraction, 0 to 1, of the time between a begin and a later end has passed.
 * With fraction 1 it is exactly the end. */
int64_t pen_clock_between(int64_t begun_ns, int64_t end_ns, double fraction);

/* The time on the monotonic clock (CLOCK_MONOTONIC) in `ms` milliseconds, for waiting until then.
 */
struct timespec pen_clock_after_ms(int64_t ms);

/* Writes wall time in the format of RFC 3339, in UTC with milliseconds: "2026-01-31T12:00:00.000Z".
 * Years before 0 and after 9999 are clamped. */
void pen_clock_format(int64_t wall_ms, char out[25]);

/* The processor time of the calling thread.
 * Units: ns. */
int64_t pen_clock_thread_ns(void);

#endif
