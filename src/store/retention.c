/* SPDX-License-Identifier: MIT */
/* How much a store keeps: which ended jobs retention removes, when new jobs are refused because
 * space runs short, and which stored forms of pictures are dropped.
 *
 *  - Retention removes ended jobs, those that ended first before others, never a live one, and none
 *    in the minute after its end, in which its client fetches the results, unless the store holds
 *    more than keep_bytes. Its limits are the store's: they are stored, so that all processes
 *    follow the same.
 *  - By age it waits a day if the clock has jumped ahead (pen_ages_wait).
 *  - By bytes it begins an eighth below keep_bytes, or where a job was just refused for lack of
 *    space, as far as that job needs. It removes nothing unless all that it could remove would be
 *    enough: below keep_bytes, or where it begins, if the store is below keep_bytes.
 *  - Of removed jobs the statistics stay. All of them together have an eighth of keep_bytes at
 *    most; the oldest go, before any ended job does.
 *  - A new job is refused if the results of all unfinished jobs are expected to take more than
 *    what keep_bytes leaves, or more than half of it unless the job is the only one: the other half
 *    is for what has ended. What they take is expected from their pixels and layers, and counted
 *    with them, so that a submit looks at no other job.
 *  - What a batch keeps is stored only if the store holds no more than keep_bytes with it and with
 *    what unfinished jobs are expected to store. What it replaces takes its space until it is gone.
 *  - New jobs are also refused while the disk has less free space than INTAKE_PART of it. So
 *    running jobs can be finished, and the disk does not fill.
 *  - A form of a picture that was made for a reader can be made again. All of them together have
 *    cache_bytes at most, those included that were removed but are not gone yet. They grow only as
 *    far as the disk keeps twice what intake needs, and the log's space; if it has less, those go
 *    that were used longest ago. The same holds for keep_bytes and what unfinished jobs are
 *    expected to store. A form without space is not stored. In the rules above forms do not count.
 */
#include <string.h>

#include "base/log.h"
#include "store/internal/policy.h"

enum {
    INTAKE_PART = 32,    /* new jobs: a 32nd of the disk must be free, … */
    STATS_ROWS = 100,    /* statistics of removed jobs that go in one transaction */
    STATS_PART = 8,      /* statistics: an eighth of keep_bytes at most */
    TOUCH_MS = 60000,    /* a use is noted once a minute */
    TELL_MS = 600000,    /* between log lines about a store that is too large */
    GRACE_MS = 60000,    /* how long a job is kept at least after its end */
    WRITING_MS = 60000,  /* how long retention waits for values that are being written */
    SLACK_PART = 8,      /* retention by bytes begins an eighth below the limit */
    UNFINISHED_PART = 2, /* the results of unfinished jobs: half of the limit at most */
    CACHE_PART = 8       /* cached forms: an eighth of keep_bytes at most */
};
static const int64_t intake_min_bytes = INT64_C(1) << 20, intake_max_bytes = INT64_C(64) << 20;
static const int64_t empty_bytes = INT64_C(256) << 10; /* what a store without jobs takes */
static const int64_t cache_bytes = INT64_C(256) << 20;

static const char *const names[] = {"keep_ms", "keep_bytes", "keep_jobs"};
static const char ahead_name[] = "ahead_ms"; /* since when jobs are found that ended ahead of now */

