/* SPDX-License-Identifier: MIT */
#include "store/internal/health.h"

#include <errno.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"

enum {
    AGAIN_MS = 500, /* between tries to mend */
    AGAIN_DAMAGE_MS = 5000,
    AGAIN_TIMES = 4,     /* or so many times what the last one took */
    AGAIN_MAX_MS = 60000 /* a later time is left over from before a boot */
};

/* The words of the shared page. Atomic: sequentially consistent throughout; they are touched once
 * per call. */
enum {
    WORD_MET,                                   /* by kind: faults met */
    WORD_MENDED = WORD_MET + PEN_FAULT_COUNT,   /* by kind: the count up to which they are mended */
    WORD_ERRNO = WORD_MENDED + PEN_FAULT_COUNT, /* by kind: of the last */
    WORD_AGAIN_MS = WORD_ERRNO + PEN_FAULT_COUNT, /* monotonic: when to try again */
    WORD_COUNT
};
_Static_assert((int)WORD_COUNT <= (int)PEN_HEALTH_WORDS, "the shared page has fewer words");

static _Atomic uint32_t *word(const struct pen_store *store, int index)
{
    return store->driver->ops->health_words(store->driver) + index;
}

static uint32_t met(const struct pen_store *store, enum pen_fault fault)
{
    return atomic_load(word(store, WORD_MET + (int)fault));
}

static bool is_ill(const struct pen_store *store, enum pen_fault fault)
{
    return met(store, fault) != atomic_load(word(store, WORD_MENDED + (int)fault));
}

/* Grows with every fault that calls for reopening. */
static uint32_t epoch(const struct pen_store *store)
{
    return met(store, PEN_FAULT_IO) + met(store, PEN_FAULT_DAMAGE);
}

static uint32_t now_ms(void)
{
    return (uint32_t)(pen_clock_ns() / 1000000);
}

static bool is_due(const struct pen_store *store)
{
    int32_t left = (int32_t)(atomic_load(word(store, WORD_AGAIN_MS)) - now_ms());
    return left <= 0 || left > AGAIN_MAX_MS;
}

/* A try that ended for want of memory says nothing of the store: the next need only wait if it was
 * a costly one. */
static void set_due(const struct pen_store *store, uint32_t begun_ms, bool no_memory)
{
    uint32_t now = now_ms(), wait = (now - begun_ms) * AGAIN_TIMES;
    uint32_t least = is_ill(store, PEN_FAULT_DAMAGE) ? AGAIN_DAMAGE_MS : AGAIN_MS;
    if (wait < least)
        wait = no_memory ? 0 : least;
    atomic_store(word(store, WORD_AGAIN_MS), now + (wait < AGAIN_MAX_MS ? wait : AGAIN_MAX_MS));
}

void pen_health_begin(struct pen_store *store)
{
    store->epoch = epoch(store);
}

static const char *const illness[PEN_FAULT_COUNT] = {
    [PEN_FAULT_FULL] = "it has no space left",
    [PEN_FAULT_IO] = "it could not be read or written",
    [PEN_FAULT_DAMAGE] = "it is damaged",
};

static void note(struct pen_store *store, enum pen_fault fault)
{
    if (!is_ill(store, fault))
        pen_log(PEN_LOG_ERROR, "the store %s is ill: %s%s%s", store->driver->name, illness[fault],
                store->driver->fault_errno ? ": " : "",
                store->driver->fault_errno ? strerror(store->driver->fault_errno) : "");
    atomic_store(word(store, WORD_ERRNO + (int)fault), (uint32_t)store->driver->fault_errno);
    atomic_fetch_add(word(store, WORD_MET + (int)fault), 1);
}

static void note_all(struct pen_store *store)
{
    for (int fault = 0; fault < PEN_FAULT_COUNT; fault++) {
        if (store->driver->faults >> fault & 1)
            note(store, (enum pen_fault)fault);
    }
    store->driver->faults = 0;
    store->driver->fault_errno = 0;
}

