/* SPDX-License-Identifier: MIT */
/* Large values. A transaction holds the store's write lock, and what waits for it are submits,
 * cancels and heartbeats; so no transaction writes more than one range (PEN_BLOB_RANGE_BYTES) of
 * one value. A larger one is written as a large object first, a range in each transaction, with a
 * pause after it in which others write. Then a short transaction gives the object to its row:
 * readers see the whole value or none.
 *
 * An object that no row has is removed in slices like a deleted job, at once if its row was removed
 * or got another value, else OBJECT_MS after its last range: whoever wrote it has failed or died.
 * One that would be kept for longer was written by a clock that was ahead, and goes at once. */
#include <time.h>

#include "store/internal/policy.h"

enum {
    OBJECT_MS = 60000,
    PAUSE_NS = 5000000,   /* longer than others sleep while they wait for the lock */
    SLICE_BYTES = 4 << 20 /* removed in one transaction */
};

struct range {
    struct pen_value *value;
    const struct pen_claim *fence;
    pen_value_admit *admit;
    size_t at;
};

static bool check_held(struct pen_store *store, const struct pen_claim *fence,
                       struct pen_status *st)
{
    struct pen_batch_row batch;
    bool held;
    return !fence ||
           (pen_check_fence(store, fence, &batch, &held, st) &&
            (held ||
             pen_fail(st, PEN_STALE, "the batch is no longer held; what it stores was refused")));
}

static bool write_range(struct pen_store *store, void *arg, struct pen_status *st)
{
    const struct range *range = arg;
    struct pen_value *value = range->value;
    struct pen_driver *driver = store->driver;
    const size_t left = value->bytes - range->at,
                 bytes = left < PEN_BLOB_RANGE_BYTES ? left : PEN_BLOB_RANGE_BYTES;
    int64_t now_ms;
    bool there;
    if (!check_held(store, range->fence, st) ||
        (range->admit && !range->admit(store, (int64_t)left, st)) ||
        !driver->ops->now(driver, &now_ms, st) ||
        (range->at == 0 && !driver->ops->object_add(driver, value->bytes, &value->object, st)) ||
        !driver->ops->object_write(driver, value->object, range->at,
                                   (const char *)value->data + range->at, bytes, now_ms + OBJECT_MS,
                                   &there, st))
        return false;
    return there || pen_fail(st, PEN_UNAVAILABLE, "a value that was being stored took too long");
}

static bool write_release(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->object_release(store->driver, *(const int64_t *)arg, st);
}

void pen_value_drop(struct pen_store *store, const struct pen_value *value)
{
    struct pen_status ignored;
    int64_t object = value->object;
    if (object == 0 || store->outcome_unknown)
        return;
    pen_store_write(store, write_release, &object, &ignored);
    store->outcome_unknown = false;
}

static bool write_object(struct pen_store *store, const struct pen_claim *fence,
                         pen_value_admit *admit, struct pen_value *value, struct pen_status *st)
{
    const struct timespec pause = {.tv_nsec = PAUSE_NS};
    struct range range = {value, fence, admit, 0};
    for (; range.at < value->bytes; range.at += PEN_BLOB_RANGE_BYTES) {
        const int64_t before = value->object;
        if (!pen_store_write(store, write_range, &range, st)) {
            value->object = before; /* the transaction that made it was rolled back */
            pen_value_drop(store, value);
            value->object = 0;
            store->outcome_unknown = false; /* what may be there is an object that no row has */
            return false;
        }
        nanosleep(&pause, NULL);
    }
    return true;
}

bool pen_value_store_if(struct pen_store *store, const struct pen_claim *fence,
                        pen_value_admit *admit, const void *data, size_t bytes,
                        struct pen_value *value, struct pen_status *st)
{
    *value =
        (struct pen_value){.data = data, .bytes = bytes, .checksum = pen_checksum(data, bytes)};
    return bytes <= PEN_BLOB_RANGE_BYTES || write_object(store, fence, admit, value, st);
}

bool pen_value_store(struct pen_store *store, const struct pen_claim *fence, const void *data,
                     size_t bytes, struct pen_value *value, struct pen_status *st)
{
    return pen_value_store_if(store, fence, NULL, data, bytes, value, st);
}

bool pen_value_store_apart(struct pen_store *store, const struct pen_claim *fence,
                           pen_value_admit *admit, const void *data, size_t bytes,
                           struct pen_value *value, struct pen_status *st)
{
    *value =
        (struct pen_value){.data = data, .bytes = bytes, .checksum = pen_checksum(data, bytes)};
    return write_object(store, fence, admit, value, st);
}

struct pen_blob_start pen_value_begin(const struct pen_value *value)
{
    struct pen_blob_start start = pen_blob_begin(value->data, value->bytes);
    start.object = value->object;
    return start;
}

bool pen_value_finish(struct pen_store *store, enum pen_blob_kind kind, int64_t number,
                      const struct pen_value *value, struct pen_status *st)
{
    return value->object > 0 || pen_blob_finish(store, kind, number, value->data, value->bytes, st);
}

bool pen_value_write(struct pen_store *store, const struct pen_value *value, pen_body *write,
                     void *arg, struct pen_status *st)
{
    const bool ok = pen_store_write(store, write, arg, st);
    if (!ok)
        pen_value_drop(store, value);
    return ok;
}

bool pen_value_unused(struct pen_store *store, int64_t *object, bool *found, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    int64_t now_ms;
    return driver->ops->now(driver, &now_ms, st) &&
           driver->ops->object_unused(driver, now_ms, now_ms + OBJECT_MS, object, found, st);
}

/* Unless another handle has removed the last one meanwhile. */
static bool shrink_unused(struct pen_store *store, void *arg, struct pen_status *st)
{
    int64_t object;
    bool found;
    (void)arg;
    return pen_value_unused(store, &object, &found, st) &&
           (!found || store->driver->ops->object_shrink(store->driver, object, SLICE_BYTES, st));
}

bool pen_values_shrink(struct pen_store *store, bool *more, struct pen_status *st)
{
    int64_t object;
    *more = false;
    return pen_value_unused(store, &object, more, st) &&
           (!*more || pen_store_write(store, shrink_unused, NULL, st));
}
