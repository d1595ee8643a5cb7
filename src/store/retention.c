/* SPDX-License-Identifier: MIT */
/* What a store keeps: which ended jobs retention removes, and when new jobs are refused for lack of
 * space.
 *
 *   - Retention removes ended jobs, the earliest end first. A job stays for the minute after its
 *     end, in which its client fetches the results, unless the store holds more than keep_bytes.
 *     The limits are stored.
 *   - Removal by bytes starts at 7/8 of keep_bytes. It starts earlier if unfinished jobs, or a job
 *     that was refused in the last two minutes, need the space. It waits while space of removed
 *     jobs is still to be freed.
 *   - A new job is refused if the disk has less than 64 MiB free. It is also refused if the
 *     expected results of all unfinished jobs exceed what keep_bytes leaves, or half of keep_bytes.
 *     Half of keep_bytes is for ended jobs; a job that is the only unfinished one may exceed it. */
#include <stdatomic.h>
#include <stdio.h>

#include "store/internal/handle.h"

enum { GRACE_MS = 60000, WANTED_MS = 120000, DAY_MS = 86400000, SLACK_PART = 8 };
static const int64_t intake_bytes = INT64_C(64) << 20;
static const int64_t empty_bytes = INT64_C(320) << 10; /* the size of a store without jobs */

/* The expected results of a job that this process has refused lately. Retention makes space for
 * it. */
static _Atomic int64_t wanted_bytes, wanted_until_ms;

static int64_t wanted(int64_t now_ms)
{
    const int64_t left_ms = atomic_load(&wanted_until_ms) - now_ms;
    return left_ms > 0 && left_ms <= WANTED_MS ? atomic_load(&wanted_bytes) : 0;
}

bool pen_meta_get(struct pen_store *store, const char *name, int64_t *value, struct pen_status *st)
{
    return pen_db_value(store->db, st, value,
                        "SELECT CAST(value AS BIGINT) FROM meta WHERE name = $1", "t", name);
}

bool pen_meta_put(struct pen_store *store, const char *name, const char *text,
                  struct pen_status *st)
{
    return pen_db_run(store->db, st, NULL,
                      "INSERT INTO meta (name, value) VALUES ($1, $2) "
                      "ON CONFLICT (name) DO UPDATE SET value = excluded.value",
                      "tt", name, text);
}

bool pen_meta_set(struct pen_store *store, const char *name, int64_t value, struct pen_status *st)
{
    char text[24];
    snprintf(text, sizeof text, "%lld", (long long)value);
    return pen_meta_put(store, name, text, st);
}

bool pen_store_set_retention(struct pen_store *store, const struct pen_retention *retention,
                             struct pen_status *st)
{
    return pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_db_end(store->db,
                      pen_meta_set(store, "keep_ms", retention->keep_ms, st) &&
                          pen_meta_set(store, "keep_bytes", retention->keep_bytes, st) &&
                          pen_meta_set(store, "keep_jobs", retention->keep_jobs, st),
                      st);
}

/* What a store with a limit by bytes holds, and the free bytes of its disk. */
struct load {
    int64_t keep, used, left;
    int64_t expected; /* of unfinished jobs */
};

static bool read_load(struct pen_store *store, struct load *load, struct pen_status *st)
{
    *load = (struct load){0};
    return pen_meta_get(store, "keep_bytes", &load->keep, st) &&
           pen_db_space(store->db, load->keep > 0 ? &load->used : NULL, &load->left, st) &&
           (load->keep == 0 ||
            pen_db_value(store->db, st, &load->expected,
                         "SELECT CAST(coalesce(sum(results_bytes), 0) AS BIGINT) FROM job "
                         "WHERE state < 2",
                         ""));
}

static bool refuse_bytes(const struct load *load, const char *what, int64_t bytes,
                         struct pen_status *st)
{
    return pen_fail(st, PEN_STORAGE_FULL,
                    "the store has no space left for %s, about %lld KiB: it holds %lld KiB of the "
                    "%lld KiB that it may (--keep-bytes), and the jobs that wait or run take about "
                    "%lld KiB",
                    what, (long long)(bytes >> 10), (long long)(load->used >> 10),
                    (long long)(load->keep >> 10), (long long)(load->expected >> 10));
}

