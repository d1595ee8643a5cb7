/* SPDX-License-Identifier: MIT */
/* How much a store keeps: which ended jobs retention removes, when new jobs are refused for lack of
 * space, and which cached artefacts are dropped.
 *
 *  - Retention removes ended jobs, those that ended first before others, and none in the minute
 *    after its end, in which its client fetches the results, unless the store holds more than
 *    keep_bytes. Its limits are the store's. An end in the future, by a clock that was ahead,
 *    becomes the time at which housekeeping finds it (purge.c).
 *  - By bytes it begins an eighth below keep_bytes, or where unfinished jobs and a job that was
 *    refused in the last two minutes need the space. It waits while space of removed jobs is still
 *    to become free.
 *  - A new job is refused where the disk has less than 64 MiB free, or if the results of all
 *    unfinished jobs are expected to take more than what keep_bytes leaves, or more than half of
 *    it unless it is the only one: the other half is for what has ended.
 *  - Cached artefacts have 256 MiB together, or an eighth of keep_bytes. They count for nothing in
 *    the rules above, and where space is short they are not stored. */
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store/internal/objects.h"
#include "store/internal/retention.h"

enum {
    GRACE_MS = 60000,
    WANTED_MS = 120000,
    DAY_MS = 86400000,
    RESULT_BYTES = 10,   /* of a pixel: its picture and what its batch has stored (2 to 8) */
    LAYER_BYTES = 12,    /* of a pixel of a layer beside the picture: three floats */
    SLACK_PART = 8,      /* retention by bytes begins an eighth below the limit */
    UNFINISHED_PART = 2, /* the results of unfinished jobs: half of the limit at most */
    CACHE_PART = 8       /* cached artefacts: an eighth of keep_bytes at most */
};
static const int64_t intake_bytes = INT64_C(64) << 20, cache_bytes = INT64_C(256) << 20;
static const int64_t empty_bytes = INT64_C(320) << 10; /* what a store without jobs takes */

/* The results of a job that this process has refused lately; retention makes room for it. */
static _Atomic int64_t wanted_bytes, wanted_until_ms;

static int64_t wanted(int64_t now_ms)
{
    const int64_t left_ms = atomic_load(&wanted_until_ms) - now_ms;
    return left_ms > 0 && left_ms <= WANTED_MS ? atomic_load(&wanted_bytes) : 0;
}

int64_t pen_results_bytes(int64_t pixels, int64_t layers)
{
    return pixels * (RESULT_BYTES + layers * LAYER_BYTES);
}

