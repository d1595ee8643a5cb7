/* SPDX-License-Identifier: MIT */
/* The list of workers, and their ids. A worker renews its row from time to time. The batches it
 * works on are known from its leases, and the end of a lease tells when its holder last extended
 * it. */
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <sys/random.h>

#include "store/internal/policy.h"

bool pen_worker_id_make(char id[PEN_WORKER_ID_BYTES], struct pen_status *st)
{
    unsigned char random[(PEN_WORKER_ID_BYTES - 1) / 2];
    if (getrandom(random, sizeof random, 0) != (ssize_t)sizeof random)
        return pen_fail(st, PEN_IO, "no random bytes for the id of a worker: %s", strerror(errno));
    for (size_t i = 0; i < sizeof random; i++)
        snprintf(id + 2 * i, 3, "%02x", random[i]);
    return true;
}

static bool write_worker(struct pen_store *store, void *arg, struct pen_status *st)
{
    int64_t now_ms;
    return store->driver->ops->now(store->driver, &now_ms, st) &&
           store->driver->ops->worker_put(store->driver, arg, now_ms, st);
}

bool pen_policy_worker_seen(struct pen_store *store, const struct pen_worker_new *worker,
                            struct pen_status *st)
{
    return pen_store_write(store, write_worker, (void *)(uintptr_t)worker, st);
}

static bool remove_worker(struct pen_store *store, void *arg, struct pen_status *st)
{
    return store->driver->ops->worker_remove(store->driver, arg, st);
}

bool pen_policy_worker_gone(struct pen_store *store, const char *id, struct pen_status *st)
{
    return pen_store_write(store, remove_worker, (void *)(uintptr_t)id, st);
}

bool pen_policy_workers(struct pen_store *store, pen_worker_fn *each, void *user,
                        struct pen_status *st)
{
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_worker_record *rows;
    int count = 0;
    if (!arena)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for a list of workers");
    bool ok = store->driver->ops->worker_list(store->driver, arena, &rows, &count, st);
    for (int i = 0; ok && i < count; i++) {
        if (!each(user, &rows[i]))
            break;
    }
    pen_arena_free(arena);
    return ok;
}
