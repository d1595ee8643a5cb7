/* SPDX-License-Identifier: MIT */
/* The rules of health.h. */
#include "store/internal/health.h"

#include <errno.h>
#include <string.h>

#include "base/clock.h"
#include "base/log.h"

enum {
    RETRY_MS = 500,         /* between tries to recover */
    RETRY_DAMAGE_MS = 5000, /* the same, of a damaged store */
    RETRY_TIMES = 4,        /* at least so many times as long as the last try took */
    RETRY_MAX_MS = 60000,   /* a later time in the shared word dates from before a reboot */
    WANTED_MS = 120000      /* how long a result that was refused counts as waiting for space */
};

/* The shared words. Atomic: sequentially consistent, since a call touches them only once. */
enum {
    WORD_MET,                                      /* by kind: number of faults met */
    WORD_RECOVERED = WORD_MET + PEN_FAULT_COUNT,   /* by kind: number of faults recovered from */
    WORD_ERRNO = WORD_RECOVERED + PEN_FAULT_COUNT, /* by kind: errno of the last fault */
    WORD_RETRY_MS = WORD_ERRNO + PEN_FAULT_COUNT,  /* when to try again, by the monotonic clock */
    WORD_WANTED_KIB, /* what the disk must have free for the result that was refused last; 0: none
                      */
    WORD_WANTED_MS,  /* when that was, by the monotonic clock */
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

static bool is_faulty(const struct pen_store *store, enum pen_fault fault)
{
    return met(store, fault) != atomic_load(word(store, WORD_RECOVERED + (int)fault));
}

/* A number that grows with every fault after which handles must be reopened. */
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
    int32_t left = (int32_t)(atomic_load(word(store, WORD_RETRY_MS)) - now_ms());
    return left <= 0 || left > RETRY_MAX_MS;
}

/* Sets the time of the next try. A try that failed for lack of memory tells nothing of the store,
 * so the next one waits only if this one took long. */
static void set_due(const struct pen_store *store, uint32_t begun_ms, bool no_memory)
{
    uint32_t now = now_ms(), wait = (now - begun_ms) * RETRY_TIMES;
    uint32_t least = is_faulty(store, PEN_FAULT_DAMAGE) ? RETRY_DAMAGE_MS : RETRY_MS;
    if (wait < least)
        wait = no_memory ? 0 : least;
    atomic_store(word(store, WORD_RETRY_MS), now + (wait < RETRY_MAX_MS ? wait : RETRY_MAX_MS));
}

void pen_health_begin(struct pen_store *store)
{
    store->epoch = epoch(store);
}

static const char *const fault_text[PEN_FAULT_COUNT] = {
    [PEN_FAULT_FULL] = "no space left",
    [PEN_FAULT_IO] = "it could not be read or written",
    [PEN_FAULT_DAMAGE] = "damage",
};

static void note_fault(struct pen_store *store, enum pen_fault fault)
{
    if (!is_faulty(store, fault))
        pen_log(PEN_LOG_ERROR, "the store %s has a fault: %s%s%s", store->driver->name,
                fault_text[fault], store->driver->fault_errno ? ": " : "",
                store->driver->fault_errno ? strerror(store->driver->fault_errno) : "");
    atomic_store(word(store, WORD_ERRNO + (int)fault), (uint32_t)store->driver->fault_errno);
    atomic_fetch_add(word(store, WORD_MET + (int)fault), 1);
}

static void note_faults(struct pen_store *store)
{
    for (int fault = 0; fault < PEN_FAULT_COUNT; fault++) {
        if (store->driver->faults >> fault & 1)
            note_fault(store, (enum pen_fault)fault);
    }
    store->driver->faults = 0;
    store->driver->fault_errno = 0;
}

/* What the disk must have free for a result that waits for space; 0: none waits. */
static int64_t wanted_bytes(const struct pen_store *store)
{
    const uint32_t age_ms = now_ms() - atomic_load(word(store, WORD_WANTED_MS));
    return age_ms > WANTED_MS ? 0 : (int64_t)atomic_load(word(store, WORD_WANTED_KIB)) << 10;
}

static bool fail_full(const struct pen_store *store, struct pen_status *st)
{
    const int64_t wanted = wanted_bytes(store);
    if (wanted == 0)
        return pen_fail(st, PEN_STORAGE_FULL, "the store %s has no space left",
                        store->driver->name);
    return pen_fail(st, PEN_STORAGE_FULL,
                    "the store %s has no space left: a result waits until its disk has %lld KiB "
                    "free",
                    store->driver->name, (long long)(wanted >> 10));
}

/* Refuses a call that has not tried to recover the store itself. Fails: always. */
static bool refuse(const struct pen_store *store, struct pen_status *st)
{
    int error = (int)atomic_load(word(store, WORD_ERRNO + PEN_FAULT_IO));
    bool full = pen_errno_is_full(error);
    if (is_faulty(store, PEN_FAULT_DAMAGE))
        return pen_fail(st, PEN_STORAGE,
                        "the store %s is damaged; it is not served until a check finds it whole: "
                        "stop Penumbra and restore a backup",
                        store->driver->name);
    if (is_faulty(store, PEN_FAULT_IO))
        return pen_fail(st, full ? PEN_STORAGE_FULL : PEN_STORAGE,
                        "the store %s could not be read or written (%s); it takes nothing until a "
                        "trial write and a check succeed",
                        store->driver->name, error ? strerror(error) : "input/output error");
    return fail_full(store, st);
}

