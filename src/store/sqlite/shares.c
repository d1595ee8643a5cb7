/* SPDX-License-Identifier: MIT */
/* Shares: which batch is next, and what its choice is judged by (README.md, "Shares"). A peer is a
 * client with a priority. */
#include <stdio.h>

#include "store/sqlite/sqlite.h"

static bool enter_peer(struct pen_sqlite_store *store, const struct pen_job_new *job,
                       int64_t now_ms, struct pen_status *st)
{
    const enum pen_sqlite_sql statements[] = {SQL_PEER_ADD, SQL_PEER_ENTER};
    if (!pen_sqlite_run_with(store, SQL_LEVEL_ADD, job->priority, st))
        return false;
    for (int i = 0; i < 2; i++) {
        struct pen_sqlite_query query = pen_sqlite_query(store, statements[i]);
        pen_sqlite_int(&query, job->priority);
        pen_sqlite_text(&query, pen_job_client(job));
        pen_sqlite_int(&query, now_ms);
        if (!pen_sqlite_run(&query, st))
            return false;
    }
    return true;
}

bool pen_sqlite_share_enter(struct pen_driver *driver, const struct pen_job_new *job,
                            int64_t number, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    int64_t now_ms;
    if (!pen_sqlite_now(driver, &now_ms, st) || !enter_peer(store, job, now_ms, st))
        return false;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_JOB_PEER);
    pen_sqlite_int(&query, job->priority);
    pen_sqlite_text(&query, pen_job_client(job));
    pen_sqlite_int(&query, number);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_share_leave(struct pen_driver *driver, int64_t job, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    return pen_sqlite_run_with(store, SQL_PEER_LEAVE, job, st) &&
           pen_sqlite_run_with(store, SQL_EXPECTED_LEAVE, job, st);
}

bool pen_sqlite_expected_count(struct pen_driver *driver, bool counted, struct pen_status *st)
{
    struct pen_sqlite_query query =
        pen_sqlite_query(pen_sqlite_of(driver), counted ? SQL_EXPECTED_COUNT : SQL_EXPECTED_DROP);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_expected_enter(struct pen_driver *driver, int64_t job, int64_t *bytes,
                               struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_EXPECTED_OF_JOB);
    pen_sqlite_int(&query, job);
    return pen_sqlite_value(&query, bytes, st) &&
           pen_sqlite_run_with(store, SQL_EXPECTED_ENTER, job, st);
}

bool pen_sqlite_share_served(struct pen_driver *driver, int64_t batch, int64_t now_ms,
                             struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_PEER_SERVED);
    pen_sqlite_int(&query, batch);
    pen_sqlite_int(&query, now_ms);
    return pen_sqlite_run(&query, st);
}

static bool read_facts(struct pen_driver *driver, struct pen_queue *queue, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_QUEUE_FACTS);
    int64_t now_ms;
    bool row;
    if (!pen_sqlite_now(driver, &now_ms, st))
        return false;
    pen_sqlite_int(&query, now_ms);
    if (!pen_sqlite_next(&query, &row, st) || !row)
        return row;
    queue->running = pen_sqlite_column_int(&query, 0);
    queue->workers = pen_sqlite_column_int(&query, 1);
    queue->job_us = pen_sqlite_column_int(&query, 2);
    queue->hand_us = pen_sqlite_column_int(&query, 3);
    pen_sqlite_end(&query);
    return true;
}

bool pen_sqlite_queue(struct pen_driver *driver, struct pen_queue *queue, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_QUEUE);
    bool ok;
    while (pen_sqlite_next_row(&query, &ok, st)) {
        char id[PEN_ID_BYTES] = "";
        snprintf(id, sizeof id, "%s", pen_sqlite_column_text(&query, 0));
        pen_buf_add(&queue->ids, id, sizeof id);
    }
    pen_sqlite_end(&query);
    if (queue->ids.failed)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the queue");
    return ok && read_facts(driver, queue, st);
}

