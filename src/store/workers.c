/* SPDX-License-Identifier: MIT */
/* The list of workers, the processes behind it, and their counters. */
#include <sodium.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "store/internal/counters.h"
#include "store/internal/handle.h"

/* A process, with its start time, so that a later process with the same number is not taken for
 * it. */
struct process {
    char host[65], boot[24];
    int64_t pid, start; /* start: in clock ticks since the boot; 0: no such process */
};

/* A zombie process (ended, and not yet waited for) does not count. */
static int64_t start_of(int64_t pid)
{
    char path[64], text[1024];
    snprintf(path, sizeof path, "/proc/%lld/stat", (long long)pid);
    FILE *file = fopen(path, "re");
    if (!file)
        return 0;
    const size_t bytes = fread(text, 1, sizeof text - 1, file);
    fclose(file);
    text[bytes] = '\0';
    char *at = strrchr(text, ')'); /* the name before it may contain spaces */
    long long start = 0;
    if (at && (strncmp(at, ") Z", 3) == 0 || strncmp(at, ") X", 3) == 0))
        return 0;
    for (int field = 2; at && field < 22; field++)
        at = strchr(at + 1, ' ');
    return at && sscanf(at, "%lld", &start) == 1 ? start : 0;
}

static void this_process(struct process *own)
{
    *own = (struct process){.pid = getpid()};
    gethostname(own->host, sizeof own->host - 1);
    snprintf(own->boot, sizeof own->boot, "%lld", (long long)pen_clock_moment().boot);
    own->start = start_of(own->pid);
}

void pen_worker_id_make(char id[PEN_WORKER_ID_BYTES])
{
    unsigned char bits[(PEN_WORKER_ID_BYTES - 1) / 2];
    randombytes_buf(bits, sizeof bits);
    sodium_bin2hex(id, PEN_WORKER_ID_BYTES, bits, sizeof bits);
}

/* Adds the sums of the counts that processes have moved to the store. They are stored as numbers
 * with spaces. */
static bool add_sums(struct pen_store *store, struct pen_counters *sum, struct pen_status *st)
{
    struct pen_rows *rows =
        pen_db_rows(store->db, st, "SELECT value FROM meta WHERE name = 'counters'", "");
    const char *text = pen_db_next(rows) ? pen_db_text(rows, 0) : "";
    char *end;
    for (int i = 0; i < PEN_COUNTERS && *text; i++, text = end)
        sum->count[i] += strtoull(text, &end, 10);
    return pen_db_done(rows);
}

/* Moves the counts of this process to the sums, which stay when it ends. */
static bool move_counters(struct pen_store *store, const struct pen_counters *own,
                          struct pen_status *st)
{
    struct pen_counters sum = *own;
    struct pen_buf text = {0};
    if (!add_sums(store, &sum, st))
        return false;
    for (int i = 0; i < PEN_COUNTERS; i++) {
        pen_buf_number(&text, sum.count[i]);
        pen_buf_puts(&text, " ");
    }
    const bool ok = text.failed ? pen_fail(st, PEN_NO_MEMORY, "no memory for counters")
                                : pen_meta_put(store, "counters", (const char *)text.data, st);
    pen_buf_release(&text);
    return ok;
}

bool pen_store_counters(struct pen_store *store, struct pen_counters *counters,
                        struct pen_status *st)
{
    pen_counters_own(counters);
    return add_sums(store, counters, st);
}

static bool write_seen(struct pen_store *store, const struct pen_worker_new *worker,
                       struct pen_status *st)
{
    struct process own;
    this_process(&own);
    return pen_db_run(
        store->db, st, NULL,
        "INSERT INTO worker (id, host, boot, pid, start, supervisor, supervisor_start, threads, "
        "rays_per_s, lease_ms, started_ms, seen_ms) VALUES ($1, $2, $3, $4, $5, $6, $7, $8, $9, "
        "$10, (SELECT now_ms()), (SELECT now_ms())) ON CONFLICT (id) DO UPDATE SET "
        "rays_per_s = excluded.rays_per_s, lease_ms = excluded.lease_ms, "
        "threads = excluded.threads, seen_ms = excluded.seen_ms",
        "tttiiiiiii", worker->id, own.host, own.boot, own.pid, own.start,
        (int64_t)worker->supervisor, worker->supervisor > 0 ? start_of(worker->supervisor) : 0,
        (int64_t)worker->threads, worker->rays_per_s, worker->lease_ms);
}

