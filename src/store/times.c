/* SPDX-License-Identifier: MIT */
/* Stored times that lie in the future, since the clock was set back. */
#include "store/internal/policy.h"

enum { AHEAD_MS = 1000 }; /* other processes may have written a little later than this one asks */

int64_t pen_since_ms(int64_t then_ms, int64_t now_ms)
{
    const uint64_t since = (uint64_t)now_ms - (uint64_t)then_ms; /* of a damaged time: very long */
    return then_ms > now_ms || since > INT64_MAX ? INT64_MAX : (int64_t)since;
}

static bool write_mended(struct pen_store *store, void *arg, struct pen_status *st)
{
    int64_t now_ms;
    (void)arg;
    return store->driver->ops->now(store->driver, &now_ms, st) &&
           store->driver->ops->times_mend(store->driver, now_ms, st);
}

bool pen_times_mend(struct pen_store *store, int64_t now_ms, struct pen_status *st)
{
    bool any;
    return store->driver->ops->times_ahead(store->driver, now_ms + AHEAD_MS, &any, st) &&
           (!any || pen_store_write(store, write_mended, NULL, st));
}
