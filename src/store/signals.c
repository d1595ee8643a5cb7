/* SPDX-License-Identifier: MIT */
/* Signals between the processes of one host that use a store, and between their threads. Each
 * process has an eventfd. The supervisor makes all of them before its first child, so that they
 * stay when a child is restarted. A signal writes to all of them. A process without them (a command
 * beside the daemon) looks every 250 ms in a wait. All stores of a process share them. */
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include "base/clock.h"
#include "store/internal/signals.h"
#include "store/store.h"

enum {
    SLOTS_MAX = 64,
    LOOK_MS = 250 /* between two looks of a process that has no eventfd */
};

/* Environment variables for children: the numbers of the eventfds, with commas, and the place of
 * the process's own. */
static const char FDS[] = "PENUMBRA_SIGNALS", SLOT[] = "PENUMBRA_SIGNAL_SLOT";

/* open_own writes it once; `changes` grows. */
static struct {
    int fd[SLOTS_MAX], count;
    int own;        /* -1: none can be made */
    bool is_shared; /* others write it */
    atomic_uint changes;
} signals = {.own = -1};
static pthread_once_t once = PTHREAD_ONCE_INIT;

static void read_slots(void)
{
    const char *text = getenv(FDS), *slot = getenv(SLOT);
    char *end;
    for (; text && *text && signals.count < SLOTS_MAX; text = *end == ',' ? end + 1 : end) {
        signals.fd[signals.count++] = (int)strtol(text, &end, 10);
        if (end == text)
            break;
    }
    const int own = slot ? atoi(slot) : -1;
    signals.is_shared = own >= 0 && own < signals.count;
    if (signals.is_shared)
        signals.own = signals.fd[own];
}

static void open_own(void)
{
    read_slots();
    if (!signals.is_shared)
        signals.own = eventfd(0, EFD_NONBLOCK | EFD_CLOEXEC);
}

uint32_t pen_store_changes(void)
{
    return atomic_load_explicit(&signals.changes, memory_order_acquire);
}

/* Reads what was written to the process's own eventfd. */
static void take(void)
{
    uint64_t value;
    if (read(signals.own, &value, sizeof value) == sizeof value)
        atomic_fetch_add_explicit(&signals.changes, 1, memory_order_release);
}

void pen_signals_wait(uint32_t *seen, int timeout_ms)
{
    const int64_t until_ns = pen_clock_ns() + (int64_t)timeout_ms * 1000000;
    int64_t left_ms = timeout_ms;
    pthread_once(&once, open_own);
    take();
    while (pen_store_changes() == *seen && left_ms > 0) {
        struct pollfd poll_own = {.fd = signals.own, .events = POLLIN};
        const bool looks = !signals.is_shared && left_ms >= LOOK_MS;
        if (poll(&poll_own, 1, looks ? LOOK_MS : (int)left_ms) == 0 && looks)
            atomic_fetch_add_explicit(&signals.changes, 1, memory_order_release);
        take();
        left_ms = (until_ns - pen_clock_ns() + 999999) / 1000000;
    }
    *seen = pen_store_changes();
}

void pen_signals_raise(void)
{
    static const uint64_t one = 1;
    pthread_once(&once, open_own);
    atomic_fetch_add_explicit(&signals.changes, 1, memory_order_release);
    if (!signals.is_shared)
        (void)!write(signals.own, &one, sizeof one);
    for (int i = 0; i < signals.count; i++) /* a full one wakes, too */
        (void)!write(signals.fd[i], &one, sizeof one);
}

bool pen_store_signals_make(int slots, struct pen_status *st)
{
    char text[SLOTS_MAX * 12] = "";
    size_t used = 0;
    for (int i = 0; i < slots && i < SLOTS_MAX; i++) {
        const int fd = eventfd(0, EFD_NONBLOCK);
        if (fd < 0)
            return pen_fail(st, PEN_UNAVAILABLE, "no eventfd for a process: %s", strerror(errno));
        used += (size_t)snprintf(text + used, sizeof text - used, i ? ",%d" : "%d", fd);
    }
    return setenv(FDS, text, 1) == 0 ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for the numbers of signals");
}

void pen_store_signals_join(int slot)
{
    char text[12];
    snprintf(text, sizeof text, "%d", slot);
    setenv(SLOT, text, 1);
}
