/* SPDX-License-Identifier: MIT */
/* What all writes about jobs share: the locks of a job and of a claim's batch, and the changes that
 * several rules make under these locks. */
#include "store/internal/objects.h"

/* A job's elapsed time at this moment ($2: the boot, $3: its clock in us). Within one boot it is by
 * the clock of the boot, which nobody sets. Across a boot it is by the store's clock, unless that
 * was set back. */
#define ELAPSED                                                                                    \
    "elapsed_us + CASE WHEN moment_boot = $2 AND $2 <> 0 AND moment_us <= $3 THEN $3 - moment_us " \
    "WHEN moment_boot = $2 AND $2 <> 0 THEN 0 "                                                    \
    "WHEN moment_ms < (SELECT now_ms()) THEN ((SELECT now_ms()) - moment_ms) * 1000 ELSE 0 END"
#define MOVE_ON                                                                                    \
    "elapsed_us = " ELAPSED ", moment_boot = $2, moment_us = $3, moment_ms = (SELECT now_ms())"
#define START                                                                                      \
    "state = 1, revision = revision + 1, started_ms = (SELECT now_ms()), "                         \
    "updated_ms = (SELECT now_ms()), queue_us = " ELAPSED ", " MOVE_ON

bool pen_job_number(struct pen_store *store, const char *id, int64_t *number, int64_t *state,
                    struct pen_status *st)
{
    const struct pen_moment now = pen_clock_moment();
    int64_t removed_ms = 0;
    struct pen_rows *rows =
        state ? pen_db_rows(store->db, st,
                            "UPDATE job SET " MOVE_ON
                            " WHERE id = $1 RETURNING number, removed_ms, state",
                            "tii", id, now.boot, now.us)
              : pen_db_rows(store->db, st, "SELECT number, removed_ms FROM job WHERE id = $1", "t",
                            id);
    const bool found = pen_db_next(rows);
    if (found) {
        *number = pen_db_int(rows, 0);
        removed_ms = pen_db_int(rows, 1);
        if (state)
            *state = pen_db_int(rows, 2);
    }
    if (!pen_db_done(rows) ||
        (!found && !pen_db_value(store->db, st, &removed_ms,
                                 "SELECT removed_ms FROM removed WHERE id = $1", "t", id)))
        return false;
    if (removed_ms > 0)
        return pen_fail(st, PEN_GONE, "job %s was removed; only its statistics are left", id);
    return found || pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
}

bool pen_job_lock(struct pen_store *store, int64_t job, struct pen_status *st)
{
    const struct pen_moment now = pen_clock_moment();
    return pen_db_run(store->db, st, NULL, "UPDATE job SET " MOVE_ON " WHERE number = $1", "iii",
                      job, now.boot, now.us);
}

bool pen_job_start(struct pen_store *store, int64_t job, struct pen_status *st)
{
    const struct pen_moment now = pen_clock_moment();
    return pen_db_run(store->db, st, NULL,
                      "UPDATE job SET " START " WHERE number = (SELECT number FROM job "
                      "WHERE number = $1 AND state = 0 {skip_locked})",
                      "iii", job, now.boot, now.us);
}

bool pen_job_end(struct pen_store *store, int64_t job, enum pen_job_state state, const char *error,
                 struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL,
                      "UPDATE job SET state = $2, error = $3, cost_map = NULL, results_bytes = 0, "
                      "revision = revision + 1, finished_ms = (SELECT now_ms()), "
                      "updated_ms = (SELECT now_ms()) WHERE number = $1",
                      "iit", job, (int64_t)state, error) &&
           pen_db_run(
               store->db, st, NULL,
               "UPDATE batch SET state = 3, worker = NULL WHERE job = $1 AND state IN (0, 1)", "i",
               job) &&
           pen_kept_drop(store, job, -2, st);
}

