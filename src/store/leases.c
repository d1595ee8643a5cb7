/* SPDX-License-Identifier: MIT */
/* Batches whose worker has ended. Each job's batches are opened in a transaction of its own, and
 * quarantined, because any of them may have killed the worker. A crash is charged only if the
 * worker held batches of one job alone. It is charged to the job, because the batches of a job
 * share the scene. */
#include <stdlib.h>

#include "store/internal/handle.h"

enum { FIRST_WAIT_MS = 500, WAIT_MAX_MS = 60000, DOUBLINGS = 6 };

/* After its first loss, a job's batches do not wait. */
static bool count_loss(struct pen_store *store, int64_t job, struct pen_status *st)
{
    int64_t before;
    if (!pen_db_value(store->db, st, &before,
                      "UPDATE job SET losses = losses + 1 WHERE number = $1 RETURNING losses - 2",
                      "i", job))
        return false;
    return before < 0 ||
           pen_db_run(store->db, st, NULL,
                      "UPDATE batch SET not_before_ms = (SELECT now_ms()) + $2 "
                      "WHERE job = $1 AND state = 0",
                      "ii", job,
                      before > DOUBLINGS ? (int64_t)WAIT_MAX_MS : (int64_t)FIRST_WAIT_MS << before);
}

bool pen_batches_open(struct pen_store *store, const struct pen_opening *opening, int64_t *opened,
                      struct pen_status *st)
{
    int64_t turn, changed = 1;
    *opened = 0;
    if (!pen_turn_next(store, opening->job, &turn, st))
        return false;
    for (; changed > 0; *opened += changed) {
        if (!pen_db_run(store->db, st, &changed,
                        "UPDATE batch SET state = 0, worker = NULL, turn = $5, "
                        "alone = CASE WHEN $6 = 1 THEN 1 ELSE alone END "
                        "WHERE number = (SELECT number FROM batch WHERE state = 1 AND job = $1 "
                        "AND (number = $2 OR $2 = 0) AND ($3 = '' OR worker = $3) "
                        "AND lease_ms <= $4 ORDER BY number LIMIT 1)",
                        "iitiii", opening->job, opening->batch, opening->worker, opening->before_ms,
                        turn + *opened, (int64_t)opening->lost))
            return false;
    }
    return !opening->lost || *opened == 0 || count_loss(store, opening->job, st);
}

/* The end of a lease that begins now. A lease that ends more than a second later was written before
 * the clock was set back. The second covers other processes, which may have written just after this
 * one reads the clock. */
#define LEASE_END                                                                                  \
    "(SELECT now_ms()) + COALESCE((SELECT worker.lease_ms FROM worker "                            \
    "WHERE worker.id = batch.worker), 86400000)"

static bool write_expired(struct pen_store *store, int64_t job, int64_t *opened,
                          struct pen_status *st)
{
    struct pen_opening opening = {.job = job, .worker = "", .lost = true};
    return pen_job_lock(store, job, st) && pen_db_now(store->db, &opening.before_ms, st) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE batch SET lease_ms = " LEASE_END
                      " WHERE state = 1 AND job = $1 AND lease_ms > 1000 + " LEASE_END,
                      "i", job) &&
           pen_batches_open(store, &opening, opened, st);
}

bool pen_store_expire_leases(struct pen_store *store, int *opened, struct pen_status *st)
{
    int64_t job = 0, more;
    *opened = 0;
    while (pen_db_value(store->db, st, &job,
                        "SELECT job FROM batch WHERE state = 1 AND job > $1 AND "
                        "(lease_ms <= (SELECT now_ms()) OR lease_ms > 1000 + " LEASE_END
                        ") ORDER BY job LIMIT 1",
                        "i", job)) {
        if (job == 0)
            return true;
        if (!pen_db_begin(store->db, PEN_DB_WRITE, st) ||
            !pen_write_end(store, write_expired(store, job, &more, st), st))
            return false;
        pen_store_count(PEN_COUNT_LEASES_LOST, (uint64_t)more);
        *opened += (int)more;
    }
    return false;
}