static bool reopen(struct pen_store *store, struct pen_status *st)
{
    uint32_t now = epoch(store);
    store->driver->closed = !store->driver->ops->reopen(store->driver, st);
    if (!store->driver->closed)
        store->epoch = now;
    return !store->driver->closed;
}

/* Reopens a faulty store, checks it and writes to it. A damaged store is checked before it is
 * written to; otherwise the cheap trial write comes first. */
static bool examine(struct pen_store *store, struct pen_status *st)
{
    struct pen_driver *driver = store->driver;
    const struct pen_driver_ops *ops = driver->ops;
    bool damage = is_faulty(store, PEN_FAULT_DAMAGE);
    if (!damage && !is_faulty(store, PEN_FAULT_IO))
        return true;
    if (!reopen(store, st) || (damage && !ops->check(driver, st)) || !ops->probe(driver, st))
        return false;
    return damage || ops->check(driver, st);
}

/* Notes the faults that a try has met, except those of a kind that is known already. */
static void note_new_faults(struct pen_store *store)
{
    for (int fault = 0; fault < PEN_FAULT_COUNT; fault++) {
        if (is_faulty(store, (enum pen_fault)fault))
            store->driver->faults &= ~(1u << fault);
    }
    note_faults(store);
}

/* Notes that the store has recovered from the first `seen` faults of a kind. */
static void note_recovery(struct pen_store *store, enum pen_fault fault, uint32_t seen)
{
    if (is_faulty(store, fault))
        pen_log(PEN_LOG_INFO, "the store %s has recovered from its fault: %s", store->driver->name,
                fault_text[fault]);
    atomic_store(word(store, WORD_RECOVERED + (int)fault), seen);
}

/* Whether there is space for a result that waits for it. */
static bool has_wanted_space(struct pen_store *store, bool *has, struct pen_status *st)
{
    const int64_t wanted = wanted_bytes(store);
    struct pen_room room;
    *has = true;
    if (wanted == 0)
        return true;
    if (!store->driver->ops->room(store->driver, &room, st))
        return false;
    *has = room.disk_bytes == 0 || room.disk_free_bytes >= wanted;
    return true;
}

static bool try_recovery(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    uint32_t seen[PEN_FAULT_COUNT];
    for (int fault = 0; fault < PEN_FAULT_COUNT; fault++)
        seen[fault] = met(store, (enum pen_fault)fault);
    if (!examine(store, st))
        return false;
    note_recovery(store, PEN_FAULT_IO, seen[PEN_FAULT_IO]);
    note_recovery(store, PEN_FAULT_DAMAGE, seen[PEN_FAULT_DAMAGE]);
    if (need < PEN_NEED_GROW || !is_faulty(store, PEN_FAULT_FULL))
        return true;
    bool has;
    if (!store->driver->ops->space(store->driver, st) || !has_wanted_space(store, &has, st))
        return false;
    if (!has)
        return need == PEN_NEED_GROW || fail_full(store, st); /* other results may fit */
    note_recovery(store, PEN_FAULT_FULL, seen[PEN_FAULT_FULL]);
    return true;
}

static bool recover(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    int lock;
    if (!is_due(store) || !store->driver->ops->repair_lock(store->driver, &lock))
        return refuse(store, st);
    uint32_t begun_ms = now_ms();
    bool ok = try_recovery(store, need, st);
    note_new_faults(store);
    if (!ok)
        set_due(store, begun_ms, st->code == PEN_NO_MEMORY);
    store->driver->ops->repair_unlock(store->driver, lock);
    return ok;
}

void pen_health_want(struct pen_store *store, int64_t bytes)
{
    const int64_t kib = (bytes + 1023) >> 10;
    atomic_store(word(store, WORD_WANTED_MS), now_ms());
    atomic_store(word(store, WORD_WANTED_KIB), kib < UINT32_MAX ? (uint32_t)kib : UINT32_MAX);
    if (bytes > 0)
        store->driver->faults |= 1u << PEN_FAULT_FULL;
}

void pen_health_check_passed(struct pen_store *store)
{
    atomic_store(word(store, WORD_RETRY_MS), now_ms());
}

static bool needs_recovery(const struct pen_store *store, enum pen_need need)
{
    return (need >= PEN_NEED_READ && is_faulty(store, PEN_FAULT_DAMAGE)) ||
           (need >= PEN_NEED_WRITE && is_faulty(store, PEN_FAULT_IO)) ||
           (need >= PEN_NEED_SPACE && is_faulty(store, PEN_FAULT_FULL)) ||
           (need == PEN_NEED_GROW && is_faulty(store, PEN_FAULT_FULL) &&
            store->driver->ops->reserve_is_out(store->driver));
}

bool pen_health_enter(struct pen_store *store, enum pen_need need, struct pen_status *st)
{
    if (store->depth == 0) {
        if (needs_recovery(store, need) && !recover(store, need, st))
            return false;
        if ((store->driver->closed || store->epoch != epoch(store)) && !reopen(store, st)) {
            note_new_faults(store);
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
        note_faults(store);
    return true;
}
