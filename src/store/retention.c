/* SPDX-License-Identifier: MIT */
/* How much a store keeps: which ended jobs retention removes, when new jobs are refused because
 * space runs short, and which stored forms of pictures are dropped.
 *
 *  - Retention removes ended jobs, those that ended first before others, never a live one, and none
 *    in the minute after its end, in which its client fetches the results. Its limits are the
 *    store's: they are stored, so that all processes follow the same.
 *  - By bytes it removes nothing unless all that it could remove would be enough: below keep_bytes,
 *    or where it begins, if the store is below keep_bytes.
 *  - By bytes it begins an eighth below keep_bytes. New jobs are refused at keep_bytes itself, so
 *    that what running jobs still have to store finds space in between.
 *  - New jobs are also refused while the disk has less free space than INTAKE_PART of it. So
 *    running jobs can be finished, and the disk does not fill.
 *  - A form of a picture that was made for a reader can be made again. All of them together have
 *    CACHE_BYTES at most, and go first when the disk runs short. */
#include <string.h>

#include "base/log.h"
#include "store/internal/policy.h"

enum {
    INTAKE_PART = 32, /* new jobs: a 32nd of the disk must be free, … */
    STATS_ROWS = 100, /* statistics of removed jobs that go at once, if nothing else is left */
    TOUCH_MS = 60000, /* a use is noted once a minute */
    TELL_MS = 600000, /* between log lines about a store that is too large */
    GRACE_MS = 60000, /* how long a job is kept at least after its end */
    SLACK_PART = 8,   /* retention by bytes begins an eighth below the limit */
    CACHE_PART = 8    /* cached forms: an eighth of keep_bytes at most */
};
static const int64_t intake_min_bytes = INT64_C(1) << 20, intake_max_bytes = INT64_C(64) << 20;
static const int64_t cache_bytes = INT64_C(256) << 20;

static const char *const names[] = {"keep_ms", "keep_bytes", "keep_jobs"};

static bool write_retention(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct pen_retention *r = arg;
    const int64_t values[] = {r->keep_ms, r->keep_bytes, r->keep_jobs};
    for (int i = 0; i < 3; i++) {
        if (!store->driver->ops->meta_put(store->driver, names[i], values[i], st))
            return false;
    }
    return true;
}

bool pen_policy_set_retention(struct pen_store *store, const struct pen_retention *retention,
                              struct pen_status *st)
{
    return pen_store_write(store, write_retention, (void *)(uintptr_t)retention, st);
}

bool pen_policy_retention(struct pen_store *store, struct pen_retention *out, struct pen_status *st)
{
    int64_t *const values[] = {&out->keep_ms, &out->keep_bytes, &out->keep_jobs};
    for (int i = 0; i < 3; i++) {
        if (!store->driver->ops->meta_get(store->driver, names[i], values[i], st))
            return false;
    }
    return true;
}

/* What the store and its disk have, and what it may hold. */
static bool read_room(struct pen_store *store, struct pen_room *room, int64_t *keep_bytes,
                      struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    return driver->ops->room(driver, room, st) &&
           driver->ops->meta_get(driver, "keep_bytes", keep_bytes, st);
}

/* The free space of the disk below which no new job is taken. */
static int64_t intake_bytes(const struct pen_room *room)
{
    int64_t part = room->disk_bytes / INTAKE_PART;
    if (part < intake_min_bytes)
        return intake_min_bytes;
    return part < intake_max_bytes ? part : intake_max_bytes;
}

bool pen_policy_intake(struct pen_store *store, struct pen_status *st)
{
    const char *name = store->driver->name;
    struct pen_room room;
    int64_t keep_bytes;
    if (!read_room(store, &room, &keep_bytes, st))
        return false;
    if (room.disk_bytes > 0 && room.disk_free_bytes < intake_bytes(&room))
        return pen_fail(st, PEN_STORAGE_FULL,
                        "the store %s has no space left for new jobs: its disk has %lld KiB free, "
                        "they are taken from %lld KiB on",
                        name, (long long)(room.disk_free_bytes >> 10),
                        (long long)(intake_bytes(&room) >> 10));
    return keep_bytes == 0 || room.used_bytes < keep_bytes ||
           pen_fail(st, PEN_STORAGE_FULL,
                    "the store %s has no space left for new jobs: it holds %lld KiB of the %lld "
                    "KiB that it may (--keep-bytes)",
                    name, (long long)(room.used_bytes >> 10), (long long)(keep_bytes >> 10));
}

/* Logs, now and then, that the store is too large by what retention does not remove. */
static bool tell_that_it_stays(struct pen_store *store, int64_t bytes, struct pen_status *st)
{
    int64_t now_ms;
    if (!store->driver->ops->now(store->driver, &now_ms, st))
        return false;
    if (now_ms - store->told_ms >= TELL_MS || now_ms < store->told_ms) {
        store->told_ms = now_ms;
        pen_log(PEN_LOG_WARN,
                "the store %s is too large, by %lld KiB even without all ended jobs and "
                "statistics, which therefore stay: unfinished jobs and idempotency keys need more "
                "than --keep-bytes allows",
                store->driver->name, (long long)((bytes + 1023) >> 10));
    }
    return true;
}

/* Whether the store holds more than retention allows, and ended jobs and statistics are the reason:
 * if all of them are too little, they would go for nothing, and stay. That is not told while
 * something is still to go that was removed already, or is on its way into the store and may
 * replace something. */
