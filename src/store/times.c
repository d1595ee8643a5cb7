/* SPDX-License-Identifier: MIT */
/* A clock that jumps: stored times that lie in the future, since it was set back, and ages that are
 * too large, since it was set ahead. */
#include "store/internal/policy.h"

enum {
    AHEAD_MS = 1000,   /* other processes may have written a little later than this one asks */
    NOTE_MS = 600000,  /* housekeeping is noted this often */
    JUMP_MS = 86400000 /* more than this since the last housekeeping is a jump */
};

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

static const char kept_name[] = "housekeeping_ms"; /* when the last housekeeping was */
static const char jump_name[] = "jump_ms";         /* when the clock was last found ahead of it */

static bool write_kept(struct pen_store *store, void *arg, struct pen_status *st)
{
    const int64_t *at = arg;
    return store->driver->ops->meta_put(store->driver, kept_name, at[0], st) &&
           store->driver->ops->meta_put(store->driver, jump_name, at[1], st);
}

bool pen_ages_wait(struct pen_store *store, int64_t now_ms, bool *wait, struct pen_status *st)
{
    int64_t kept_ms, at[2] = {now_ms};
    if (!store->driver->ops->meta_get(store->driver, kept_name, &kept_ms, st) ||
        !store->driver->ops->meta_get(store->driver, jump_name, &at[1], st))
        return false;
    const bool jumped = kept_ms != 0 && now_ms - kept_ms > JUMP_MS;
    if (jumped)
        at[1] = now_ms;
    *wait = at[1] != 0 && now_ms >= at[1] && now_ms - at[1] < JUMP_MS;
    return (!jumped && now_ms >= kept_ms && now_ms - kept_ms < NOTE_MS) ||
           pen_store_write(store, write_kept, at, st);
}
