/* SPDX-License-Identifier: MIT */
/* The thread checks the claim five times a second. Most checks only read the store
 * (pen_store_heartbeat writes every few seconds), so a cancel is noticed soon and a lease costs
 * little. Once a second a check reports the work done, for readers. A claim that begins and ends
 * between two checks costs only two locks. Without a claim the thread sleeps. */
#include "jobs/internal/heartbeat.h"

#include <pthread.h>
#include <stdlib.h>

#include "base/clock.h"
#include "base/log.h"
#include "jobs/internal/failure.h"
#include "jobs/internal/jobs.h"
#include "jobs/internal/work.h"

enum {
    CHECK_MS = 200,
    TELL_MS = 600,  /* the shortest time between two checks that report work */
    LOG_MS = 10000, /* between log lines about a store that does not answer */
    /* The times after which render threads count as stuck. They check the flag before each block of
     * pixels, which takes long on a busy machine. So STUCK_MS counts by the clock and by one
     * thread's processor time. A thread that uses no processor time counts as stuck after
     * STUCK_IDLE_MS. */
    STUCK_MS = 700,
    STUCK_IDLE_MS = 10000
};

struct pen_heartbeat {
    struct pen_store *store; /* used by the thread alone */
    const struct pen_worker_options *options;
    struct pen_thread_pool *pool; /* of the render threads; its marks are guarded by lock */
    int64_t lease_ms;
    pen_heartbeat_work_fn *work;
    void *work_user;
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t change;
    int64_t logged_ns;       /* used by the thread alone; when it last logged a failing store */
    bool quit, asleep;       /* guarded by lock */
    bool active;             /* guarded by lock */
    struct pen_claim claim;  /* guarded by lock; of the active claim */
    const atomic_bool *stop; /* guarded by lock; NULL: the batch is finished first */
    uint64_t claims;         /* guarded by lock; the number of claims so far */
    int64_t spent_ns;        /* guarded by lock; on the active claim, before since_ns */
    int64_t since_ns;        /* guarded by lock; when the claim's clock started; 0: it is stopped */
    int64_t tell_ns;         /* guarded by lock; when work was last reported, or the claim began */
    enum pen_claim_end ended; /* guarded by lock */
    int64_t told_ns;          /* guarded by lock; when the render threads were asked to stop */
    bool failed;              /* guarded by lock; the job is stored as failed by its timeout */
    atomic_bool cancel;       /* atomic: relaxed, the render threads only need to see it soon */
};

/* Notes when the render threads were asked to stop. Called with the lock held. */
static void note_told(struct pen_heartbeat *heart)
{
    heart->told_ns = pen_clock_ns();
    pen_thread_pool_mark(heart->pool);
}

/* Notes that a claim has ended, unless it is not the active one or has ended already. */
static void end_claim(struct pen_heartbeat *heart, uint64_t claim_number, enum pen_claim_end ended)
{
    if (!heart->active || heart->claims != claim_number || heart->ended != PEN_CLAIM_HELD)
        return;
    heart->ended = ended;
    note_told(heart);
    atomic_store_explicit(&heart->cancel, true, memory_order_relaxed);
}

/* Returns the working time on the active claim. Called with the lock held. */
static int64_t spent_ns(const struct pen_heartbeat *heart)
{
    return heart->spent_ns + (heart->since_ns ? pen_clock_ns() - heart->since_ns : 0);
}

/* Returns true if all workers together have worked on the job for longer than its timeout. Called
 * with the lock held. */
static bool is_late(const struct pen_heartbeat *heart)
{
    const struct pen_claim *claim = &heart->claim;
    return claim->timeout_ms &&
           claim->job_spent_us + spent_ns(heart) / 1000 >= claim->timeout_ms * 1000;
}

/* Returns true if the render threads were asked to stop so long ago that they count as stuck. While
 * the clock is stopped they do not work, because the worker waits for the store, which may take
 * long. Called with the lock held. */
static bool are_stuck(const struct pen_heartbeat *heart)
{
    const int64_t ms = (pen_clock_ns() - heart->told_ns) / 1000000;
    if (heart->since_ns == 0 || ms < STUCK_MS)
        return false;
    const int64_t cpu_ms = pen_thread_pool_most_ns(heart->pool) / 1000000;
    return ms >= (cpu_ms >= STUCK_MS ? STUCK_MS : STUCK_IDLE_MS);
}

/* Handles a claim that has ended before the worker has finished it. It fails the job if its time is
 * up, and reports render threads that do not stop as stuck. Called with the lock held, which it
 * releases and takes again. */
