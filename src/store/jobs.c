/* SPDX-License-Identifier: MIT */
/* Jobs as readers see them: a job, lists, counts. Also cancel and delete. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store/internal/handle.h"

enum { ROW_BYTES = 512 }; /* bytes of a removed job, besides its statistics */

#define COLUMNS                                                                                    \
    "number, id, state, revision, kind, request, error, priority, max_attempts, charges, "         \
    "timeout_ms, created_ms, started_ms, finished_ms, updated_ms, done_pixels, total_pixels, "     \
    "work, estimate_ms, told_us, elapsed_us, told_elapsed_us, queue_us"

void pen_job_record_release(struct pen_job_record *job)
{
    free(job->kind);
    free(job->request);
    free(job->error);
    job->kind = job->request = job->error = NULL;
}

size_t pen_job_record_text_bytes(const struct pen_job_record *job)
{
    return (job->request ? strlen(job->request) : 0) + (job->error ? strlen(job->error) : 0);
}

void pen_job_records_free(struct pen_job_record *jobs, int count)
{
    for (int i = 0; i < count; i++)
        pen_job_record_release(&jobs[i]);
    free(jobs);
}

static char *copy(struct pen_rows *rows, int column, bool *ok)
{
    const char *text = pen_db_text(rows, column);
    char *out = text ? strdup(text) : NULL;
    *ok = *ok && (!text || out);
    return out;
}

static bool fill(struct pen_rows *rows, struct pen_job_record *job, struct pen_status *st)
{
    bool ok = true;
    const int64_t attempts = pen_db_int(rows, 9) + 1, max_attempts = pen_db_int(rows, 8);
    *job = (struct pen_job_record){.number = pen_db_int(rows, 0),
                                   .state = (enum pen_job_state)pen_db_int(rows, 2),
                                   .revision = pen_db_int(rows, 3),
                                   .priority = (int)pen_db_int(rows, 7),
                                   .max_attempts = (int)max_attempts,
                                   .timeout_ms = pen_db_int(rows, 10),
                                   .created_ms = pen_db_int(rows, 11),
                                   .started_ms = pen_db_int(rows, 12),
                                   .finished_ms = pen_db_int(rows, 13),
                                   .updated_ms = pen_db_int(rows, 14),
                                   .done_pixels = pen_db_int(rows, 15),
                                   .total_pixels = pen_db_int(rows, 16),
                                   .work = pen_db_int(rows, 17),
                                   .estimate_ms = pen_db_int(rows, 18),
                                   .told_us = pen_db_int(rows, 19),
                                   .elapsed_us = pen_db_int(rows, 20),
                                   .told_elapsed_us = pen_db_int(rows, 21),
                                   .queue_us = pen_db_int(rows, 22)};
    if (job->started_ms > 0)
        job->attempts = (int)(attempts < max_attempts ? attempts : max_attempts);
    snprintf(job->id, sizeof job->id, "%s", pen_db_text(rows, 1));
    job->kind = copy(rows, 4, &ok);
    job->request = copy(rows, 5, &ok);
    job->error = copy(rows, 6, &ok);
    if (!ok)
        pen_job_record_release(job);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for a job");
}

static bool read_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                     struct pen_status *st)
{
    int64_t number;
    if (!pen_job_number(store, id, &number, NULL, st))
        return false;
    struct pen_rows *rows =
        pen_db_rows(store->db, st, "SELECT " COLUMNS " FROM job WHERE number = $1", "i", number);
    const bool filled = pen_db_next(rows) && fill(rows, job, st);
    return pen_db_done(rows) && filled;
}

bool pen_store_job(struct pen_store *store, const char *id, struct pen_job_record *job,
                   struct pen_status *st)
{
    *job = (struct pen_job_record){.number = 0};
    const bool ok = pen_db_begin(store->db, PEN_DB_READ, st) &&
                    pen_db_end(store->db, read_job(store, id, job, st), st);
    if (!ok) /* it may have been read before the end of the transaction failed */
        pen_job_record_release(job);
    return ok;
}

/* One statement for each index that may lead: a label, a name, a state, a kind, or the jobs
 * themselves. The other conditions are checked row by row. */
#define LIST(from, which, order)                                                                   \
    "SELECT " COLUMNS " FROM " from " WHERE " which " AND " order                                  \
    " < $1 AND removed_ms = 0 AND (state = $2 OR $2 < 0) AND (kind = $3 OR $3 = '') AND "          \
    "($4 = '' OR EXISTS (SELECT 1 FROM attribute AS a WHERE a.key = 'name' AND a.value = $4 AND "  \
    "a.job = number)) AND ($5 = '' OR EXISTS (SELECT 1 FROM attribute AS a WHERE a.key = $5 "      \
    "AND a.value = $6 AND a.job = number)) ORDER BY " order " DESC LIMIT $7"
