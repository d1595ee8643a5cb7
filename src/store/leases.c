/* SPDX-License-Identifier: MIT */
/* Batches whose worker has ended: they are opened, one job in each transaction, and quarantined,
 * since any of them may have killed the worker. A crash is charged if the worker held batches of
 * one job alone, and to the job, because its batches share the scene. */
#include <stdio.h>
#include <stdlib.h>

#include "store/internal/handle.h"

enum {
    FIRST_WAIT_MS = 250, /* doubled once before its first use: the second loss waits for 0.5 s */
    WAIT_MAX_MS = 60000,
    DOUBLINGS = 8,
    TRIES = 8,       /* to find the same charge before and in the transaction */
    AHEAD_MS = 1000, /* other processes may have written a little later than this one asks */
};

/* After its first loss a job is retried in its turn. */
static bool count_loss(struct pen_store *store, int64_t job, int64_t *wait_ms,
                       struct pen_status *st)
{
    int64_t losses;
    if (!pen_db_value(store->db, st, &losses,
                      "UPDATE job SET losses = losses + 1 WHERE number = $1 RETURNING losses - 1",
                      "i", job))
        return false;
    const int64_t ms = (int64_t)FIRST_WAIT_MS << (losses < DOUBLINGS ? losses : DOUBLINGS);
    *wait_ms = losses <= 0 ? 0 : ms < WAIT_MAX_MS ? ms : WAIT_MAX_MS;
    return true;
}

static bool open_one(struct pen_store *store, const struct pen_opening *opening, int64_t turn,
                     bool *any, struct pen_status *st)
{
    int64_t changed;
    if (!pen_db_run(store->db, st, &changed,
                    "UPDATE batch SET state = 0, worker = NULL, turn = $5, "
                    "alone = CASE WHEN $6 = 1 THEN 1 ELSE alone END "
                    "WHERE number = (SELECT number FROM batch WHERE state = 1 AND job = $1 "
                    "AND (number = $2 OR $2 = 0) AND ($3 = '' OR worker = $3) AND lease_ms <= $4 "
                    "ORDER BY number LIMIT 1)",
                    "iitiii", opening->job, opening->batch, opening->worker, opening->before_ms,
                    turn, (int64_t)opening->lost))
        return false;
    *any = changed > 0;
    return true;
}

bool pen_batches_open(struct pen_store *store, const struct pen_opening *opening, int64_t *opened,
                      struct pen_status *st)
{
    char client[256] = "";
    int64_t priority = 0, turn, wait_ms = 0;
    bool any = true;
    *opened = 0;
    struct pen_rows *rows = pen_db_rows(
        store->db, st, "SELECT client, priority FROM job WHERE number = $1", "i", opening->job);
    if (pen_db_next(rows)) {
        snprintf(client, sizeof client, "%s", pen_db_text(rows, 0));
        priority = pen_db_int(rows, 1);
    }
    if (!pen_db_done(rows) || !pen_turn_next(store, client, priority, &turn, st))
        return false;
    while (any) {
        if (!open_one(store, opening, turn + *opened, &any, st))
            return false;
        *opened += any;
    }
    if (!opening->lost || *opened == 0)
        return true;
    return count_loss(store, opening->job, &wait_ms, st) &&
           (wait_ms == 0 || pen_db_run(store->db, st, NULL,
                                       "UPDATE batch SET not_before_ms = (SELECT now_ms()) + $2 "
                                       "WHERE job = $1 AND state = 0",
                                       "ii", opening->job, wait_ms));
}

/* Another job with a lease that has ended, or that ends later than a lease that begins now. */
static bool find_expired(struct pen_store *store, int64_t after, int64_t *job,
                         struct pen_status *st)
{
    return pen_db_value(
        store->db, st, job,
        "SELECT job FROM batch WHERE state = 1 AND job > $1 AND (lease_ms <= (SELECT now_ms()) OR "
        "lease_ms > (SELECT now_ms()) + $2 + COALESCE((SELECT worker.lease_ms FROM worker "
        "WHERE worker.id = batch.worker), 86400000)) ORDER BY job LIMIT 1",
        "ii", after, (int64_t)AHEAD_MS);
}