static void handle_ended_claim(struct pen_heartbeat *heart, const struct pen_claim *claim,
                               uint64_t claim_number)
{
    bool fail = heart->ended == PEN_CLAIM_TIMED_OUT && !heart->failed;
    if (fail) {
        struct pen_status st;
        pthread_mutex_unlock(&heart->lock);
        const bool failed =
            pen_failure_store(heart->store, claim, NULL, heart->options->trace, &st) ||
            st.code == PEN_STALE; /* or the worker has failed it */
        pthread_mutex_lock(&heart->lock);
        if (heart->claims == claim_number)
            heart->failed = failed;
    }
    bool stored = heart->ended == PEN_CLAIM_LOST || heart->failed; /* the store is up to date */
    if (!heart->active || heart->claims != claim_number || !stored || !heart->options->stuck ||
        !are_stuck(heart))
        return;
    struct pen_log_about about = pen_claim_about(claim);
    pen_log_about(PEN_LOG_ERROR, &about, "the render threads do not stop");
    heart->options->stuck(heart->options->user);
}

static void log_failure(struct pen_heartbeat *heart, const struct pen_log_about *about,
                        const struct pen_status *st)
{
    int64_t now_ns = pen_clock_ns();
    if (heart->logged_ns && now_ns - heart->logged_ns < (int64_t)LOG_MS * 1000000)
        return;
    heart->logged_ns = now_ns;
    pen_log_about(PEN_LOG_WARN, about, "heartbeat: %s", st->msg);
}

/* Adds the work done to the claim, if a report is due. Called with the lock held. */
static void add_work(struct pen_heartbeat *heart, struct pen_claim *claim)
{
    const int64_t now_ns = pen_clock_ns();
    const double others = (double)claim->job_work / PEN_WORK_ALL;
    double per_ms;
    if (!heart->work || heart->since_ns == 0 ||
        now_ns - heart->tell_ns < (int64_t)TELL_MS * 1000000)
        return;
    const double done = heart->work(heart->work_user, (double)claim->spent_us / 1000, &per_ms);
    heart->tell_ns = now_ns;
    claim->work = (int64_t)((others + done < 1 ? done : 1 - others) * PEN_WORK_ALL);
    claim->estimate_ms = pen_work_estimate_ms(
        (double)(claim->job_spent_us + claim->spent_us) / 1000, others + done, per_ms);
}

/* Checks the active claim. Called with the lock held; releases it for the call of the store. A
 * store that does not answer does not end the claim, because it may answer again before the lease
 * ends. */
static void check_claim(struct pen_heartbeat *heart)
{
    struct pen_claim claim = heart->claim;
    claim.spent_us = spent_ns(heart) / 1000;
    struct pen_log_about about = pen_claim_about(&claim);
    uint64_t claim_number = heart->claims;
    struct pen_status st;
    bool held = true;
    if (heart->ended != PEN_CLAIM_HELD) {
        handle_ended_claim(heart, &claim, claim_number);
        return;
    }
    if (is_late(heart))
        end_claim(heart, claim_number, PEN_CLAIM_TIMED_OUT);
    if (heart->stop && atomic_load_explicit(heart->stop, memory_order_relaxed))
        end_claim(heart, claim_number, PEN_CLAIM_STOPPED);
    if (heart->ended == PEN_CLAIM_HELD)
        add_work(heart, &claim);
    pthread_mutex_unlock(&heart->lock);
    if (!pen_store_heartbeat(heart->store, &claim, heart->lease_ms, &held, &st)) {
        pen_worker_check_store(heart->options, heart->store);
        log_failure(heart, &about, &st);
        held = true; /* as far as is known */
    }
    pthread_mutex_lock(&heart->lock);
    if (!held)
        end_claim(heart, claim_number, PEN_CLAIM_LOST);
    if (heart->claims == claim_number) {
        heart->claim.job_spent_us = claim.job_spent_us;
        heart->claim.job_work = claim.job_work;
    }
}

static void *run(void *user)
{
    struct pen_heartbeat *heart = user;
    uint64_t last_claim = 0;
    pthread_mutex_lock(&heart->lock);
    while (!heart->quit) {
        bool idle = !heart->active && heart->claims == last_claim;
        bool seen_before = heart->active && heart->claims == last_claim;
        last_claim = heart->claims;
        if (seen_before)
            check_claim(heart);
        if (heart->quit)
            break;
        const struct timespec until = pen_clock_after_ms(CHECK_MS);
        heart->asleep = idle && !heart->active;
        if (heart->asleep)
            pthread_cond_wait(&heart->change, &heart->lock);
        else
            pthread_cond_timedwait(&heart->change, &heart->lock, &until);
        heart->asleep = false;
    }
    pthread_mutex_unlock(&heart->lock);
    return NULL;
}

