/* SPDX-License-Identifier: MIT */
/* The counters only grow. A waiter reads a counter, then the store, then waits: if a signal comes
 * in between, the counter has another value; if it comes later, the futex wakes the waiter.
 *
 * The file is extended when it is short and never truncated, because access to a mapping beyond the
 * end of its file kills the process. Someone else may truncate it while it is mapped, so its length
 * is looked up before each access: it is filled again, or, where that fails, memory of the process
 * takes the place of the mapping. */
#include "store/sqlite/wake.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/futex.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "store/sqlite/sqlite.h"

/* What the page has, by its first byte. */
enum {
    SIGNAL_COUNT = 2,
    FIRST_WORD = 16, /* a number of words */
    IDENTITY_AT = 256,
    SHM_AT = 512,
    TALLY_AT = 1024,
    FILE_BYTES = 4096
};

/* The -shm file; zeros: none is noted. */
struct shm {
    uint64_t device, inode;
};

/* The byte that every handle locks, beyond the file's own bytes and before those of workers. */
enum { IN_USE_AT = 1 << 15 };
_Static_assert((int)PEN_SIGNAL_CHANGES + 1 == SIGNAL_COUNT && (int)SIGNAL_COUNT <= (int)FIRST_WORD,
               "a counter for each signal, before the health words");
_Static_assert((FIRST_WORD + PEN_HEALTH_WORDS) * sizeof(uint32_t) <= IDENTITY_AT &&
                   IDENTITY_AT + PEN_STORE_IDENTITY_BYTES <= SHM_AT &&
                   SHM_AT + sizeof(struct shm) <= TALLY_AT &&
                   TALLY_AT + PEN_TALLY_WORDS * sizeof(uint64_t) <= FILE_BYTES,
               "the file has space for all words, the identity and the sums");

struct pen_wake {
    char *path;
    _Atomic uint32_t *counter; /* SIGNAL_COUNT of them; atomic: release in the wake, acquire in
                                  the wait. The health words follow at FIRST_WORD */
    int fd;                    /* of the mapped file; -1: there is none, and `own` is used */
    _Atomic uint32_t own[(SHM_AT + sizeof(struct shm)) / sizeof(uint32_t)];
    _Atomic uint64_t own_tally[PEN_TALLY_WORDS];
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

static struct flock in_use_byte(int type)
{
    return (struct flock){
        .l_type = (short)type, .l_whence = SEEK_SET, .l_start = IN_USE_AT, .l_len = 1};
}

/* Locks the byte of the handles: F_RDLCK as one of several, F_WRLCK as the only one. The lock
 * belongs to the descriptor (an open file description lock). Returns false if others prevent it; a
 * file system without locks prevents nothing. */
static bool lock_in_use(int fd, int type)
{
    struct flock lock = in_use_byte(type);
    return fcntl(fd, F_OFD_SETLK, &lock) == 0 || (errno != EAGAIN && errno != EACCES);
}

struct pen_wake *pen_wake_open(const char *path)
{
    struct pen_wake *wake = calloc(1, sizeof *wake);
    if (!wake || !(wake->path = strdup(path))) {
        free(wake);
        return NULL;
    }
    wake->counter = wake->own;
    wake->fd = -1;
    int fd = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0)
        return wake;
    if (fill_file(fd)) {
        void *map = mmap(NULL, FILE_BYTES, PROT_READ | PROT_WRITE, MAP_SHARED, fd, 0);
        if (map != MAP_FAILED) {
            wake->counter = map;
            wake->fd = fd;
            lock_in_use(fd, F_RDLCK);
            return wake;
        }
    }
    close(fd);
    return wake;
}

/* The mapped words, after filling a file that someone has truncated. What it had is lost: signals,
 * which may be lost, and faults, which are met again. */
static _Atomic uint32_t *words_of(struct pen_wake *wake)
{
    struct stat info;
    if (wake->fd < 0 || fstat(wake->fd, &info) != 0 || info.st_size >= FILE_BYTES)
        return wake->counter;
    bool filled = fill_file(wake->fd);
    pen_log(PEN_LOG_ERROR, "the file %s was truncated while it was in use; it %s", wake->path,
            filled ? "was filled again" : "could not be filled again: signals come late");
    if (!filled)
        mmap(wake->counter, FILE_BYTES, PROT_READ | PROT_WRITE,
             MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0);
    return wake->counter;
}

void pen_wake_close(struct pen_wake *wake)
{
    if (!wake)
        return;
    if (wake->fd >= 0) {
        munmap(wake->counter, FILE_BYTES);
        close(wake->fd);
    }
    free(wake->path);
    free(wake);
}

_Atomic uint32_t *pen_wake_words(struct pen_wake *wake)
{
    return words_of(wake) + FIRST_WORD;
}

char *pen_wake_identity(struct pen_wake *wake)
{
    return (char *)words_of(wake) + IDENTITY_AT;
}

void pen_wake_set_identity(struct pen_wake *wake, const char *identity)
{
    char *to = pen_wake_identity(wake);
    if (strcmp(to, identity) == 0)
        return;
    snprintf(to, PEN_STORE_IDENTITY_BYTES, "%s", identity);
    if (wake->fd >= 0)
        fdatasync(wake->fd);
}

static struct shm shm_of(const struct stat *info)
{
    return (struct shm){.device = info->st_dev, .inode = info->st_ino};
}

void pen_wake_note_shm(struct pen_wake *wake, const struct stat *info)
{
    const struct shm now = shm_of(info);
    memcpy((char *)words_of(wake) + SHM_AT, &now, sizeof now);
}

bool pen_wake_is_shm(struct pen_wake *wake, const struct stat *info)
{
    const struct shm now = shm_of(info);
    struct shm noted;
    memcpy(&noted, (const char *)words_of(wake) + SHM_AT, sizeof noted);
    return noted.inode == 0 || (noted.inode == now.inode && noted.device == now.device);
}

_Atomic uint64_t *pen_wake_tallies(struct pen_wake *wake)
{
    _Atomic uint32_t *words = words_of(wake);
    return words == wake->own ? wake->own_tally
                              : (_Atomic uint64_t *)(void *)((char *)words + TALLY_AT);
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

bool pen_wake_has_others(struct pen_wake *wake)
{
    struct flock lock = in_use_byte(F_WRLCK);
    return wake->fd >= 0 && fcntl(wake->fd, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool pen_wake_be_alone(struct pen_wake *wake)
{
    /* Where the path names another file by now, others may use that one. */
    return wake->fd < 0 ||
           (pen_sqlite_is_named(wake->fd, wake->path) && lock_in_use(wake->fd, F_WRLCK));
}

void pen_wake_end_alone(struct pen_wake *wake)
{
    if (wake->fd >= 0)
        lock_in_use(wake->fd, F_RDLCK);
}

void pen_wake_wait(struct pen_wake *wake, enum pen_signal signal, uint32_t *seen, int timeout_ms)
{
    int64_t end = pen_clock_ns() + (int64_t)timeout_ms * 1000000;
    for (;;) {
        _Atomic uint32_t *counter = words_of(wake) + signal;
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
    _Atomic uint32_t *counter = words_of(wake) + signal;
    atomic_fetch_add_explicit(counter, 1, memory_order_release);
    syscall(SYS_futex, (uint32_t *)counter, FUTEX_WAKE, INT_MAX, NULL, NULL, 0);
}
