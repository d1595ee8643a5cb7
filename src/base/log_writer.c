/* SPDX-License-Identifier: MIT */
/* Invariant: while lines are lost, no line is added except the one that states their number. It has
 * the place of the lost lines. */
#include "base/internal/log_writer.h"

#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdint.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/log.h"

enum {
    WAITING_BYTES = 256 << 10,
    WRITE_BYTES = PIPE_BUF, /* written at once: a pipe keeps them whole */
    END_S = 1               /* the longest wait for the last lines */
};
_Static_assert((int)WRITE_BYTES >= (int)PEN_LOG_LINE_BYTES, "each line can be written");

static struct {
    atomic_int process; /* the process that has the thread; 0: none. atomic: relaxed, the lock
                           orders the other members */
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t changed;
    char waiting[WAITING_BYTES]; /* guarded by lock: a ring of whole lines */
    size_t first, bytes;         /* guarded by lock: begin and length of the lines in the ring */
    uint64_t lost;               /* guarded by lock: lines whose loss is not reported yet */
    bool stop;                   /* guarded by lock */
} writer = {.lock = PTHREAD_MUTEX_INITIALIZER, .changed = PTHREAD_COND_INITIALIZER};

static bool is_here(void)
{
    const int process = atomic_load_explicit(&writer.process, memory_order_relaxed);
    return process != 0 && process == getpid();
}

/* Appends a line to the ring. Called with the lock held. */
static void append(const char *line, size_t bytes)
{
    const size_t at = (writer.first + writer.bytes) % WAITING_BYTES;
    const size_t before_end = bytes < WAITING_BYTES - at ? bytes : WAITING_BYTES - at;
    memcpy(writer.waiting + at, line, before_end);
    memcpy(writer.waiting, line + before_end, bytes - before_end);
    writer.bytes += bytes;
}

bool pen_log_writer_take(const char *line, size_t bytes)
{
    if (!is_here())
        return false;
    pthread_mutex_lock(&writer.lock);
    const bool taken = is_here(); /* the thread may have ended meanwhile */
    const bool may_enter = writer.lost == 0 || pthread_equal(pthread_self(), writer.thread);
    if (taken && may_enter && bytes <= WAITING_BYTES - writer.bytes)
        append(line, bytes);
    else if (taken)
        writer.lost++;
    pthread_cond_broadcast(&writer.changed);
    pthread_mutex_unlock(&writer.lock);
    return taken;
}

/* Takes whole lines that can be written at once. Called with the lock held. */
static size_t take_lines(char lines[WRITE_BYTES])
{
    size_t most = writer.bytes < WRITE_BYTES ? writer.bytes : WRITE_BYTES, bytes = 0;
    for (size_t i = 0; i < most; i++) {
        lines[i] = writer.waiting[(writer.first + i) % WAITING_BYTES];
        if (lines[i] == '\n')
            bytes = i + 1;
    }
    writer.first = (writer.first + bytes) % WAITING_BYTES;
    writer.bytes -= bytes;
    return bytes;
}

/* Writes the number of lost lines, as the next line. Called with the lock held; releases it
 * meanwhile. */
static void tell_lost(void)
{
    const uint64_t lost = writer.lost;
    pthread_mutex_unlock(&writer.lock);
    pen_log(PEN_LOG_WARN, "%llu lines of the log were lost: it was not read fast enough",
            (unsigned long long)lost);
    pthread_mutex_lock(&writer.lock);
    writer.lost -= lost;
}

static void *run(void *arg)
{
    (void)arg;
    char lines[WRITE_BYTES];
    pthread_mutex_lock(&writer.lock);
    while (!writer.stop || writer.bytes > 0 || writer.lost > 0) {
        if (writer.lost > 0 && writer.bytes <= WAITING_BYTES / 2)
            tell_lost();
        const size_t bytes = take_lines(lines);
        if (bytes == 0) {
            pthread_cond_wait(&writer.changed, &writer.lock);
            continue;
        }
        pthread_mutex_unlock(&writer.lock);
        pen_log_write(lines, bytes);
        pthread_mutex_lock(&writer.lock);
    }
    atomic_store_explicit(&writer.process, 0, memory_order_relaxed);
    pthread_cond_broadcast(&writer.changed);
    pthread_mutex_unlock(&writer.lock);
    return NULL;
}

bool pen_log_writer_start(void)
{
    sigset_t all, before;
    sigfillset(&all);
    pthread_sigmask(SIG_SETMASK, &all, &before); /* other threads handle signals */
    pthread_mutex_lock(&writer.lock);
    writer.stop = false;
    const bool started = pthread_create(&writer.thread, NULL, run, NULL) == 0;
    if (started)
        atomic_store_explicit(&writer.process, (int)getpid(), memory_order_relaxed);
    pthread_mutex_unlock(&writer.lock);
    pthread_sigmask(SIG_SETMASK, &before, NULL);
    return started;
}

void pen_log_writer_stop(void)
{
    struct timespec until;
    if (!is_here())
        return;
    clock_gettime(CLOCK_REALTIME, &until);
    until.tv_sec += END_S;
    pthread_mutex_lock(&writer.lock);
    writer.stop = true;
    pthread_cond_broadcast(&writer.changed);
    while (is_here() && pthread_cond_timedwait(&writer.changed, &writer.lock, &until) == 0)
        continue;
    const bool ended = !is_here();
    pthread_mutex_unlock(&writer.lock);
    if (ended)
        pthread_join(writer.thread, NULL);
}
