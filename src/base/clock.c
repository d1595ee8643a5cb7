/* SPDX-License-Identifier: MIT */
/* Reads the clocks of the system, and formats time stamps. */
#include "base/clock.h"

#include <inttypes.h>
#include <pthread.h>
#include <stdio.h>
#include <time.h>

static int64_t read_ns(clockid_t id)
{
    struct timespec t = {0};
    clock_gettime(id, &t);
    return (int64_t)t.tv_sec * 1000000000 + t.tv_nsec;
}

int64_t pen_clock_ns(void)
{
    return read_ns(CLOCK_MONOTONIC);
}

int64_t pen_clock_cpu_ns(void)
{
    return read_ns(CLOCK_PROCESS_CPUTIME_ID);
}

int64_t pen_clock_thread_ns(void)
{
    return read_ns(CLOCK_THREAD_CPUTIME_ID);
}

int64_t pen_clock_wall_ms(void)
{
    struct timespec t = {0}; /* in nanoseconds, times after the year 2262 would not fit */
    clock_gettime(CLOCK_REALTIME, &t);
    return (int64_t)t.tv_sec * 1000 + t.tv_nsec / 1000000;
}

static int64_t boot; /* written once, by read_boot */

/* Half of the 128 random bits of the boot's id. */
static void read_boot(void)
{
    FILE *file = fopen("/proc/sys/kernel/random/boot_id", "re");
    uint64_t high = 0, low = 0;
    if (file && fscanf(file, "%8" SCNx64 "-%4" SCNx64, &high, &low) == 2)
        boot = (int64_t)(high << 16 | low);
    if (file)
        fclose(file);
}

struct pen_moment pen_clock_moment(void)
{
    static pthread_once_t once = PTHREAD_ONCE_INIT;
    pthread_once(&once, read_boot);
    return (struct pen_moment){.boot = boot, .us = read_ns(CLOCK_BOOTTIME) / 1000};
}

int64_t pen_clock_between(int64_t begun_ns, int64_t end_ns, double fraction)
{
    /* The distance, rounded to a double, may be too long. */
    return fraction >= 1 ? end_ns : begun_ns + (int64_t)(fraction * (double)(end_ns - begun_ns));
}

struct timespec pen_clock_after_ms(int64_t ms)
{
    const int64_t ns = pen_clock_ns() + ms * 1000000;
    return (struct timespec){.tv_sec = (time_t)(ns / 1000000000),
                             .tv_nsec = (long)(ns % 1000000000)};
}

void pen_clock_format(int64_t wall_ms, char out[25])
{
    /* Years 0 to 9999 have four digits; a stored time outside them is damaged. */
    const int64_t first = -62167219200000, last = 253402300799999;
    int64_t ms = wall_ms < first ? first : wall_ms > last ? last : wall_ms;
    int64_t rest = ((ms % 1000) + 1000) % 1000;
    time_t seconds = (time_t)((ms - rest) / 1000);
    struct tm t = {0};
    gmtime_r(&seconds, &t);
    char text[80];
    snprintf(text, sizeof text, "%04d-%02d-%02dT%02d:%02d:%02d.%03dZ", t.tm_year + 1900,
             t.tm_mon + 1, t.tm_mday, t.tm_hour, t.tm_min, t.tm_sec, (int)rest);
    snprintf(out, 25, "%.24s", text);
}