static bool write_expired(struct pen_store *store, int64_t job, int64_t *opened,
                          struct pen_status *st)
{
    struct pen_opening opening = {.job = job, .worker = "", .lost = true};
    int64_t state;
    return pen_job_lock(store, job, &state, st) && pen_db_now(store->db, &opening.before_ms, st) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE batch SET lease_ms = (SELECT now_ms()) + COALESCE((SELECT "
                      "worker.lease_ms FROM worker WHERE worker.id = batch.worker), 86400000) "
                      "WHERE state = 1 AND job = $1 AND lease_ms > (SELECT now_ms()) + $2 + "
                      "COALESCE((SELECT worker.lease_ms FROM worker "
                      "WHERE worker.id = batch.worker), 86400000)",
                      "ii", job, (int64_t)AHEAD_MS) &&
           pen_batches_open(store, &opening, opened, st);
}

static void note_opened(struct pen_store *store, int64_t opened, bool lost, int *sum)
{
    *sum += (int)opened;
    if (opened == 0)
        return;
    if (lost)
        pen_store_count(PEN_COUNT_LEASES_LOST, (uint64_t)opened);
    pen_db_wake(store->db);
}

bool pen_store_expire_leases(struct pen_store *store, int *opened, struct pen_status *st)
{
    int64_t job = 0, more;
    *opened = 0;
    while (find_expired(store, job, &job, st)) {
        if (job == 0)
            return true;
        if (!pen_db_begin(store->db, PEN_DB_WRITE, st) ||
            !pen_db_end(store->db, write_expired(store, job, &more, st), st))
            return false;
        note_opened(store, more, true, opened);
    }
    return false;
}

/* What a worker holds: how many jobs have a batch of it, and one of them. */
struct held {
    int64_t jobs, job, batch, charges, max_attempts;
};

static bool read_held(struct pen_store *store, const char *worker, struct held *held,
                      struct pen_status *st)
{
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "SELECT (SELECT count(DISTINCT job) FROM batch WHERE state = 1 AND worker = $1), "
        "batch.job, batch.number, job.charges, job.max_attempts FROM batch "
        "JOIN job ON job.number = batch.job WHERE batch.state = 1 AND batch.worker = $1 "
        "ORDER BY batch.job, batch.number LIMIT 1",
        "t", worker);
    *held = (struct held){0};
    if (pen_db_next(rows))
        *held = (struct held){pen_db_int(rows, 0), pen_db_int(rows, 1), pen_db_int(rows, 2),
                              pen_db_int(rows, 3), pen_db_int(rows, 4)};
    return pen_db_done(rows);
}

static bool charge(struct pen_store *store, int64_t job, const char *error, struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL, "UPDATE job SET charges = charges + 1 WHERE number = $1",
                      "i", job) &&
           (error ? pen_job_end(store, job, PEN_JOB_FAILED, error, st)
                  : pen_job_changed(store, job, st));
}

/* Opens the worker's batches of one job. `error`: of the job, which the charge ends. Changes
 * nothing if the worker holds other batches than it did, or the job has other charges. */
static bool write_ended(struct pen_store *store, const struct pen_worker_death *death,
                        const struct held *before, bool charged, const char *error, bool *same,
                        int64_t *opened, struct pen_status *st)
{
    const struct pen_opening opening = {.job = before->job,
                                        .worker = death->worker,
                                        .before_ms = INT64_MAX,
                                        .lost = death->end != PEN_WORKER_LEFT};
    struct held now;
    int64_t state;
    *opened = 0;
    if (!pen_job_lock(store, before->job, &state, st) || !read_held(store, death->worker, &now, st))
        return false;
    *same = now.job == before->job && (!charged || (now.jobs == 1 && now.batch == before->batch &&
                                                    now.charges == before->charges));
    if (!*same)
        return true;
    return (error || pen_batches_open(store, &opening, opened, st)) &&
           (!charged || charge(store, before->job, error, st));
}

/* One job of the worker; the error is made outside the transaction. */
static bool end_one(struct pen_store *store, const struct pen_worker_death *death,
                    const struct held *held, bool charged, bool *same, int *opened,
                    struct pen_status *st)
{
    struct pen_claim claim;
    char *error = NULL;
    bool found;
    int64_t more = 0;
    if (charged && held->charges + 1 >= held->max_attempts) {
        if (!pen_claim_read(store, held->batch, &claim, &found, st))
            return false;
        error = death->error(death->user, &claim, (int)held->charges + 1);
        if (!error)
            return pen_fail(st, PEN_NO_MEMORY, "no memory for the error of a job");
    }
    const bool ok =
        pen_db_begin(store->db, PEN_DB_WRITE, st) &&
        pen_db_end(store->db, write_ended(store, death, held, charged, error, same, &more, st), st);
    if (ok && *same && error)
        pen_db_wake(store->db);
    free(error);
    if (ok)
        note_opened(store, more, death->end != PEN_WORKER_LEFT, opened);
    return ok;
}

bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st)
{
    struct held held;
    int tries = 0;
    bool same = true, several = false;
    *opened = 0;
    while (read_held(store, death->worker, &held, st)) {
        if (held.jobs == 0)
            return true;
        several = several || held.jobs > 1;
        if (!end_one(store, death, &held, death->end == PEN_WORKER_CRASHED && !several, &same,
                     opened, st))
            return false;
        if (!same && ++tries == TRIES)
            return pen_fail(st, PEN_UNAVAILABLE, "the batches of worker %s keep changing",
                            death->worker);
    }
    return false;
}