static bool write_retention(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct pen_retention *r = arg;
    const int64_t values[] = {r->keep_ms, r->keep_bytes, r->keep_jobs};
    for (int i = 0; i < 3; i++) {
        if (!store->driver->ops->meta_put(store->driver, names[i], values[i], st))
            return false;
    }
    return store->driver->ops->expected_count(store->driver, r->keep_bytes > 0, st) &&
           store->driver->ops->stats_count(store->driver, r->keep_bytes > 0, st);
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

/* Forms of pictures give way to all else, so that they count for nothing where space is short. */
static bool leave_out_forms(struct pen_store *store, int64_t *used, struct pen_status *st)
{
    int64_t bytes;
    if (!store->driver->ops->cached_bytes(store->driver, &bytes, st))
        return false;
    *used -= bytes;
    return true;
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
    if (keep_bytes > 0 && room.used_bytes >= keep_bytes &&
        !leave_out_forms(store, &room.used_bytes, st))
        return false;
    return keep_bytes == 0 || room.used_bytes < keep_bytes ||
           pen_fail(st, PEN_STORAGE_FULL,
                    "the store %s has no space left for new jobs: it holds %lld KiB of the %lld "
                    "KiB that it may (--keep-bytes)",
                    name, (long long)(room.used_bytes >> 10), (long long)(keep_bytes >> 10));
}

/* What a store with a limit by bytes has to hold. */
struct load {
    int64_t keep, used, expected; /* expected: of unfinished jobs */
};

/* Where retention by bytes begins. */
static int64_t slack_begin(const struct load *load)
{
    return load->keep - load->keep / SLACK_PART;
}

/* `more` bytes are asked for. */
static bool read_load(struct pen_store *store, int64_t more, struct load *load,
                      struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_room room;
    if (!driver->ops->room(driver, &room, st) ||
        !driver->ops->meta_get(driver, "expected_bytes", &load->expected, st))
        return false;
    load->used = room.used_bytes;
    return load->used + load->expected + more <= slack_begin(load) ||
           leave_out_forms(store, &load->used, st);
}

static bool refuse_bytes(struct pen_store *store, const struct load *load, int64_t bytes,
                         struct pen_status *st)
{
    if (bytes > load->keep - empty_bytes)
        return pen_fail(st, PEN_TOO_LARGE,
                        "the results of this job take about %lld KiB, more than the %lld KiB that "
                        "the store may hold (--keep-bytes)",
                        (long long)(bytes >> 10), (long long)(load->keep >> 10));
    return pen_fail(st, PEN_STORAGE_FULL,
                    "the store %s has no space left for this job, which takes about %lld KiB: it "
                    "holds %lld KiB of the %lld KiB that it may (--keep-bytes), and the jobs that "
                    "wait or run take about %lld KiB",
                    store->driver->name, (long long)(bytes >> 10), (long long)(load->used >> 10),
                    (long long)(load->keep >> 10), (long long)((load->expected - bytes) >> 10));
}

bool pen_admit_bytes(struct pen_store *store, int64_t job, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct load load;
    int64_t bytes;
    if (!driver->ops->meta_get(driver, "keep_bytes", &load.keep, st))
        return false;
    if (load.keep == 0)
        return true;
    if (!driver->ops->expected_enter(driver, job, &bytes, st) || !read_load(store, 0, &load, st))
        return false;
    const bool alone = load.expected <= bytes;
    if (bytes > load.keep - empty_bytes || (!alone && load.expected > load.keep / UNFINISHED_PART))
        return refuse_bytes(store, &load, bytes, st);
    if (load.used + load.expected <= load.keep) {
        if (bytes >= pen_wanted_room(store))
            pen_note_wanted_room(store, 0);
        return true;
    }
    pen_note_wanted_room(store, bytes);
    return refuse_bytes(store, &load, bytes, st);
}

bool pen_admit_kept(struct pen_store *store, int64_t bytes, struct pen_status *st)
{
    struct load load;
    if (!store->driver->ops->meta_get(store->driver, "keep_bytes", &load.keep, st))
        return false;
    if (load.keep == 0)
        return true;
    if (!read_load(store, bytes, &load, st))
        return false;
    return load.used + load.expected + bytes <= load.keep ||
           pen_fail(st, PEN_STORAGE_FULL,
                    "the store %s has no space left for what a batch keeps, %lld KiB: it holds "
                    "%lld KiB of the %lld KiB that it may (--keep-bytes), and the jobs that wait "
                    "or run take about %lld KiB",
                    store->driver->name, (long long)(bytes >> 10), (long long)(load.used >> 10),
                    (long long)(load.keep >> 10), (long long)(load.expected >> 10));
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

/* Of a store with a limit by bytes. */
struct excess {
    bool any;   /* ended jobs are to be removed */
    bool above; /* it holds more than the limit itself */
    bool stats; /* statistics go, too, if there is no ended job left */
};

/* By how many bytes the store exceeds what retention allows; 0: by none. */
static int64_t too_large_by(const struct load *load)
{
    const int64_t most = load->used < load->keep ? slack_begin(load) : load->keep - 1;
    return load->used > most ? load->used - most : 0;
}

/* By how many bytes it is too large for what unfinished jobs, and one that was refused lately, are
 * expected to store; 0: by none. */
static int64_t too_large_for_jobs_by(struct pen_store *store, const struct load *load)
{
    const int64_t all = load->used + load->expected + pen_wanted_room(store);
    return all > load->keep ? all - load->keep : 0;
}

/* Whether space is about to become free: something is still to go that was removed already, or a
 * value is being written, which may replace another, or go if its writer has died. For values that
 * are being written it is no more than WRITING_MS: others may follow them all the time. */
static bool frees_soon(struct pen_store *store, bool *soon, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_job_key removed;
    int64_t object, now_ms;
    bool writing;
    if (!driver->ops->removed_next(driver, &removed, soon, st) ||
        (!*soon && !pen_value_unused(store, &object, soon, st)) ||
        !driver->ops->object_unused(driver, INT64_MAX, INT64_MAX, &object, &writing, st) ||
        !driver->ops->now(driver, &now_ms, st))
        return false;
    if (!writing)
        store->waits_ms = 0;
    else if (store->waits_ms == 0 || store->waits_ms > now_ms)
        store->waits_ms = now_ms;
    *soon = *soon || (writing && now_ms - store->waits_ms <= WRITING_MS);
    return true;
}

/* What is to be removed for lack of bytes: nothing, if all ended jobs and statistics are too
 * little, since they would go for nothing. Nothing either while space is about to become free. */
static bool find_excess(struct pen_store *store, int64_t keep_bytes, struct excess *excess,
                        struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct load load = {.keep = keep_bytes};
    int64_t bytes;
    bool soon;
    *excess = (struct excess){0};
    if (keep_bytes == 0)
        return true;
    if (!frees_soon(store, &soon, st) || !read_load(store, pen_wanted_room(store), &load, st))
        return false;
    const int64_t by = too_large_by(&load), for_jobs_by = too_large_for_jobs_by(store, &load),
                  most = by > for_jobs_by ? by : for_jobs_by;
    if (most == 0)
        store->waits_ms = 0;
    if (soon || most == 0)
        return true;
    if (!driver->ops->ended_bytes(driver, most, &bytes, st))
        return false;
    const bool slack = by > 0 && bytes >= by, wanted = for_jobs_by > 0 && bytes >= for_jobs_by;
    *excess = (struct excess){.any = slack || wanted,
                              .above = load.used > keep_bytes,
                              .stats = slack || (wanted && load.expected == 0)};
    return by == 0 || slack || tell_that_it_stays(store, by - bytes, st);
}

static bool write_drop_stats(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->removed_purge(store->driver, INT64_MAX, INT64_MAX, STATS_ROWS, arg,
                                             st);
}

struct trim {
    int64_t most;
    bool more;
};

static bool write_trim_stats(struct pen_store *store, void *arg, struct pen_status *st)
{
    struct trim *trim = arg;
    struct pen_driver *driver = store->driver;
    int64_t bytes;
    for (int i = 0; i < STATS_ROWS && trim->more; i++) {
        if (!driver->ops->meta_get(driver, "stats_bytes", &bytes, st))
            return false;
        trim->more = bytes > trim->most;
        if (trim->more &&
            !driver->ops->removed_purge(driver, INT64_MIN, INT64_MAX, 1, &trim->more, st))
            return false;
    }
    return true;
}

/* Drops the oldest statistics until the others have their part of a store with a limit by bytes:
 * else they would grow until every ended job goes for them. */
static bool trim_stats(struct pen_store *store, int64_t keep_bytes, struct pen_status *st)
{
    struct trim trim = {.most = keep_bytes / STATS_PART};
    int64_t bytes = 0;
    if (keep_bytes > 0 && !store->driver->ops->meta_get(store->driver, "stats_bytes", &bytes, st))
        return false;
    trim.more = bytes > trim.most;
    while (trim.more) {
        if (!pen_store_write(store, write_trim_stats, &trim, st))
            return false;
    }
    return true;
}

/* A job that has ended, and when. */
struct ended {
    char id[PEN_ID_BYTES];
    int64_t ms;
    bool found;
};

static bool find_ended(struct pen_store *store, int64_t after_ms, struct ended *out,
                       struct pen_status *st)
{
    return store->driver->ops->first_ended(store->driver, after_ms, out->id, &out->ms, &out->found,
                                           st);
}

static bool write_ahead(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->meta_put(store->driver, ahead_name, *(const int64_t *)arg, st);
}

/* The ended job that goes before others. Jobs can have ended later than now, by a clock that was
 * ahead. They count as ended when such a job was first found: else they would stay for as long as
 * the clock was ahead, and others go for them. */
static bool find_next(struct pen_store *store, int64_t now_ms, struct ended *next,
                      struct pen_status *st)
{
    struct ended ahead;
    int64_t stored_ms, since_ms;
    if (!find_ended(store, 0, next, st) || !find_ended(store, now_ms + GRACE_MS, &ahead, st) ||
        !store->driver->ops->meta_get(store->driver, ahead_name, &stored_ms, st))
        return false;
    since_ms = stored_ms == 0 || stored_ms > now_ms ? now_ms : stored_ms;
    if (!ahead.found)
        since_ms = 0;
    if (since_ms != stored_ms && !pen_store_write(store, write_ahead, &since_ms, st))
        return false;
    if (ahead.found && since_ms <= next->ms) {
        *next = ahead;
        next->ms = since_ms;
    }
    return true;
}

bool pen_policy_expired(struct pen_store *store, char id[PEN_ID_BYTES], bool *found,
                        struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    struct pen_retention keep;
    struct ended next;
    int64_t count, now_ms;
    bool more, wait;
    struct excess excess;
    *found = false;
    if (!pen_policy_retention(store, &keep, st))
        return false;
    if (keep.keep_ms == 0 && keep.keep_bytes == 0 && keep.keep_jobs == 0)
        return true;
    if (!driver->ops->now(driver, &now_ms, st) || !pen_ages_wait(store, now_ms, &wait, st) ||
        !find_next(store, now_ms, &next, st) || !driver->ops->count_ended(driver, &count, st) ||
        !trim_stats(store, keep.keep_bytes, st) ||
        !find_excess(store, keep.keep_bytes, &excess, st))
        return false;
    if (!next.found)
        return !excess.stats || pen_store_write(store, write_drop_stats, &more, st);
    memcpy(id, next.id, sizeof next.id);
    *found = (excess.above || next.ms < now_ms - GRACE_MS) &&
             (excess.any || (keep.keep_ms > 0 && !wait && next.ms < now_ms - keep.keep_ms) ||
              (keep.keep_jobs > 0 && count > keep.keep_jobs));
    return true;
}

/* The forms of pictures that are stored, and what they may have. */
struct forms {
    int64_t bytes;    /* of those that are there */
    int64_t released; /* removed, but not gone yet; of other things, too, which go as soon */
    int64_t most;     /* that all of them may have */
    int64_t left;     /* how much larger the store may become by them; below 0: it has to shrink */
};

/* Forms leave of the disk what intake needs twice, and the log; what is free in the store is taken
 * before the disk's. Of keep_bytes they leave what is expected of jobs, and wanted for one. */
static bool read_left(struct pen_store *store, int64_t *left, int64_t *keep_bytes,
                      struct pen_status *st)
{
    struct pen_room room;
    int64_t expected;
    if (!read_room(store, &room, keep_bytes, st) ||
        !store->driver->ops->meta_get(store->driver, "expected_bytes", &expected, st))
        return false;
    const int64_t of_keep = *keep_bytes - room.used_bytes - expected - pen_wanted_room(store);
    *left = INT64_MAX / 4;
    if (room.disk_bytes > 0)
        *left = room.disk_free_bytes + room.free_bytes - 2 * intake_bytes(&room) - room.log_bytes;
    if (*keep_bytes > 0 && of_keep < *left)
        *left = of_keep;
    return true;
}

static bool read_forms(struct pen_store *store, struct forms *forms, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    int64_t keep_bytes;
    if (!read_left(store, &forms->left, &keep_bytes, st) ||
        !driver->ops->cached_bytes(driver, &forms->bytes, st) ||
        !driver->ops->object_released_bytes(driver, &forms->released, st))
        return false;
    forms->most = cache_bytes;
    if (keep_bytes > 0 && keep_bytes / CACHE_PART < forms->most)
        forms->most = keep_bytes / CACHE_PART;
    return true;
}

/* How many bytes the forms may have, those that are there or others instead. What is released will
 * be free, so that no more forms go than must. */
static int64_t forms_limit(const struct forms *forms)
{
    const int64_t limit = forms->bytes + forms->released + forms->left;
    return limit < forms->most ? limit : forms->most;
}

/* Refuses a form that the store or its disk has no space for. */
static bool admit_form(struct pen_store *store, int64_t bytes, struct pen_status *st)
{
    int64_t left, keep_bytes;
    return read_left(store, &left, &keep_bytes, st) &&
           (bytes <= left ||
            pen_fail(st, PEN_STORAGE_FULL, "the store %s has no space for a form of a picture",
                     store->driver->name));
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

/* Others may have stored forms meanwhile. */
static bool write_cached(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct cached *in = arg;
    struct pen_driver *driver = store->driver;
    struct pen_artefact_key key = *in->key;
    struct pen_job_key job;
    int64_t number, now_ms;
    if (!evict(store, in->limit - (int64_t)in->value.bytes, st) ||
        (in->value.object == 0 && !admit_form(store, (int64_t)in->value.bytes, st)) ||
        !pen_find_job(store, in->id, &job, st) || !driver->ops->now(driver, &now_ms, st))
        return false;
    key.job = job.number;
    return pen_put_artefact(store, &key, &in->value, &number, st) &&
           driver->ops->cached_put(driver, number, (int64_t)in->value.bytes, now_ms, st);
}

static bool write_evict_to(struct pen_store *store, void *arg, struct pen_status *st)
{
    return evict(store, *(const int64_t *)arg, st);
}

/* Drops forms for one of so many bytes. *fits: there is space for it now. It may come a moment
 * later, when what was dropped is gone. */
static bool make_place(struct pen_store *store, int64_t bytes, bool *fits, int64_t *most,
                       struct pen_status *st)
{
    struct forms forms;
    *fits = false;
    if (!read_forms(store, &forms, st))
        return false;
    int64_t others = forms_limit(&forms) - bytes;
    *most = forms.most;
    if (others < 0)
        return true;
    if (forms.bytes > others &&
        (!pen_store_write(store, write_evict_to, &others, st) || !read_forms(store, &forms, st)))
        return false;
    *fits = bytes <= forms.left && forms.bytes + forms.released + bytes <= forms.most;
    return true;
}

bool pen_policy_cache_put(struct pen_store *store, const char *id,
                          const struct pen_artefact_key *key, const void *data, size_t bytes,
                          struct pen_status *st)
{
    struct cached in = {.key = key, .id = id};
    bool fits;
    if (!make_place(store, (int64_t)bytes, &fits, &in.limit, st))
        return false;
    if (!fits)
        return true;
    return pen_value_store_if(store, NULL, admit_form, data, bytes, &in.value, st) &&
           pen_value_write(store, &in.value, write_cached, &in, st);
}

static bool write_evict(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->cached_evict(store->driver, arg, st);
}

bool pen_policy_evict(struct pen_store *store, bool *more, struct pen_status *st)
{
    struct forms forms;
    *more = false;
    if (!read_forms(store, &forms, st))
        return false;
    *more = forms.bytes > 0 && forms.bytes > forms_limit(&forms);
    return !*more || pen_store_write(store, write_evict, &forms.bytes, st);
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
    int64_t left, keep_bytes;
    if (!artefact->cached || !store->driver->ops->now(store->driver, &touch.now_ms, &ignored) ||
        touch.now_ms - artefact->used_ms <= TOUCH_MS ||
        !read_left(store, &left, &keep_bytes, &ignored) || left < 0)
        return;
    pen_store_write(store, write_touch, &touch, &ignored);
    store->outcome_unknown = false;
}
