/* SPDX-License-Identifier: MIT */
/* Counters of what all processes of a store have done, for its readers. They are sums in shared
 * memory, not in the database: a commit costs nothing more, and a crash may lose the last ones. */
#include "base/clock.h"
#include "store/internal/policy.h"

enum {
    TIMING_WORDS = 1 + PEN_TIMING_BUCKETS + 1, /* the sum, then the buckets */
    /* After them two that are no sums: the space for which a job was refused, and when, by the
     * monotonic clock. */
    WORD_ROOM = PEN_TALLY_TIMINGS + PEN_TIMING_COUNT * TIMING_WORDS,
    WORD_ROOM_NS,
    WORDS,
    ROOM_S = 120 /* how long it is asked for */
};
_Static_assert((int)WORDS <= (int)PEN_TALLY_WORDS, "the shared memory has space for all sums");

static const double bounds_s[PEN_TIMING_COUNT][PEN_TIMING_BUCKETS] = {
    [PEN_TIMING_BATCH] = {0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 10000},
    [PEN_TIMING_READ] = {1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30},
    [PEN_TIMING_WRITE] = {1e-4, 3e-4, 1e-3, 3e-3, 0.01, 0.03, 0.1, 0.3, 1, 3, 10, 30}};

static _Atomic uint64_t *words(struct pen_store *store)
{
    return store->driver->ops->tallies(store->driver);
}

static void add(_Atomic uint64_t *word, uint64_t count)
{
    atomic_fetch_add_explicit(word, count, memory_order_relaxed);
}

static uint64_t value(_Atomic uint64_t *word)
{
    return atomic_load_explicit(word, memory_order_relaxed);
}

void pen_store_tally_add(struct pen_store *store, enum pen_tally tally, uint64_t count)
{
    add(&words(store)[tally], count);
}

void pen_tally_set(struct pen_store *store, enum pen_tally tally, uint64_t state)
{
    atomic_store_explicit(&words(store)[tally], state, memory_order_relaxed);
}

uint64_t pen_store_tally(struct pen_store *store, enum pen_tally tally)
{
    return value(&words(store)[tally]);
}

void pen_note_wanted_room(struct pen_store *store, int64_t bytes)
{
    atomic_store_explicit(&words(store)[WORD_ROOM], (uint64_t)bytes, memory_order_relaxed);
    atomic_store_explicit(&words(store)[WORD_ROOM_NS], (uint64_t)pen_clock_ns(),
                          memory_order_relaxed);
}

int64_t pen_wanted_room(struct pen_store *store)
{
    const uint64_t age_ns = (uint64_t)pen_clock_ns() - value(&words(store)[WORD_ROOM_NS]);
    return age_ns > ROOM_S * UINT64_C(1000000000) ? 0 : (int64_t)value(&words(store)[WORD_ROOM]);
}

static _Atomic uint64_t *timing_words(struct pen_store *store, enum pen_timing timing)
{
    return words(store) + PEN_TALLY_TIMINGS + (int)timing * TIMING_WORDS;
}

void pen_timing_add(struct pen_store *store, enum pen_timing timing, int64_t us)
{
    _Atomic uint64_t *word = timing_words(store, timing);
    int bucket = 0;
    while (bucket < PEN_TIMING_BUCKETS && (double)us > bounds_s[timing][bucket] * 1e6)
        bucket++;
    add(&word[0], us > 0 ? (uint64_t)us : 0);
    add(&word[1 + bucket], 1);
}

struct pen_histogram pen_store_timing(struct pen_store *store, enum pen_timing timing)
{
    _Atomic uint64_t *word = timing_words(store, timing);
    struct pen_histogram out = {.bounds_s = bounds_s[timing], .sum_us = value(&word[0])};
    for (int i = 0; i <= PEN_TIMING_BUCKETS; i++)
        out.count[i] = value(&word[1 + i]);
    return out;
}
