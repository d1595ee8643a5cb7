/* SPDX-License-Identifier: MIT */
/* What becomes of batches whose worker is gone. Nobody knows at first what killed it, so all that
 * it held are suspects; and only the death of a worker that held one job's batches alone, by that
 * work's own doing, is charged. Charges are counted by job: its batches share the scene. */
#include <stdlib.h>

#include "base/clock.h"
#include "store/sqlite/sqlite.h"

/* Leases of `worker`, and those that ended before before_ms. */
struct lost {
    const char *worker;
    int64_t before_ms;
    const struct pen_worker_death *death; /* NULL: a sweep */
    int opened;
};

static struct pen_sqlite_query lost_query(struct pen_sqlite_store *store, enum pen_sqlite_sql sql,
                                          const struct lost *lost)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, sql);
    pen_sqlite_int(&query, lost->before_ms);
    pen_sqlite_text(&query, lost->worker);
    return query;
}

static bool open_suspects(struct pen_sqlite_store *store, struct lost *lost, struct pen_status *st)
{
    struct pen_sqlite_query jobs = lost_query(store, SQL_LOST_JOBS, lost);
    pen_sqlite_int(&jobs, pen_clock_wall_ms());
    struct pen_sqlite_query batches = lost_query(store, SQL_LOST_OPEN, lost);
    if (!pen_sqlite_run(&jobs, st) || !pen_sqlite_run(&batches, st))
        return false;
    lost->opened = pen_sqlite_changes(store);
    store->base.work = lost->opened > 0;
    return true;
}

/* Opens them as they are. */
static bool open_left(struct pen_sqlite_store *store, struct lost *lost, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_LEFT_OPEN);
    pen_sqlite_text(&query, lost->worker);
    if (!pen_sqlite_run(&query, st))
        return false;
    lost->opened = pen_sqlite_changes(store);
    store->base.work = lost->opened > 0;
    return true;
}

/* Whom to charge: a batch of the only job that the worker held, if there is one. */
struct charge {
    bool any;
    struct pen_claim claim;
    int64_t job;
    int charges, max_attempts; /* charges: with this one */
};

static bool find_charge(struct pen_sqlite_store *store, const char *worker, struct charge *charge,
                        struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_CHARGE_WHOM);
    pen_sqlite_text(&query, worker);
    if (!pen_sqlite_next(&query, &charge->any, st))
        return false;
    if (!charge->any)
        return true;
    pen_sqlite_read_claim(&query, &charge->claim, &charge->job);
    charge->charges = (int)pen_sqlite_column_int(&query, 14) + 1;
    charge->max_attempts = (int)pen_sqlite_column_int(&query, 15);
    pen_sqlite_end(&query);
    return true;
}

static bool fail_job(struct pen_sqlite_store *store, const struct pen_worker_death *death,
                     const struct charge *charge, struct pen_status *st)
{
    char *error = death->error(death->user, &charge->claim, charge->charges);
    if (!error)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the error of a job");
    bool ok = pen_sqlite_end_job(store, charge->job, PEN_JOB_FAILED, error, st);
    free(error);
    return ok;
}

/* Charges the job found, and ends it if that was its last attempt. */
static bool write_charge(struct pen_sqlite_store *store, const struct pen_worker_death *death,
                         const struct charge *charge, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_CHARGE);
    pen_sqlite_int(&query, charge->job);
    pen_sqlite_int(&query, pen_clock_wall_ms());
    store->base.changed = true;
    return pen_sqlite_run(&query, st) &&
           (charge->charges < charge->max_attempts || fail_job(store, death, charge, st));
}

static bool write_lost(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    struct lost *lost = arg;
    struct charge charge = {0};
    if (lost->death && lost->death->end == PEN_WORKER_LEFT)
        return open_left(store, lost, st);
    bool crashed = lost->death && lost->death->end == PEN_WORKER_CRASHED;
    if (crashed && !find_charge(store, lost->worker, &charge, st))
        return false;
    if (!open_suspects(store, lost, st))
        return false;
    if (!charge.any)
        return true;
    if (charge.charges >= charge.max_attempts)
        lost->opened = 0; /* they were of this job alone */
    return write_charge(store, lost->death, &charge, st);
}

/* Reads first: most calls find nothing to do. */
static bool open_lost(struct pen_store *base, struct lost *lost, int *opened, struct pen_status *st)
{
    struct pen_sqlite_store *store = pen_sqlite_of(base);
    struct pen_sqlite_query query = lost_query(store, SQL_LOST_ANY, lost);
    bool any;
    if (!pen_sqlite_any_row(&query, &any, st))
        return false;
    if (any && !pen_sqlite_transaction(store, write_lost, lost, st))
        return false;
    *opened = lost->opened;
    return true;
}

bool pen_sqlite_expire_leases(struct pen_store *base, const char *dead_worker, int *opened,
                              struct pen_status *st)
{
    struct lost lost = {.worker = dead_worker, .before_ms = pen_clock_wall_ms()};
    return open_lost(base, &lost, opened, st);
}

bool pen_sqlite_worker_ended(struct pen_store *base, const struct pen_worker_death *death,
                             int *opened, struct pen_status *st)
{
    struct lost lost = {.worker = death->worker, .before_ms = INT64_MIN, .death = death};
    return open_lost(base, &lost, opened, st);
}