bool pen_sqlite_queue_lengths(struct pen_driver *driver, const char *client, int64_t *all,
                              int64_t *of_client, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_QUEUE_LENGTHS);
    bool row;
    *all = *of_client = 0;
    pen_sqlite_text(&query, client);
    if (!pen_sqlite_next(&query, &row, st))
        return false;
    if (row) {
        *all = pen_sqlite_column_int(&query, 0);
        *of_client = pen_sqlite_column_int(&query, 1);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_peers_remove(struct pen_driver *driver, int64_t before_ms, struct pen_status *st)
{
    return pen_sqlite_run_with(pen_sqlite_of(driver), SQL_PEERS_REMOVE, before_ms, st);
}

bool pen_sqlite_batch_spend(struct pen_driver *driver, int64_t batch, int64_t attempt,
                            int64_t spent_us, struct pen_status *st)
{
    /* The batch comes last: the others read what it had spent before. The level reads what its
     * peer was served before. */
    const enum pen_sqlite_sql statements[] = {SQL_LEVEL_SPEND, SQL_PEER_SPEND, SQL_JOB_SPEND,
                                              SQL_BATCH_SPEND};
    int64_t now_ms;
    if (!pen_sqlite_now(driver, &now_ms, st))
        return false;
    for (size_t i = 0; i < sizeof statements / sizeof statements[0]; i++) {
        struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), statements[i]);
        pen_sqlite_int(&query, batch);
        pen_sqlite_int(&query, attempt);
        pen_sqlite_int(&query, spent_us);
        if (statements[i] == SQL_PEER_SPEND)
            pen_sqlite_int(&query, now_ms);
        if (!pen_sqlite_run(&query, st))
            return false;
    }
    return true;
}

bool pen_sqlite_job_charge_leases(struct pen_driver *driver, int64_t job, int64_t now_ms,
                                  struct pen_status *st)
{
    enum { LEASES = 256 };
    struct {
        int64_t batch, attempt, spent_us;
    } lease[LEASES];
    int count = 0;
    bool ok;
    struct pen_sqlite_query query = pen_sqlite_query(pen_sqlite_of(driver), SQL_LEASES_OF_JOB);
    pen_sqlite_int(&query, job);
    pen_sqlite_int(&query, now_ms);
    pen_sqlite_int(&query, LEASES);
    while (pen_sqlite_next_row(&query, &ok, st)) {
        lease[count].batch = pen_sqlite_column_int(&query, 0);
        lease[count].attempt = pen_sqlite_column_int(&query, 1);
        lease[count++].spent_us = pen_sqlite_column_int(&query, 2);
    }
    for (int i = 0; ok && i < count; i++)
        ok =
            pen_sqlite_batch_spend(driver, lease[i].batch, lease[i].attempt, lease[i].spent_us, st);
    return ok;
}

/* What a claim may take. */
struct wanted {
    int64_t paused_until_ms;
    bool quarantined, aged;
};

/* Runs a choice among rows that have a batch to claim: the first two parameters are `wanted`, the
 * third is `of`; of the peer there is a fourth, whether aged ones come first. Reads the columns
 * that there are. */
static bool choose(struct pen_sqlite_store *store, enum pen_sqlite_sql sql,
                   const struct wanted *wanted, int64_t of, int64_t out[3], bool *found,
                   struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    pen_sqlite_int(&query, wanted->paused_until_ms);
    pen_sqlite_int(&query, wanted->quarantined);
    pen_sqlite_int(&query, of);
    if (sql == SQL_NEXT_PEER)
        pen_sqlite_int(&query, wanted->aged);
    if (!pen_sqlite_next(&query, found, st))
        return false;
    if (*found) {
        for (int i = 0; i < 3 && i < sqlite3_column_count(query.stmt); i++)
            out[i] = pen_sqlite_column_int(&query, i);
        pen_sqlite_end(&query);
    }
    return true;
}

bool pen_sqlite_next_open(struct pen_driver *driver, int64_t paused_until_ms, bool quarantined,
                          struct pen_claim *claim, int64_t *job, bool *found, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(driver);
    const struct wanted wanted = {paused_until_ms, quarantined, !store->took_aged};
    int64_t now_ms, peer[3] = {0}, chosen[3] = {0}; /* peer: aged, balance */
    if (!pen_sqlite_now(driver, &now_ms, st) ||
        !choose(store, SQL_NEXT_PEER, &wanted, now_ms, peer, found, st))
        return false;
    if (!*found)
        return true;
    store->took_aged = wanted.aged && peer[1] != 0;
    const enum pen_sqlite_sql rule = peer[2] > 0 ? SQL_NEXT_LEAST : SQL_NEXT_OLDEST;
    if (!choose(store, rule, &wanted, peer[0], chosen, found, st) || !*found)
        return *found;
    return pen_sqlite_first_open(driver, chosen[0], quarantined, claim, job, found, st);
}