bool pen_meta_get(struct pen_store *store, const char *name, int64_t *value, struct pen_status *st)
{
    struct pen_rows *rows =
        pen_db_rows(store->db, st, "SELECT value FROM meta WHERE name = $1", "t", name);
    *value = pen_db_next(rows) ? strtoll(pen_db_text(rows, 0), NULL, 10) : 0;
    return pen_db_done(rows);
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

static bool read_limits(struct pen_store *store, struct pen_retention *out, struct pen_status *st)
{
    return pen_meta_get(store, "keep_ms", &out->keep_ms, st) &&
           pen_meta_get(store, "keep_bytes", &out->keep_bytes, st) &&
           pen_meta_get(store, "keep_jobs", &out->keep_jobs, st);
}

/* What a store with a limit by bytes has to hold, and what its disk has left. */
struct load {
    int64_t keep, used, left;
    int64_t expected; /* of unfinished jobs */
    int64_t cached;   /* what used has of cached artefacts */
};

static bool read_load(struct pen_store *store, struct load *load, struct pen_status *st)
{
    *load = (struct load){0};
    if (!pen_meta_get(store, "keep_bytes", &load->keep, st) ||
        !pen_db_space(store->db, load->keep > 0 ? &load->used : NULL, &load->left, st))
        return false;
    if (load->keep == 0)
        return true;
    struct pen_rows *rows = pen_db_rows(
        store->db, st,
        "SELECT (SELECT CAST(coalesce(sum(results_bytes), 0) AS BIGINT) FROM job WHERE state < 2), "
        "(SELECT CAST(coalesce(sum(bytes), 0) AS BIGINT) FROM object WHERE cached = 1 AND state = "
        "1)",
        "");
    if (pen_db_next(rows)) {
        load->expected = pen_db_int(rows, 0);
        load->cached = pen_db_int(rows, 1);
        load->used -= load->cached;
    }
    return pen_db_done(rows);
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
                        "the store has no space left for new jobs: its disk has %lld KiB free, "
                        "they are taken from %lld KiB on",
                        (long long)(load.left >> 10), (long long)(intake_bytes >> 10));
    if (load.keep == 0)
        return true;
    if (bytes > 0 && bytes > load.keep - empty_bytes)
        return pen_fail(st, PEN_TOO_LARGE,
                        "the results of this job take about %lld KiB, more than the %lld KiB that "
                        "the store may hold (--keep-bytes)",
                        (long long)(bytes >> 10), (long long)(load.keep >> 10));
    const int64_t all = load.expected + bytes;
    const bool half = bytes > 0 && load.expected > 0 && all > load.keep / UNFINISHED_PART;
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

/* Whether retention by bytes removes a job now. */
static bool find_excess(struct pen_store *store, int64_t now_ms, bool *any, bool *above,
                        struct pen_status *st)
{
    struct load load;
    int64_t soon;
    *any = *above = false;
    if (!read_load(store, &load, st))
        return false;
    if (load.keep == 0)
        return true;
    if (!pen_db_value(store->db, st, &soon,
                      "SELECT 1 WHERE EXISTS (SELECT 1 FROM job WHERE removed_ms > 0) OR "
                      "EXISTS (SELECT 1 FROM object WHERE state = 2)",
                      ""))
        return false;
    *above = load.used > load.keep;
    *any = soon == 0 && (load.used > load.keep - load.keep / SLACK_PART ||
                         load.used + load.expected + wanted(now_ms) > load.keep);
    return true;
}

/* By age nothing goes for a day after the clock has jumped ahead (purge.c notes that). */
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
    struct pen_retention keep;
    int64_t now_ms, count = 0, end_ms = 0;
    bool any, above, wait;
    if (!read_limits(store, &keep, st) || !pen_db_now(store->db, &now_ms, st) ||
        !pen_ages_wait(store, now_ms, &wait, st) || !find_excess(store, now_ms, &any, &above, st) ||
        (keep.keep_jobs > 0 &&
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
    *found = ended && (above || age_ms > GRACE_MS) &&
             (any || (keep.keep_ms > 0 && !wait && age_ms > keep.keep_ms) ||
              (keep.keep_jobs > 0 && count > keep.keep_jobs));
    return pen_db_done(rows);
}

bool pen_store_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                       struct pen_status *st)
{
    *found = false;
    return pen_db_begin(store->db, PEN_DB_READ, st) &&
           pen_db_end(store->db, find_expired(store, id, found, st), st);
}

/* What cached artefacts may have together. */
static int64_t cache_share(const struct load *load)
{
    const int64_t part = load->keep / CACHE_PART;
    return load->keep > 0 && part < cache_bytes ? part : cache_bytes;
}

/* Drops those that were used longest ago, until the others have so many bytes at most. */
static bool evict(struct pen_store *store, int64_t most, int64_t *dropped, struct pen_status *st)
{
    int64_t bytes, number = 1;
    *dropped = 0;
    if (!pen_db_value(store->db, st, &bytes,
                      "SELECT CAST(coalesce(sum(bytes), 0) AS BIGINT) FROM object "
                      "WHERE cached = 1 AND state = 1",
                      ""))
        return false;
    while (bytes > most && bytes > 0 && number > 0) {
        struct pen_rows *rows =
            pen_db_rows(store->db, st,
                        "UPDATE object SET state = 2 WHERE number = (SELECT number FROM object "
                        "WHERE cached = 1 AND state = 1 ORDER BY used_ms, number LIMIT 1) "
                        "RETURNING number, bytes",
                        "");
        number = pen_db_next(rows) ? pen_db_int(rows, 0) : 0;
        if (number > 0) {
            bytes -= pen_db_int(rows, 1);
            (*dropped)++;
        }
        if (!pen_db_done(rows))
            return false;
    }
    return true;
}

/* How much larger the store may become by them: the disk keeps twice what intake needs. */
static int64_t cache_left(const struct load *load)
{
    const int64_t of_disk = load->left - 2 * intake_bytes;
    const int64_t of_keep = load->keep - load->used - load->cached - load->expected;
    return load->keep > 0 && of_keep < of_disk ? of_keep : of_disk;
}

bool pen_cache_trim(struct pen_store *store, int64_t *dropped, struct pen_status *st)
{
    struct load load;
    int64_t most;
    if (!read_load(store, &load, st))
        return false;
    most = cache_share(&load);
    if (cache_left(&load) < 0)
        most = 0;
    return evict(store, most, dropped, st);
}

bool pen_store_cache_put(struct pen_store *store, const char *id, int view, const char *layer,
                         const char *format, const void *data, size_t bytes, struct pen_status *st)
{
    struct pen_object_owner owner = {
        .view = view, .layer = layer, .format = format, .cached = true};
    struct load load;
    int64_t number, dropped, state;
    if (!pen_db_begin(store->db, PEN_DB_READ, st) ||
        !pen_db_end(store->db,
                    pen_job_number(store, id, &owner.job, NULL, st) && read_load(store, &load, st),
                    st))
        return false;
    if ((int64_t)bytes > cache_share(&load) || (int64_t)bytes > cache_left(&load))
        return true;
    if (!pen_object_load(store, &owner, NULL, data, bytes, &number, st) ||
        !pen_db_begin(store->db, PEN_DB_PART, st))
        return false;
    return pen_db_end(store->db,
                      pen_job_number(store, id, &owner.job, &state, st) &&
                          evict(store, cache_share(&load) - (int64_t)bytes, &dropped, st) &&
                          pen_object_use(store, &owner, number, data, bytes, st),
                      st);
}