/* What a worker holds: the number of its jobs, and one of its batches. */
struct held {
    int64_t jobs, job, batch, charges, max_attempts;
    bool is_charged;
};

static bool read_held(struct pen_store *store, const char *worker, struct held *held,
                      struct pen_status *st)
{
    return pen_row_numbers(
        pen_db_rows(
            store->db, st,
            "SELECT (SELECT count(DISTINCT job) FROM batch WHERE state = 1 AND worker = $1), "
            "batch.job, batch.number, job.charges, job.max_attempts FROM batch "
            "JOIN job ON job.number = batch.job WHERE batch.state = 1 AND batch.worker = $1 "
            "ORDER BY batch.job, batch.number LIMIT 1",
            "t", worker),
        &held->jobs, &held->job, &held->batch, &held->charges, &held->max_attempts, NULL);
}

/* Opens the worker's batches of one job. `error` (may be NULL) ends the job, whose attempts the
 * charge has used up. Changes nothing if the worker no longer holds the batch, or if the job has
 * other charges meanwhile. */
static bool write_ended(struct pen_store *store, const struct pen_worker_death *death,
                        const struct held *held, const char *error, int64_t *opened,
                        struct pen_status *st)
{
    const struct pen_opening opening = {.job = held->job,
                                        .worker = death->worker,
                                        .before_ms = INT64_MAX,
                                        .lost = death->end != PEN_WORKER_LEFT};
    int64_t changed = 1;
    *opened = 0;
    if (!pen_job_lock(store, held->job, st) ||
        (held->is_charged &&
         !pen_db_run(store->db, st, &changed,
                     "UPDATE job SET charges = charges + 1, revision = revision + 1, "
                     "updated_ms = (SELECT now_ms()) WHERE number = $1 AND charges = $2 AND "
                     "EXISTS (SELECT 1 FROM batch WHERE number = $3 AND state = 1 AND worker = $4)",
                     "iiit", held->job, held->charges, held->batch, death->worker)))
        return false;
    if (changed == 0)
        return true;
    return error ? pen_job_end(store, held->job, PEN_JOB_FAILED, error, st)
                 : pen_batches_open(store, &opening, opened, st);
}

/* Ends one job's batches of the worker. The error is made outside the transaction. */
static bool end_one(struct pen_store *store, const struct pen_worker_death *death,
                    const struct held *held, int *opened, struct pen_status *st)
{
    struct pen_claim claim;
    char *error = NULL;
    bool found;
    int64_t more;
    if (held->is_charged && held->charges + 1 >= held->max_attempts) {
        if (!pen_claim_read(store, held->batch, &claim, &found, st))
            return false;
        error = death->error(death->user, &claim, (int)held->charges + 1);
        if (!error)
            return pen_fail(st, PEN_NO_MEMORY, "no memory for the error of a job");
    }
    const bool ok = pen_db_begin(store->db, PEN_DB_WRITE, st) &&
                    pen_write_end(store, write_ended(store, death, held, error, &more, st), st);
    free(error);
    if (ok && death->end != PEN_WORKER_LEFT)
        pen_store_count(PEN_COUNT_LEASES_LOST, (uint64_t)more);
    *opened += ok ? (int)more : 0;
    return ok;
}

bool pen_store_worker_ended(struct pen_store *store, const struct pen_worker_death *death,
                            int *opened, struct pen_status *st)
{
    struct held held;
    bool several = false;
    *opened = 0;
    while (read_held(store, death->worker, &held, st)) {
        if (held.jobs == 0)
            return true;
        several = several || held.jobs > 1;
        held.is_charged = death->end == PEN_WORKER_CRASHED && !several;
        if (!end_one(store, death, &held, opened, st))
            return false;
    }
    return false;
}
