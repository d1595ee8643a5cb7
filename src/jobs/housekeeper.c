/* SPDX-License-Identifier: MIT */
#include "jobs/internal/housekeeper.h"

#include <errno.h>
#include <pthread.h>
#include <semaphore.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "jobs/internal/jobs.h"

enum {
    ROUND_MS = 1000,      /* between rounds */
    LOG_MS = 60000,       /* between log lines about a store that fails */
    PAUSE_MS = 5,         /* the shortest pause after a slice */
    EXPIRED_AT_ONCE = 16, /* jobs beyond retention that are removed between two pauses */
};

struct pen_housekeeper {
    struct pen_jobs *jobs; /* used by the thread alone */
    const struct pen_worker_options *options;
    int64_t round_ms;
    pthread_t thread;
    sem_t quit;
    int64_t logged_ns; /* used by the thread alone */
};

/* Waits; returns false if the thread has to end. */
static bool pause_for(struct pen_housekeeper *keeper, int64_t ms)
{
    const struct timespec until = pen_clock_after_ms(ms);
    int rc;
    do
        rc = sem_clockwait(&keeper->quit, CLOCK_MONOTONIC, &until);
    while (rc != 0 && errno == EINTR);
    return rc != 0;
}

/* A failure is only a delay: the next round tries again. */
static bool note_failure(struct pen_housekeeper *keeper, const struct pen_status *st)
{
    int64_t now_ns = pen_clock_ns();
    pen_worker_check_store(keeper->options, pen_jobs_store(keeper->jobs));
    if (!keeper->logged_ns || now_ns - keeper->logged_ns >= (int64_t)LOG_MS * 1000000) {
        keeper->logged_ns = now_ns;
        pen_log(PEN_LOG_WARN, "housekeeping: %s; trying again", st->msg);
    }
    return false;
}

/* Removes jobs beyond retention; their statistics stay. Returns true if there may be more. If a
 * client removes a job meanwhile, that is no failure. */
static bool expire_jobs(struct pen_housekeeper *keeper)
{
    char id[PEN_ID_BYTES];
    struct pen_status st;
    bool found = true;
    for (int i = 0; i < EXPIRED_AT_ONCE && found; i++) {
        if (!pen_store_expired(pen_jobs_store(keeper->jobs), id, &found, &st))
            return note_failure(keeper, &st);
        if (found && !pen_jobs_delete(keeper->jobs, id, NULL, true, &st) && st.code != PEN_GONE)
            return note_failure(keeper, &st);
    }
    return found;
}

/* Does a slice of each kind of work. Returns true if there was any work. */
static bool do_slice(struct pen_housekeeper *keeper)
{
    struct pen_status st;
    bool more = false;
    const bool expired = expire_jobs(keeper);
    if (!pen_store_purge(pen_jobs_store(keeper->jobs), &more, &st))
        return note_failure(keeper, &st);
    return expired || more;
}

/* After a slice it pauses as long as the slice took. So the store is free for others half of the
 * time. */
static void *run(void *user)
{
    struct pen_housekeeper *keeper = user;
    int64_t pause_ms = keeper->round_ms;
    while (pause_for(keeper, pause_ms)) {
        int64_t begun_ns = pen_clock_ns();
        bool more = do_slice(keeper);
        int64_t took_ms = (pen_clock_ns() - begun_ns) / 1000000;
        pause_ms = more ? (took_ms > PAUSE_MS ? took_ms : PAUSE_MS) : keeper->round_ms;
    }
    return NULL;
}

struct pen_housekeeper *pen_housekeeper_new(const struct pen_worker_options *options,
                                            struct pen_status *st)
{
    struct pen_housekeeper *keeper = calloc(1, sizeof *keeper);
    if (!keeper) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the housekeeping");
        return NULL;
    }
    keeper->options = options;
    keeper->round_ms = options->housekeeping_ms > 0 ? options->housekeeping_ms : ROUND_MS;
    sem_init(&keeper->quit, 0, 0);
    const struct pen_limits limits = pen_limits_default(); /* it reads no documents */
    keeper->jobs = pen_jobs_open(options->store_url, &limits, st);
    if (keeper->jobs && pthread_create(&keeper->thread, NULL, run, keeper) == 0)
        return keeper;
    if (keeper->jobs)
        pen_fail(st, PEN_NO_MEMORY, "the housekeeping's thread cannot be started");
    pen_jobs_close(keeper->jobs);
    sem_destroy(&keeper->quit);
    free(keeper);
    return NULL;
}

void pen_housekeeper_free(struct pen_housekeeper *keeper)
{
    if (!keeper)
        return;
    sem_post(&keeper->quit);
    pthread_join(keeper->thread, NULL);
    pen_jobs_close(keeper->jobs);
    sem_destroy(&keeper->quit);
    free(keeper);
}
