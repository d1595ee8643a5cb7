/* SPDX-License-Identifier: MIT */
/* The order of batches: priority, then turn, then age. Turns are fair queueing among clients, after
 * start-time fair queueing (Goyal, Vin, Cheng, SIGCOMM 1996). A client's new batches come behind
 * its own open batches, and behind the next open batch of all clients. No other state is kept: an
 * idle client has neither credit nor debt. */
#include "store/internal/handle.h"

enum {
    TURN_MS = 60000,  /* how long a batch may keep others of its priority waiting */
    THERE_MS = 300000 /* a worker counts as present if it was seen in this time */
};

bool pen_turn_next(struct pen_store *store, int64_t job, int64_t *turn, struct pen_status *st)
{
    int64_t least, own;
    if (!pen_db_run(store->db, st, NULL,
                    "INSERT INTO turn (client, priority, turn) SELECT client, priority, 0 FROM job "
                    "WHERE number = $1 ON CONFLICT (client, priority) "
                    "DO UPDATE SET turn = turn.turn + 1",
                    "i", job))
        return false;
    /* A separate statement, because its snapshot must be later than the lock. Batches that wait
     * after lost workers are passed by other batches, so their turns do not count. */
    if (!pen_row_numbers(
            pen_db_rows(store->db, st,
                        "SELECT (SELECT turn FROM batch WHERE state = 0 "
                        "AND priority = job.priority AND not_before_ms <= (SELECT now_ms()) "
                        "ORDER BY turn LIMIT 1), (SELECT turn FROM batch WHERE state = 0 "
                        "AND client = job.client AND priority = job.priority "
                        "ORDER BY turn DESC LIMIT 1) FROM job WHERE number = $1",
                        "i", job),
            &least, &own, NULL))
        return false;
    *turn = (least > own ? least : own) + 1;
    return true;
}

bool pen_claim_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st)
{
    int64_t now_ms, other;
    if (!pen_db_now(store->db, &now_ms, st))
        return false;
    const bool had_turn = claim->claimed_ms > now_ms || now_ms - claim->claimed_ms >= TURN_MS;
    const bool ok =
        pen_db_value(store->db, st, &other,
                     "SELECT 1 FROM batch AS other WHERE other.state = 0 AND other.priority >= "
                     "(SELECT priority FROM batch WHERE number = $1) + CAST($2 AS BIGINT) "
                     "AND other.not_before_ms <= (SELECT now_ms()) LIMIT 1",
                     "ii", claim->batch, (int64_t)(had_turn ? 0 : 1));
    *outranked = other > 0;
    return ok;
}

bool pen_store_outranked(struct pen_store *store, const struct pen_claim *claim, bool *outranked,
                         struct pen_status *st)
{
    *outranked = false;
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(store->db, pen_claim_outranked(store, claim, outranked, st), st);
}

static bool read_ids(struct pen_store *store, struct pen_queue *queue, struct pen_status *st)
{
    bool ok = true;
    struct pen_rows *rows =
        pen_db_rows(store->db, st,
                    "SELECT id FROM (SELECT job, max(priority) AS priority, min(turn) AS turn, "
                    "min(number) AS number FROM batch WHERE state = 0 GROUP BY job "
                    "ORDER BY priority DESC, turn, number LIMIT $1) AS queue "
                    "JOIN job ON job.number = queue.job "
                    "ORDER BY queue.priority DESC, queue.turn, queue.number",
                    "i", (int64_t)PEN_QUEUE_TOLD);
    while (ok && pen_db_next(rows))
        ok = pen_buf_add(&queue->ids, pen_db_text(rows, 0), PEN_ID_BYTES) ||
             pen_fail(st, PEN_NO_MEMORY, "no memory for the queue");
    return pen_db_done(rows) && ok;
}

/* A leased batch takes a part of the job's estimate, in proportion to its pixels. */
static bool read_hand(struct pen_store *store, struct pen_queue *queue, struct pen_status *st)
{
    struct pen_rows *rows =
        pen_db_rows(store->db, st,
                    "SELECT job.estimate_ms, job.total_pixels, batch.pixels, batch.claimed_ms, "
                    "(SELECT now_ms()) FROM batch JOIN job ON job.number = batch.job "
                    "WHERE batch.state = 1 AND job.estimate_ms > 0 AND job.total_pixels > 0",
                    "");
    while (pen_db_next(rows)) {
        const double share = (double)pen_db_int(rows, 2) / (double)pen_db_int(rows, 1);
        const int64_t held_ms = pen_db_int(rows, 4) - pen_db_int(rows, 3);
        const int64_t all_ms = (int64_t)(share * (double)pen_db_int(rows, 0));
        const int64_t left_ms = all_ms - (held_ms > 0 ? held_ms : 0);
        if (left_ms > 0)
            queue->hand_us += 1000 * (left_ms < TURN_MS ? left_ms : TURN_MS);
    }
    return pen_db_done(rows);
}

/* Reads the mean working time of a job, and the number of workers. */
static bool read_pace(struct pen_store *store, struct pen_queue *queue, struct pen_status *st)
{
    return pen_row_numbers(
        pen_db_rows(store->db, st,
                    "SELECT CAST(sum(spent_us) AS BIGINT) / count(*), (SELECT count(*) "
                    "FROM worker WHERE seen_ms > (SELECT now_ms()) - $1) FROM "
                    "(SELECT spent_us FROM job WHERE finished_ms > 0 AND removed_ms = 0 "
                    "AND spent_us > 0 ORDER BY finished_ms DESC, number DESC LIMIT 50) AS ended",
                    "i", (int64_t)THERE_MS),
        &queue->job_us, &queue->workers, NULL);
}

bool pen_store_queue(struct pen_store *store, struct pen_queue *queue, struct pen_status *st)
{
    *queue = (struct pen_queue){0};
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(store->db,
                      read_ids(store, queue, st) && read_hand(store, queue, st) &&
                          read_pace(store, queue, st),
                      st);
}