static void init_locks(struct pen_heartbeat *heart)
{
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_cond_init(&heart->change, &monotonic);
    pthread_condattr_destroy(&monotonic);
    pthread_mutex_init(&heart->lock, NULL);
}

struct pen_heartbeat *pen_heartbeat_new(const struct pen_worker_options *options,
                                        struct pen_thread_pool *pool, int64_t lease_ms,
                                        pen_heartbeat_work_fn *work, void *user,
                                        struct pen_status *st)
{
    struct pen_heartbeat *heart = calloc(1, sizeof *heart);
    if (!heart) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for the heartbeat");
        return NULL;
    }
    heart->options = options;
    heart->pool = pool;
    heart->lease_ms = lease_ms;
    heart->work = work;
    heart->work_user = user;
    heart->store = pen_store_open(options->store_url, false, st);
    init_locks(heart);
    if (heart->store && pthread_create(&heart->thread, NULL, run, heart) == 0)
        return heart;
    if (heart->store)
        pen_fail(st, PEN_NO_MEMORY, "the heartbeat's thread cannot be started");
    pthread_cond_destroy(&heart->change);
    pthread_mutex_destroy(&heart->lock);
    pen_store_close(heart->store);
    free(heart);
    return NULL;
}

void pen_heartbeat_free(struct pen_heartbeat *heart)
{
    if (!heart)
        return;
    pthread_mutex_lock(&heart->lock);
    heart->quit = true;
    pthread_cond_signal(&heart->change);
    pthread_mutex_unlock(&heart->lock);
    pthread_join(heart->thread, NULL);
    pthread_cond_destroy(&heart->change);
    pthread_mutex_destroy(&heart->lock);
    pen_store_close(heart->store);
    free(heart);
}

void pen_heartbeat_begin(struct pen_heartbeat *heart, const struct pen_claim *claim,
                         const atomic_bool *stop)
{
    pthread_mutex_lock(&heart->lock);
    heart->claim = *claim;
    heart->stop = stop;
    heart->active = true;
    heart->claims++;
    heart->ended = PEN_CLAIM_HELD;
    heart->failed = false;
    heart->spent_ns = 0;
    heart->since_ns = heart->tell_ns = pen_clock_ns();
    atomic_store_explicit(&heart->cancel, false, memory_order_relaxed);
    if (heart->asleep)
        pthread_cond_signal(&heart->change);
    pthread_mutex_unlock(&heart->lock);
}

const atomic_bool *pen_heartbeat_cancel_flag(struct pen_heartbeat *heart)
{
    return &heart->cancel;
}

void pen_heartbeat_cancel(struct pen_heartbeat *heart)
{
    atomic_store_explicit(&heart->cancel, true, memory_order_relaxed);
}

void pen_heartbeat_pause(struct pen_heartbeat *heart)
{
    pthread_mutex_lock(&heart->lock);
    heart->spent_ns = spent_ns(heart);
    heart->since_ns = 0;
    pthread_mutex_unlock(&heart->lock);
}

void pen_heartbeat_resume(struct pen_heartbeat *heart)
{
    pthread_mutex_lock(&heart->lock);
    heart->since_ns = pen_clock_ns();
    if (heart->ended != PEN_CLAIM_HELD)
        note_told(heart);
    pthread_mutex_unlock(&heart->lock);
}

int64_t pen_heartbeat_spent_us(struct pen_heartbeat *heart)
{
    pthread_mutex_lock(&heart->lock);
    int64_t spent_us = spent_ns(heart) / 1000;
    pthread_mutex_unlock(&heart->lock);
    return spent_us;
}

bool pen_heartbeat_is_late(struct pen_heartbeat *heart)
{
    pthread_mutex_lock(&heart->lock);
    if (is_late(heart))
        end_claim(heart, heart->claims, PEN_CLAIM_TIMED_OUT);
    bool late = heart->ended == PEN_CLAIM_TIMED_OUT;
    pthread_mutex_unlock(&heart->lock);
    return late;
}

enum pen_claim_end pen_heartbeat_end(struct pen_heartbeat *heart)
{
    pthread_mutex_lock(&heart->lock);
    heart->active = false;
    enum pen_claim_end ended = heart->ended;
    pthread_mutex_unlock(&heart->lock);
    return ended;
}
