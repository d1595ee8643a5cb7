/* SPDX-License-Identifier: MIT */
/* The counters only grow. A waiter reads a counter, then the store, then waits: if a signal comes
 * in between, the counter has another value; if it comes later, the futex wakes the waiter. The
 * file is extended when it is short and never truncated, because access to a mapping beyond the end
 * of its file kills the process. */
#include "store/sqlite/wake.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/futex.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"

enum { SIGNAL_COUNT = 2, FIRST_WORD = 16, FILE_BYTES = 4096 };
_Static_assert((int)PEN_SIGNAL_CHANGES + 1 == SIGNAL_COUNT && (int)SIGNAL_COUNT <= (int)FIRST_WORD,
               "a counter for each signal, before the health words");
_Static_assert((FIRST_WORD + PEN_HEALTH_WORDS) * sizeof(uint32_t) <= FILE_BYTES,
               "the file has space for all words");

struct pen_wake {
    char *path;
    _Atomic uint32_t *counter; /* SIGNAL_COUNT of them; atomic: release in the wake, acquire in
                                  the wait. The health words follow at FIRST_WORD */
    _Atomic uint32_t own[FIRST_WORD + PEN_HEALTH_WORDS]; /* used if the file cannot be mapped */
};

/* Extends a short file by writing zeros. A hole could not be filled on a full disk, and storing to
 * a mapped hole would then kill the process. */
static bool fill_file(int fd)
{
    struct stat info;
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        return false;
    static const char zeros[FILE_BYTES];
    while (info.st_size < FILE_BYTES) {
        ssize_t n = pwrite(fd, zeros, (size_t)(FILE_BYTES - info.st_size), info.st_size);
        if (n <= 0)
            return false;
        info.st_size += n;
    }
    return true;
}

struct pen_wake *pen_wake_open(const char *path)
{
    struct pen_wake *wake = calloc(1, sizeof *wake);
    if (!wake || !(wake->path = strdup(path))) {
        free(wake);
        return NULL;
    }
    wake->counter = wake->own;
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0)
        return wake;
    if (fill_file(fd)) {
        void *map = mmap(NULL, FILE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        if (map != MAP_FAILED)
            wake->counter = map;
    }
    close(fd);
    return wake;
}

void pen_wake_close(struct pen_wake *wake)
{
    if (!wake)
        return;
    if (wake->counter != wake->own)
        munmap(wake->counter, FILE_BYTES);
    free(wake->path);
    free(wake);
}

_Atomic uint32_t *pen_wake_words(struct pen_wake *wake)
{
    return wake->counter + FIRST_WORD;
}

bool pen_wake_try_lock(struct pen_wake *wake, int *lock)
{
    *lock = open(wake->path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (*lock < 0 || flock(*lock, LOCK_EX | LOCK_NB) == 0)
        return true;
    close(*lock);
    return false;
}

void pen_wake_unlock(int lock)
{
    if (lock >= 0)
        close(lock);
}

void pen_wake_wait(struct pen_wake *wake, enum pen_signal signal, uint32_t *seen, int timeout_ms)
{
    _Atomic uint32_t *counter = &wake->counter[signal];
    int64_t end = pen_clock_ns() + (int64_t)timeout_ms * 1000000;
    for (;;) {
        uint32_t now = atomic_load_explicit(counter, memory_order_acquire);
        int64_t left = end - pen_clock_ns();
        if (now != *seen || left <= 0) {
            *seen = now;
            return;
        }
        struct timespec time = {.tv_sec = (time_t)(left / 1000000000),
                                .tv_nsec = (long)(left % 1000000000)};
        syscall(SYS_futex, (uint32_t *)counter, FUTEX_WAIT, now, &time, NULL, 0);
    }
}

void pen_wake_all(struct pen_wake *wake, enum pen_signal signal)
{
    atomic_fetch_add_explicit(&wake->counter[signal], 1, memory_order_release);
    syscall(SYS_futex, (uint32_t *)&wake->counter[signal], FUTEX_WAKE, INT_MAX, NULL, NULL, 0);
}
