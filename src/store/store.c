/* SPDX-License-Identifier: MIT */
/* Handles: open, close, failures, the clock, signals. */
#include <stdarg.h>
#include <stdlib.h>

#include "store/internal/handle.h"

enum { LEVEL = 3 }; /* zstd's, of scene documents */

struct pen_store *pen_store_open(const char *url, bool make, struct pen_status *st)
{
    struct pen_store *store = calloc(1, sizeof *store);
    if (store)
        store->documents = pen_compressor_new(LEVEL);
    if (!store || !store->documents)
        pen_fail(st, PEN_NO_MEMORY, "no memory for a store");
    else
        store->db = pen_db_open(url, make, st);
    if (store && store->db)
        return store;
    pen_store_close(store);
    return NULL;
}

void pen_store_close(struct pen_store *store)
{
    if (!store)
        return;
    pen_db_close(store->db);
    pen_compressor_free(store->documents);
    pen_pixels_free(store->pixels);
    free(store);
}

bool pen_store_check(struct pen_store *store, int limit_ms, bool *finished, struct pen_status *st)
{
    return pen_db_check(store->db, limit_ms, finished, st);
}

void pen_store_set_clock(struct pen_store *store, int64_t (*now_ms)(void *user), void *user)
{
    pen_db_set_clock(store->db, now_ms, user);
}

bool pen_store_backup(const char *url, const char *file, bool replace, struct pen_backup *out,
                      struct pen_status *st)
{
    return pen_db_backup(url, file, replace, out, st);
}

bool pen_store_now(struct pen_store *store, int64_t *now_ms, struct pen_status *st)
{
    return pen_db_now(store->db, now_ms, st);
}

bool pen_store_is_broken(const struct pen_store *store, struct pen_status *why)
{
    return pen_db_is_broken(store->db, why);
}

/* A call that a rule refuses has changed nothing. A full disk and a busy store may pass. */
enum pen_failure pen_store_failure(const struct pen_store *store, const struct pen_status *st)
{
    const struct pen_db_trouble trouble = pen_db_trouble(store->db);
    if (trouble.code == st->code)
        return trouble.failure;
    return st->code == PEN_UNAVAILABLE || st->code == PEN_STORAGE_FULL || st->code == PEN_NO_MEMORY
               ? PEN_FAILURE_RETRY
               : PEN_FAILURE_REFUSED;
}

bool pen_write_end(struct pen_store *store, bool ok, struct pen_status *st)
{
    ok = pen_db_end(store->db, ok, st);
    if (ok)
        pen_db_wake(store->db);
    return ok;
}

bool pen_row_numbers(struct pen_rows *rows, int64_t *first, ...)
{
    va_list numbers;
    const bool found = pen_db_next(rows);
    int column = 0;
    va_start(numbers, first);
    for (int64_t *number = first; number; number = va_arg(numbers, int64_t *))
        *number = found ? pen_db_int(rows, column++) : 0;
    va_end(numbers);
    return pen_db_done(rows);
}

void pen_store_wait(struct pen_store *store, uint32_t *seen, int timeout_ms)
{
    pen_db_wait(store->db, seen, timeout_ms);
}

void pen_store_wake(struct pen_store *store)
{
    pen_db_wake(store->db);
}