#define OF_ATTRIBUTE(which)                                                                        \
    LIST("attribute JOIN job ON job.number = attribute.job", which, "attribute.job")

static const char *list_sql(const struct pen_job_filter *filter)
{
    if (filter->label_key)
        return OF_ATTRIBUTE("attribute.key = $5 AND attribute.value = $6");
    if (filter->name)
        return OF_ATTRIBUTE("attribute.key = 'name' AND attribute.value = $4");
    if (filter->state >= 0)
        return LIST("job", "state = $2", "number");
    return filter->kind ? LIST("job", "kind = $3", "number") : LIST("job", "number > 0", "number");
}

bool pen_store_jobs(struct pen_store *store, const struct pen_job_filter *filter,
                    struct pen_job_record **jobs, int *count, struct pen_status *st)
{
    char label[512] = "";
    size_t texts = 0;
    bool ok = true;
    *count = 0;
    *jobs = calloc(filter->limit > 0 ? (size_t)filter->limit : 1, sizeof **jobs);
    if (!*jobs)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a list of jobs");
    if (filter->label_key)
        snprintf(label, sizeof label, "label:%s", filter->label_key);
    struct pen_rows *rows = pen_db_rows(
        store->db, st, list_sql(filter), "iitttti", filter->below > 0 ? filter->below : INT64_MAX,
        (int64_t)filter->state, filter->kind ? filter->kind : "", filter->name ? filter->name : "",
        label, filter->label_value ? filter->label_value : "", (int64_t)filter->limit);
    bool full = false;
    while (!full && pen_db_next(rows) && (ok = fill(rows, &(*jobs)[*count], st))) {
        texts += pen_job_record_text_bytes(&(*jobs)[*count]);
        full = ++*count > 1 && filter->text_bytes > 0 && texts > filter->text_bytes;
    }
    ok = pen_db_done(rows) && ok;
    if (!ok) {
        pen_job_records_free(*jobs, *count);
        *jobs = NULL;
        *count = 0;
    }
    return ok;
}

static bool count_jobs(struct pen_store *store, int64_t jobs[PEN_JOB_STATE_COUNT],
                       struct pen_status *st)
{
    struct pen_rows *rows = pen_db_rows(
        store->db, st, "SELECT state, count(*) FROM job WHERE removed_ms = 0 GROUP BY state", "");
    memset(jobs, 0, PEN_JOB_STATE_COUNT * sizeof *jobs);
    while (pen_db_next(rows)) {
        const int64_t state = pen_db_int(rows, 0);
        if (state >= 0 && state < PEN_JOB_STATE_COUNT)
            jobs[state] = pen_db_int(rows, 1);
    }
    return pen_db_done(rows);
}

bool pen_store_job_counts(struct pen_store *store, int64_t jobs[PEN_JOB_STATE_COUNT],
                          struct pen_status *st)
{
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(store->db, count_jobs(store, jobs, st), st);
}

static bool read_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st)
{
    return count_jobs(store, counts->jobs, st) &&
           pen_row_numbers(
               pen_db_rows(
                   store->db, st,
                   "SELECT (SELECT count(*) FROM batch WHERE state = 0), "
                   "(SELECT count(*) FROM batch WHERE state = 1), (SELECT created_ms FROM job "
                   "WHERE state = 0 AND removed_ms = 0 ORDER BY number LIMIT 1)",
                   ""),
               &counts->open_batches, &counts->leased_batches, &counts->oldest_queued_ms, NULL);
}

bool pen_store_counts(struct pen_store *store, struct pen_counts *counts, struct pen_status *st)
{
    int64_t left;
    *counts = (struct pen_counts){0};
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(store->db,
                      read_counts(store, counts, st) &&
                          pen_db_space(store->db, &counts->bytes, &left, st),
                      st);
}

bool pen_store_check_client(struct pen_store *store, const char *id, const char *client,
                            struct pen_status *st)
{
    struct pen_rows *rows = pen_db_rows(store->db, st,
                                        "SELECT client FROM job WHERE id = $1 UNION ALL "
                                        "SELECT client FROM removed WHERE id = $1 LIMIT 1",
                                        "t", id);
    const bool found = pen_db_next(rows);
    const bool own = found && (!client || strcmp(pen_db_text(rows, 0), client) == 0);
    if (!pen_db_done(rows))
        return false;
    if (!found)
        return pen_fail(st, PEN_NOT_FOUND, "there is no job %s", id);
    return own ||
           pen_fail(
               st, PEN_FORBIDDEN,
               "job %s belongs to another client; a token of scope admin may cancel or delete it",
               id);
}