bool pen_intake(struct pen_store *store, int64_t bytes, struct pen_status *st)
{
    struct load load;
    int64_t now_ms;
    if (!read_load(store, &load, st) || !pen_db_now(store->db, &now_ms, st))
        return false;
    if (load.left < intake_bytes)
        return pen_fail(st, PEN_STORAGE_FULL,
                        "the store has no space left for new jobs: its disk has %lld KiB free, new "
                        "jobs need %lld KiB",
                        (long long)(load.left >> 10), (long long)(intake_bytes >> 10));
    if (load.keep == 0)
        return true;
    if (bytes > 0 && bytes > load.keep - empty_bytes)
        return pen_fail(st, PEN_TOO_LARGE,
                        "the results of this job take about %lld KiB, more than the %lld KiB that "
                        "the store may hold (--keep-bytes)",
                        (long long)(bytes >> 10), (long long)(load.keep >> 10));
    const int64_t all = load.expected + bytes;
    const bool half = bytes > 0 && load.expected > 0 && all > load.keep / 2;
    if (!half && load.used + all <= load.keep && load.used < load.keep) {
        if (bytes > 0 && bytes >= atomic_load(&wanted_bytes))
            atomic_store(&wanted_bytes, 0);
        return true;
    }
    if (!half && bytes > 0) {
        atomic_store(&wanted_bytes, bytes);
        atomic_store(&wanted_until_ms, now_ms + WANTED_MS);
    }
    return refuse_bytes(&load, "this job", bytes, st);
}

bool pen_store_intake(struct pen_store *store, struct pen_status *st)
{
    int64_t now_ms;
    return pen_db_begin(store->db, PEN_DB_WRITE, st) &&
           pen_db_end(store->db,
                      pen_intake(store, 0, st) && pen_db_now(store->db, &now_ms, st) &&
                          pen_meta_set(store, "probed_ms", now_ms, st),
                      st);
}

bool pen_admit_kept(struct pen_store *store, int64_t bytes, struct pen_status *st)
{
    struct load load;
    return read_load(store, &load, st) &&
           (load.keep == 0 || load.used + load.expected + bytes <= load.keep ||
            refuse_bytes(&load, "what a batch keeps", bytes, st));
}

/* Removal by age waits for a day after the clock has jumped ahead, which purge.c notes. */
bool pen_ages_wait(struct pen_store *store, int64_t now_ms, bool *wait, struct pen_status *st)
{
    int64_t from_ms, last_ms;
    if (!pen_meta_get(store, "ages_from_ms", &from_ms, st) ||
        !pen_meta_get(store, "purged_ms", &last_ms, st))
        return false;
    *wait = (from_ms > now_ms && from_ms - now_ms <= DAY_MS) ||
            (last_ms > 0 && now_ms - last_ms > DAY_MS);
    return true;
}

static bool find_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                         struct pen_status *st)
{
    int64_t keep_ms, keep_jobs, now_ms, soon, count = 0, end_ms = 0;
    struct load load;
    bool wait;
    if (!pen_meta_get(store, "keep_ms", &keep_ms, st) ||
        !pen_meta_get(store, "keep_jobs", &keep_jobs, st) || !pen_db_now(store->db, &now_ms, st) ||
        !pen_ages_wait(store, now_ms, &wait, st) || !read_load(store, &load, st) ||
        !pen_db_value(store->db, st, &soon,
                      "SELECT 1 WHERE EXISTS (SELECT 1 FROM job WHERE removed_ms > 0) OR "
                      "EXISTS (SELECT 1 FROM object WHERE state = 2)",
                      "") ||
        (keep_jobs > 0 &&
         !pen_db_value(store->db, st, &count,
                       "SELECT count(*) FROM job WHERE finished_ms > 0 AND removed_ms = 0", "")))
        return false;
    struct pen_rows *rows =
        pen_db_rows(store->db, st,
                    "SELECT id, finished_ms FROM job WHERE finished_ms > 0 AND removed_ms = 0 "
                    "ORDER BY finished_ms, number LIMIT 1",
                    "");
    const bool ended = pen_db_next(rows);
    if (ended) {
        snprintf(id, PEN_ID_BYTES, "%s", pen_db_text(rows, 0));
        end_ms = pen_db_int(rows, 1);
    }
    const int64_t age_ms = now_ms - end_ms;
    const bool above = load.keep > 0 && load.used > load.keep;
    const bool bytes = load.keep > 0 && !soon &&
                       (load.used > load.keep - load.keep / SLACK_PART ||
                        load.used + load.expected + wanted(now_ms) > load.keep);
    *found = ended && (above || age_ms > GRACE_MS) &&
             (bytes || (keep_ms > 0 && !wait && age_ms > keep_ms) ||
              (keep_jobs > 0 && count > keep_jobs));
    return pen_db_done(rows);
}

bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st)
{
    *found = false;
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(store->db, find_expired(store, id, found, st), st);
}