static bool has_too_many_bytes(struct pen_store *store, int64_t keep_bytes, bool *too_many,
                               struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_job_key removed;
    struct pen_room room;
    int64_t object, bytes;
    bool pending, unused;
    *too_many = false;
    if (keep_bytes == 0)
        return true;
    if (!driver->ops->removed_next(driver, &removed, &pending, st) ||
        !driver->ops->object_unused(driver, INT64_MAX, &object, &unused, st) ||
        !driver->ops->room(driver, &room, st))
        return false;
    const int64_t begin_bytes = keep_bytes - keep_bytes / SLACK_PART,
                  most = room.used_bytes < keep_bytes ? begin_bytes : keep_bytes - 1,
                  excess = room.used_bytes - most;
    if (pending || unused || excess <= 0)
        return true;
    if (!driver->ops->ended_bytes(driver, excess, &bytes, st))
        return false;
    *too_many = bytes >= excess;
    return *too_many || tell_that_it_stays(store, excess - bytes, st);
}

static bool write_drop_stats(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->removed_purge(store->driver, INT64_MAX, INT64_MAX, STATS_ROWS, arg,
                                             st);
}

bool pen_policy_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                        struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_retention keep;
    int64_t ended_ms, count, now_ms;
    bool any, too_many, more;
    *found = false;
    if (!pen_policy_retention(store, &keep, st))
        return false;
    if (keep.keep_ms == 0 && keep.keep_bytes == 0 && keep.keep_jobs == 0)
        return true;
    if (!driver->ops->first_ended(driver, id, &ended_ms, &count, &any, st) ||
        !driver->ops->now(driver, &now_ms, st) ||
        !has_too_many_bytes(store, keep.keep_bytes, &too_many, st))
        return false;
    if (!any)
        return !too_many || pen_store_write(store, write_drop_stats, &more, st);
    *found = ended_ms < now_ms - GRACE_MS &&
             (too_many || (keep.keep_ms > 0 && ended_ms < now_ms - keep.keep_ms) ||
              (keep.keep_jobs > 0 && count > keep.keep_jobs));
    return true;
}

/* How many bytes all cached forms may have; 0 if the disk runs short. */
static bool cache_limit(struct pen_store *store, int64_t *limit, struct pen_status *st)
{
    struct pen_room room;
    int64_t keep_bytes;
    if (!read_room(store, &room, &keep_bytes, st))
        return false;
    *limit = cache_bytes;
    if (keep_bytes > 0 && keep_bytes / CACHE_PART < *limit)
        *limit = keep_bytes / CACHE_PART;
    if (room.disk_bytes > 0 && room.disk_free_bytes < 2 * intake_bytes(&room))
        *limit = 0;
    return true;
}

/* Drops the forms that were used longest ago until the others have at most `limit` bytes. */
static bool evict(struct pen_store *store, int64_t limit, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    int64_t bytes;
    if (!driver->ops->cached_bytes(driver, &bytes, st))
        return false;
    while (bytes > limit) {
        if (!driver->ops->cached_evict(driver, &bytes, st))
            return false;
    }
    return true;
}

struct cached {
    const struct pen_artefact_key *key;
    const char *id;
    struct pen_value value;
    int64_t limit;
};

static bool write_cached(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct cached *in = arg;
    struct pen_driver *driver = store->driver;
    struct pen_artefact_key key = *in->key;
    struct pen_job_key job;
    int64_t number, now_ms;
    if (!evict(store, in->limit - (int64_t)in->value.bytes, st) ||
        !pen_find_job(store, in->id, &job, st) || !driver->ops->now(driver, &now_ms, st))
        return false;
    key.job = job.number;
    return pen_put_artefact(store, &key, &in->value, &number, st) &&
           driver->ops->cached_put(driver, number, (int64_t)in->value.bytes, now_ms, st);
}

bool pen_policy_cache_put(struct pen_store *store, const char *id,
                          const struct pen_artefact_key *key, const void *data, size_t bytes,
                          struct pen_status *st)
{
    struct cached in = {.key = key, .id = id};
    if (!cache_limit(store, &in.limit, st))
        return false;
    if ((int64_t)bytes > in.limit)
        return true;
    if (!pen_value_store(store, NULL, data, bytes, &in.value, st))
        return false;
    const bool ok = pen_store_write(store, write_cached, &in, st);
    if (!ok)
        pen_value_drop(store, &in.value);
    return ok;
}

static bool write_evict(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->cached_evict(store->driver, arg, st);
}

bool pen_policy_evict(struct pen_store *store, bool *more, struct pen_status *st)
{
    int64_t limit, bytes;
    *more = false;
    if (!cache_limit(store, &limit, st) ||
        !store->driver->ops->cached_bytes(store->driver, &bytes, st))
        return false;
    *more = bytes > limit;
    return !*more || pen_store_write(store, write_evict, &bytes, st);
}

struct touch {
    int64_t artefact, now_ms;
};

static bool write_touch(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct touch *touch = arg;
    return store->driver->ops->cached_touch(store->driver, touch->artefact, touch->now_ms, st);
}

void pen_note_use(struct pen_store *store, const struct pen_artefact_row *artefact)
{
    struct touch touch = {.artefact = artefact->number};
    struct pen_status ignored;
    int64_t limit;
    if (!artefact->cached || !store->driver->ops->now(store->driver, &touch.now_ms, &ignored) ||
        touch.now_ms - artefact->used_ms <= TOUCH_MS || !cache_limit(store, &limit, &ignored) ||
        limit == 0)
        return;
    pen_store_write(store, write_touch, &touch, &ignored);
    store->outcome_unknown = false;
}
