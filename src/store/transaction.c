/* SPDX-License-Identifier: MIT */
/* Transactions and blobs of the policy, over the operations of a driver. */
#include <stdlib.h>

#include "base/clock.h"
#include "store/internal/policy.h"

static bool write_once(struct pen_store *store, pen_body *body, void *arg, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    if (!driver->ops->begin_write(driver, st))
        return false;
    bool ok = body(store, arg, st);
    if (ok && driver->ops->commit(driver, st))
        return true;
    store->outcome_unknown = ok && driver->outcome_unknown;
    driver->ops->rollback(driver);
    store->work = store->changed = false;
    return false;
}

static bool read_once(struct pen_store *store, pen_body *body, void *arg, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    if (!driver->ops->begin_read(driver, st))
        return false;
    bool ok = body(store, arg, st);
    driver->ops->rollback(driver);
    return ok;
}

bool pen_store_write(struct pen_store *store, pen_body *body, void *arg, struct pen_status *st)
{
    int64_t begun_ns = pen_clock_ns();
    bool ok = write_once(store, body, arg, st);
    pen_timing_add(store, PEN_TIMING_WRITE, (pen_clock_ns() - begun_ns) / 1000);
    return ok;
}

bool pen_store_read(struct pen_store *store, pen_body *body, void *arg, struct pen_status *st)
{
    int64_t begun_ns = pen_clock_ns();
    bool ok = read_once(store, body, arg, st);
    pen_timing_add(store, PEN_TIMING_READ, (pen_clock_ns() - begun_ns) / 1000);
    return ok;
}

static size_t range_at(size_t offset, size_t bytes)
{
    size_t left = bytes - offset;
    return left < PEN_BLOB_RANGE_BYTES ? left : PEN_BLOB_RANGE_BYTES;
}

struct pen_blob_start pen_blob_begin(const void *data, size_t bytes)
{
    return (struct pen_blob_start){.total = bytes, .data = data, .bytes = range_at(0, bytes)};
}

bool pen_blob_finish(struct pen_store *store, enum pen_blob_kind kind, int64_t number,
                     const void *data, size_t bytes, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    for (size_t at = range_at(0, bytes), n; at < bytes; at += n) {
        n = range_at(at, bytes);
        if (!driver->ops->blob_write(driver, kind, number, at, (const char *)data + at, n, st))
            return false;
    }
    return true;
}

static bool reserve_blob(struct pen_store *store, size_t bytes, struct pen_status *st)
{
    struct pen_buf *blob = &store->blob;
    blob->failed = false;
    blob->bytes = 0;
    if (bytes < blob->capacity)
        return true;
    pen_buf_release(blob); /* its contents need not be copied */
    return pen_buf_reserve(blob, bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for %zu stored bytes", bytes);
}

bool pen_blob_is_intact(const struct pen_store *store, bool has_checksum, int64_t checksum)
{
    return !has_checksum || checksum == pen_checksum(store->blob.data, store->blob.bytes);
}

bool pen_blob_load(struct pen_store *store, enum pen_blob_kind kind, int64_t number, size_t bytes,
                   struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    if (!reserve_blob(store, bytes, st))
        return false;
    for (size_t at = 0, n; at < bytes; at += n) {
        n = range_at(at, bytes);
        if (!driver->ops->blob_read(driver, kind, number, at, store->blob.data + at, n, st))
            return false;
    }
    store->blob.bytes = bytes;
    return true;
}