/* Renews a worker's row, or removes the row of an id, and moves the counts of this process. */
static bool change_worker(struct pen_store *store, const struct pen_worker_new *worker,
                          const char *id, struct pen_status *st)
{
    struct pen_counters own;
    pen_counters_own(&own);
    if (!pen_db_begin(store->db, worker ? PEN_DB_PART : PEN_DB_WRITE, st) ||
        !pen_db_end(store->db,
                    (worker ? write_seen(store, worker, st)
                            : pen_db_run(store->db, st, NULL, "DELETE FROM worker WHERE id = $1",
                                         "t", id)) &&
                        move_counters(store, &own, st),
                    st))
        return false;
    pen_counters_take(&own);
    return true;
}

bool pen_store_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                           struct pen_status *st)
{
    return change_worker(store, worker, NULL, st);
}

bool pen_store_worker_gone(struct pen_store *store, const char *id, struct pen_status *st)
{
    return change_worker(store, NULL, id, st);
}

/* Returns true if a process exists. `unknown` is the answer if its start time is not known. */
static bool exists(int64_t pid, int64_t start, bool unknown)
{
    return start > 0 ? start_of(pid) == start : unknown;
}

/* Finds the next worker of this host, in order of ids, whose process and supervisor no longer
 * exist. */
static bool find_gone(struct pen_store *store, const struct process *own,
                      char id[PEN_WORKER_ID_BYTES], bool *found, struct pen_status *st)
{
    struct pen_rows *rows =
        pen_db_rows(store->db, st,
                    "SELECT id, boot, pid, start, supervisor, supervisor_start FROM worker "
                    "WHERE host = $1 AND id > $2 ORDER BY id",
                    "tt", own->host, id);
    *found = false;
    while (!*found && pen_db_next(rows)) {
        *found = strcmp(pen_db_text(rows, 1), own->boot) != 0 ||
                 (!exists(pen_db_int(rows, 2), pen_db_int(rows, 3), true) &&
                  !exists(pen_db_int(rows, 4), pen_db_int(rows, 5), false));
        if (*found)
            snprintf(id, PEN_WORKER_ID_BYTES, "%s", pen_db_text(rows, 0));
    }
    return pen_db_done(rows);
}

bool pen_store_release_gone(struct pen_store *store, int *opened, struct pen_status *st)
{
    struct pen_worker_death death = {.end = PEN_WORKER_DIED};
    char id[PEN_WORKER_ID_BYTES] = "";
    struct process own;
    bool found;
    this_process(&own);
    *opened = 0;
    while (find_gone(store, &own, id, &found, st)) {
        int more;
        if (!found)
            return true;
        death.worker = id;
        if (!pen_store_worker_ended(store, &death, &more, st) ||
            !pen_store_worker_gone(store, id, st))
            return false;
        *opened += more;
    }
    return false;
}

static void fill(struct pen_rows *rows, struct pen_worker_record *worker)
{
    *worker = (struct pen_worker_record){.id = pen_db_text(rows, 0),
                                         .host = pen_db_text(rows, 1),
                                         .pid = pen_db_int(rows, 2),
                                         .threads = (int)pen_db_int(rows, 3),
                                         .rays_per_s = pen_db_int(rows, 4),
                                         .started_ms = pen_db_int(rows, 5),
                                         .seen_ms = pen_db_int(rows, 6),
                                         .job_id = pen_db_text(rows, 7),
                                         .job_kind = pen_db_text(rows, 8),
                                         .view = pen_db_text(rows, 9),
                                         .batch = pen_db_int(rows, 10),
                                         .attempt = pen_db_int(rows, 11),
                                         .kind = (enum pen_batch_kind)pen_db_int(rows, 12),
                                         .pixels = pen_db_int(rows, 13)};
    const int64_t told_ms =
        pen_db_int(rows, 14); /* when the worker took the lease or last extended it */
    if (worker->job_id && told_ms > worker->seen_ms)
        worker->seen_ms = told_ms;
}

/* Few batches are leased. IN and COALESCE keep SQLite from building an index of all batches
 * here. */
bool pen_store_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                       struct pen_status *st)
{
    struct pen_worker_record worker;
    bool more = true;
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "SELECT worker.id, host, pid, threads, rays_per_s, worker.started_ms, seen_ms, job.id, "
        "job.kind, view.name, batch.number, batch.attempt, batch.kind, batch.pixels, "
        "batch.lease_ms - worker.lease_ms FROM worker "
        "LEFT JOIN batch ON batch.number IN (SELECT number FROM batch WHERE state = 1) "
        "AND COALESCE(batch.worker, '') = worker.id "
        "LEFT JOIN job ON job.number = batch.job "
        "LEFT JOIN view ON view.job = batch.job AND view.view = batch.view "
        "ORDER BY worker.started_ms, worker.id, batch.number",
        "");
    while (more && pen_db_next(rows)) {
        fill(rows, &worker);
        more = each(user, &worker);
    }
    return pen_db_done(rows);
}