/* Why a call is refused that has not tried for itself. */
static bool refuse(const struct pen_store *store, struct pen_status *st)
{
    int error = (int)atomic_load(word(store, WORD_ERRNO + PEN_FAULT_IO));
    bool full = error == ENOSPC || error == EDQUOT;
    if (is_ill(store, PEN_FAULT_DAMAGE))
        return pen_fail(st, PEN_STORAGE,
                        "the store %s is damaged; it is not served until a check finds it whole: "
                        "stop Penumbra and restore a backup",
                        store->driver->name);
    if (is_ill(store, PEN_FAULT_IO))
        return pen_fail(st, full ? PEN_STORAGE_FULL : PEN_STORAGE,
                        "the store %s could not be read or written (%s); it takes nothing until a "
                        "trial write and a check succeed",
                        store->driver->name, error ? strerror(error) : "input/output error");
    return pen_fail(st, PEN_STORAGE_FULL, "the store %s has no space left", store->driver->name);
}

static bool reopen(struct pen_store *store, struct pen_status *st)
{
    uint32_t now = epoch(store);
    store->driver->closed = !store->driver->ops->reopen(store->driver, st);
    if (!store->driver->closed)
        store->epoch = now;
    return !store->driver->closed;
}

/* A damaged store is checked before it is written to; else the cheap trial comes first. */
static bool examine(struct pen_store *store, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    const struct pen_driver_ops *ops = driver->ops;
    bool damage = is_ill(store, PEN_FAULT_DAMAGE);
    if (!damage && !is_ill(store, PEN_FAULT_IO))
        return true;
    if (!reopen(store, st) || (damage && !ops->check(driver, st)) || !ops->probe(driver, st))
        return false;
    return damage || ops->check(driver, st);
}

/* Faults met by a try are news only where they are of another kind. */
static void forget_known(struct pen_store *store)
{
    for (int fault = 0; fault < PEN_FAULT_COUNT; fault++) {
        if (is_ill(store, (enum pen_fault)fault))
            store->driver->faults &= ~(1u << fault);
    }
    note_all(store);
}

/* Notes that the faults met up to then are mended. */
static void settle(struct pen_store *store, enum pen_fault fault, uint32_t seen)
{
    if (is_ill(store, fault))
        pen_log(PEN_LOG_INFO, "the store %s is mended: %s", store->driver->name, illness[fault]);
    atomic_store(word(store, WORD_MENDED + (int)fault), seen);
}

static bool try_to_mend(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    uint32_t seen[PEN_FAULT_COUNT];
    for (int fault = 0; fault < PEN_FAULT_COUNT; fault++)
        seen[fault] = met(store, (enum pen_fault)fault);
    if (!examine(store, st))
        return false;
    settle(store, PEN_FAULT_IO, seen[PEN_FAULT_IO]);
    settle(store, PEN_FAULT_DAMAGE, seen[PEN_FAULT_DAMAGE]);
    if (need < PEN_NEED_SPACE || !is_ill(store, PEN_FAULT_FULL))
        return true;
    if (!store->driver->ops->space(store->driver, st))
        return false;
    settle(store, PEN_FAULT_FULL, seen[PEN_FAULT_FULL]);
    return true;
}

static bool mend(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    int lock;
    if (!is_due(store) || !store->driver->ops->repair_lock(store->driver, &lock))
        return refuse(store, st);
    uint32_t begun_ms = now_ms();
    bool ok = try_to_mend(store, need, st);
    forget_known(store);
    if (!ok)
        set_due(store, begun_ms, st->code == PEN_NO_MEMORY);
    store->driver->ops->repair_unlock(store->driver, lock);
    return ok;
}

void pen_health_found_whole(struct pen_store *store)
{
    atomic_store(word(store, WORD_AGAIN_MS), now_ms());
}

static bool stands_in_the_way(const struct pen_store *store, enum pen_need need)
{
    return (need >= PEN_NEED_READ && is_ill(store, PEN_FAULT_DAMAGE)) ||
           (need >= PEN_NEED_WRITE && is_ill(store, PEN_FAULT_IO)) ||
           (need >= PEN_NEED_SPACE && is_ill(store, PEN_FAULT_FULL));
}

bool pen_health_enter(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    if (store->depth == 0) {
        if (stands_in_the_way(store, need) && !mend(store, need, st))
            return false;
        if ((store->driver->closed || store->epoch != epoch(store)) && !reopen(store, st)) {
            forget_known(store);
            return false;
        }
    }
    store->depth++;
    return true;
}

bool pen_health_exit(struct pen_store *store)
{
    if (--store->depth > 0)
        return false;
    if (store->driver->faults)
        note_all(store);
    return true;
}