static bool add_time(struct pen_store *store, const struct pen_claim *claim,
                     const struct pen_batch *batch, struct pen_status *st)
{
    const int64_t more_us = claim->spent_us - batch->spent_us;
    return more_us <= 0 ||
           (pen_db_run(store->db, st, NULL,
                       "UPDATE job SET spent_us = spent_us + $2 WHERE number = $1", "ii",
                       batch->job, more_us) &&
            pen_db_run(store->db, st, NULL, "UPDATE batch SET spent_us = $2 WHERE number = $1",
                       "ii", claim->batch, claim->spent_us));
}

/* The job's lock is enough to read the batch: without this lock, other calls change only open
 * batches. */
bool pen_claim_lock(struct pen_store *store, const struct pen_claim *claim, struct pen_batch *batch,
                    struct pen_status *st)
{
    const struct pen_moment now = pen_clock_moment();
    int64_t job_state, state, attempt;
    *batch = (struct pen_batch){.number = claim->batch};
    if (!pen_db_run(store->db, st, NULL,
                    "UPDATE job SET " MOVE_ON
                    " WHERE number = (SELECT job FROM batch WHERE number = $1)",
                    "iii", claim->batch, now.boot, now.us) ||
        !pen_row_numbers(
            pen_db_rows(store->db, st,
                        "SELECT job.number, job.state, batch.state, batch.attempt, batch.kind, "
                        "batch.tile_count, batch.pixels, batch.told_pixels, batch.work, "
                        "batch.spent_us, batch.view, job.charges + job.losses FROM batch "
                        "JOIN job ON job.number = batch.job WHERE batch.number = $1",
                        "i", claim->batch),
            &batch->job, &job_state, &state, &attempt, &batch->kind, &batch->tile_count,
            &batch->pixels, &batch->told_pixels, &batch->work, &batch->spent_us, &batch->view,
            &batch->troubles, NULL))
        return false;
    batch->held = attempt == claim->attempt && state == PEN_BATCH_LEASED;
    batch->done = attempt == claim->attempt && state == PEN_BATCH_DONE;
    return !batch->held || ((job_state != PEN_JOB_QUEUED || pen_job_start(store, batch->job, st)) &&
                            add_time(store, claim, batch, st));
}

bool pen_claim_hold(struct pen_store *store, const struct pen_claim *claim, const char *what,
                    struct pen_batch *batch, struct pen_status *st)
{
    return pen_claim_lock(store, claim, batch, st) &&
           (batch->held || pen_fail(st, PEN_STALE, "the batch is no longer held; %s", what));
}

bool pen_claim_tell(struct pen_store *store, const struct pen_batch *batch, int64_t pixels,
                    int64_t work, int64_t estimate_ms, struct pen_status *st)
{
    int64_t total = 0;
    if (work < 0 &&
        !pen_db_value(store->db, st, &total, "SELECT total_pixels FROM job WHERE number = $1", "i",
                      batch->job))
        return false;
    if (total > 0)
        work = (int64_t)(PEN_WORK_ALL * ((double)pixels / (double)total));
    if (pixels < batch->told_pixels)
        pixels = batch->told_pixels;
    if (work < batch->work)
        work = batch->work;
    return pen_db_run(
               store->db, st, NULL,
               "UPDATE job SET done_pixels = done_pixels + $2, "
               "work = CASE WHEN work + $3 > 1000000000 THEN 1000000000 ELSE work + $3 END, "
               "told_us = spent_us, told_elapsed_us = elapsed_us, "
               "estimate_ms = CASE WHEN CAST($4 AS BIGINT) > 0 THEN $4 ELSE estimate_ms END, "
               "revision = revision + 1, updated_ms = (SELECT now_ms()) WHERE number = $1",
               "iiii", batch->job, pixels - batch->told_pixels, work - batch->work, estimate_ms) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE batch SET told_pixels = $2, work = $3 WHERE number = $1", "iii",
                      batch->number, pixels, work);
}