static bool cancel(struct pen_store *store, const char *id, const char *client,
                   struct pen_status *st)
{
    int64_t job, state;
    return pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_write_end(store,
                         pen_store_check_client(store, id, client, st) &&
                             pen_job_number(store, id, &job, &state, st) &&
                             (pen_job_state_ended((enum pen_job_state)state) ||
                              pen_job_end(store, job, PEN_JOB_CANCELLED, NULL, st)),
                         st);
}

/* A cancel or a delete that finds the disk full removes the reserve and is tried again. */
static bool gets_room(struct pen_store *store, const struct pen_status *st)
{
    return st->code == PEN_STORAGE_FULL && pen_db_give_reserve(store->db);
}

bool pen_store_cancel(struct pen_store *store, const char *id, const char *client,
                      struct pen_status *st)
{
    return cancel(store, id, client, st) || (gets_room(store, st) && cancel(store, id, client, st));
}

/* A second delete without statistics drops the statistics that the first delete left. If there are
 * none, the status stays. */
static bool drop_stats(struct pen_store *store, const char *id, struct pen_status *st)
{
    int64_t changed;
    return pen_db_run(store->db, st, &changed,
                      "UPDATE removed SET stats = NULL, bytes = 0 WHERE id = $1 AND bytes > 0", "t",
                      id) &&
           changed > 0;
}

static bool write_removed(struct pen_store *store, const char *id, const char *client,
                          const char *stats, struct pen_status *st)
{
    int64_t job, state;
    if (!pen_store_check_client(store, id, client, st))
        return false;
    if (!pen_job_number(store, id, &job, &state, st))
        return st->code == PEN_GONE && !stats && drop_stats(store, id, st);
    return (pen_job_state_ended((enum pen_job_state)state) ||
            pen_fail(st, PEN_CONFLICT, "job %s has not ended; cancel it first", id)) &&
           pen_db_run(store->db, st, NULL,
                      "INSERT INTO removed (id, client, removed_ms, stats, bytes) "
                      "SELECT id, client, (SELECT now_ms()), $2, $3 FROM job WHERE number = $1",
                      "iti", job, stats, stats ? (int64_t)strlen(stats) + ROW_BYTES : 0) &&
           pen_db_run(store->db, st, NULL,
                      "UPDATE job SET removed_ms = (SELECT now_ms()) WHERE number = $1", "i", job);
}

static bool delete (struct pen_store *store, const char *id, const char *client, const char *stats,
                    struct pen_status *st)
{
    return pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_write_end(store, write_removed(store, id, client, stats, st), st);
}

bool pen_store_delete(struct pen_store *store, const char *id, const char *client,
                      const char *stats, struct pen_status *st)
{
    return delete (store, id, client, stats, st) ||
           (gets_room(store, st) && delete (store, id, client, stats, st));
}

bool pen_store_removed_stats(struct pen_store *store, const char *id, struct pen_buf *stats,
                             struct pen_status *st)
{
    bool ok = true;
    struct pen_rows *rows =
        pen_db_rows(store->db, st, "SELECT stats FROM removed WHERE id = $1", "t", id);
    const bool found = pen_db_next(rows);
    const char *text = found ? pen_db_text(rows, 0) : NULL;
    const bool any = text != NULL;
    if (any)
        ok = pen_buf_puts(stats, text);
    if (!pen_db_done(rows))
        return false;
    if (!ok)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for statistics");
    return any || (found ? pen_fail(st, PEN_GONE, "job %s left no statistics", id)
                         : pen_fail(st, PEN_NOT_FOUND, "there is no removed job %s", id));
}

bool pen_store_cost_map(struct pen_store *store, const char *id, struct pen_buf *out,
                        struct pen_status *st)
{
    size_t bytes;
    bool ok = true;
    struct pen_rows *rows =
        pen_db_rows(store->db, st, "SELECT cost_map FROM job WHERE id = $1", "t", id);
    const void *map = pen_db_next(rows) ? pen_db_bytes(rows, 0, &bytes) : NULL;
    if (map)
        ok = pen_buf_add(out, map, bytes) || pen_fail(st, PEN_NO_MEMORY, "no memory for a map");
    return pen_db_done(rows) && ok;
}

static const char *const names[PEN_JOB_STATE_COUNT] = {"queued", "running", "succeeded", "failed",
                                                       "cancelled"};

const char *pen_job_state_name(enum pen_job_state state)
{
    return names[state];
}

bool pen_job_state_of_name(const char *name, enum pen_job_state *state)
{
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++) {
        if (strcmp(name, names[i]) == 0) {
            *state = (enum pen_job_state)i;
            return true;
        }
    }
    return false;
}
