/* SPDX-License-Identifier: MIT */
/* Who works on the store. A worker says now and then that it is there; what it is doing is known
 * from its leases, and a lease that was extended says that its holder lives. */
#include "base/clock.h"
#include "store/sqlite/sqlite.h"

struct presence {
    const char *name;
    int threads;
    int64_t lease_ms;
};

static bool write_presence(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct presence *presence = arg;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_WORKER_SEEN);
    pen_sqlite_text(&query, presence->name);
    pen_sqlite_int(&query, presence->threads);
    pen_sqlite_int(&query, presence->lease_ms);
    pen_sqlite_int(&query, pen_clock_wall_ms());
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_worker_seen(struct pen_store *base, const char *name, int threads, int64_t lease_ms,
                            struct pen_status *st)
{
    struct presence presence = {name, threads, lease_ms};
    return pen_sqlite_transaction(pen_sqlite_of(base), write_presence, &presence, st);
}

static bool remove_worker(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_WORKER_GONE);
    pen_sqlite_text(&query, arg);
    return pen_sqlite_run(&query, st);
}

bool pen_sqlite_worker_gone(struct pen_store *base, const char *name, struct pen_status *st)
{
    return pen_sqlite_transaction(pen_sqlite_of(base), remove_worker, (void *)(uintptr_t)name, st);
}

struct listing {
    pen_worker_fn *each;
    void *user;
};

static struct pen_worker_record worker_record(const struct pen_sqlite_query *row)
{
    return (struct pen_worker_record){
        .name = pen_sqlite_column_text(row, 0),
        .threads = (int)pen_sqlite_column_int(row, 1),
        .started_ms = pen_sqlite_column_int(row, 2),
        .seen_ms = pen_sqlite_column_int(row, 3),
        .job_id = pen_sqlite_column_text(row, 4),
        .view = pen_sqlite_column_text(row, 5),
        .batch = pen_sqlite_column_int(row, 6),
        .attempt = pen_sqlite_column_int(row, 7),
        .kind = (enum pen_batch_kind)pen_sqlite_column_int(row, 8),
        .pixels = pen_sqlite_column_int(row, 9),
    };
}

static bool read_workers(struct pen_sqlite_store *store, void *arg, struct pen_status *st)
{
    const struct listing *listing = arg;
    struct pen_sqlite_query query = pen_sqlite_query(store, SQL_WORKER_LIST);
    bool ok = true, row = true, more = true;
    while (ok && row && more) {
        ok = pen_sqlite_next(&query, &row, st);
        if (ok && row) {
            struct pen_worker_record worker = worker_record(&query);
            more = listing->each(listing->user, &worker);
        }
    }
    pen_sqlite_end(&query);
    return ok;
}

bool pen_sqlite_workers(struct pen_store *base, pen_worker_fn *each, void *user,
                        struct pen_status *st)
{
    struct listing listing = {each, user};
    return pen_sqlite_snapshot(pen_sqlite_of(base), read_workers, &listing, st);
}
