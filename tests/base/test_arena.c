/* SPDX-License-Identifier: MIT */
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/arena.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

static bool zeroed(const unsigned char *p, size_t bytes)
{
    for (size_t i = 0; i < bytes; i++) {
        if (p[i])
            return false;
    }
    return true;
}

START_TEST(test_arena__allocations_are_zeroed_aligned_and_disjoint)
{
    struct random r = random_begin(1);
    struct pen_arena *arena = pen_arena_new(0);
    enum { PIECES = 3000 };
    static unsigned char *piece[PIECES];
    static size_t bytes[PIECES];
    for (int use = 0; use < 3; use++) { /* memory that is reused is zeroed again */
        for (int i = 0; i < PIECES; i++) {
            size_t count = random_below(&r, 50), size = 1 + random_below(&r, i % 100 ? 8 : 5000);
            piece[i] = pen_arena_alloc(arena, count, size);
            bytes[i] = count * size;
            uintptr_t align = bytes[i] >= 64 ? 64 : 16;
            if (!(piece[i] && (uintptr_t)piece[i] % align == 0 && zeroed(piece[i], bytes[i])))
                ck_abort_msg("seed %llu, piece %d", (unsigned long long)r.seed, i);
            memset(piece[i], i % 255 + 1, bytes[i]);
        }
        for (int i = 0; i < PIECES; i++) {
            for (size_t j = 0; j < bytes[i]; j++) {
                if (piece[i][j] != i % 255 + 1)
                    ck_abort_msg("seed %llu: piece %d overwritten", (unsigned long long)r.seed, i);
            }
        }
        pen_arena_reset(arena);
        ck_assert_uint_eq(pen_arena_used(arena), 0);
    }
    pen_arena_free(arena);
}
END_TEST

START_TEST(test_arena__overflow_is_refused)
{
    struct pen_arena *arena = pen_arena_new(0);
    const size_t huge[][2] = {{SIZE_MAX, 2},       {SIZE_MAX / 2 + 1, 2}, {SIZE_MAX, 1},
                              {1, SIZE_MAX},       {SIZE_MAX - 15, 1},    {SIZE_MAX - 63, 1},
                              {SIZE_MAX / 16, 17}, {SIZE_MAX / 2, 1},     {SIZE_MAX / 4, 2}};
    for (size_t i = 0; i < sizeof huge / sizeof huge[0]; i++)
        ck_assert_ptr_null(pen_arena_alloc(arena, huge[i][0], huge[i][1]));
    ck_assert_uint_eq(pen_arena_used(arena), 0);
    ck_assert_ptr_nonnull(pen_arena_alloc(arena, 1, 1));
    ck_assert_ptr_nonnull(pen_arena_alloc(arena, 0, 1));
    ck_assert_ptr_nonnull(pen_arena_alloc(arena, 1, 0));
    pen_arena_free(arena);
    pen_arena_free(NULL);
}
END_TEST

START_TEST(test_arena__the_cap_is_exact)
{
    struct pen_arena *arena = pen_arena_new(1024);
    ck_assert_ptr_null(pen_arena_alloc(arena, 1025, 1));
    ck_assert_ptr_nonnull(pen_arena_alloc(arena, 1024, 1));
    ck_assert_ptr_null(pen_arena_alloc(arena, 1, 1));
    ck_assert_uint_eq(pen_arena_used(arena), 1024);
    pen_arena_reset(arena);
    for (int i = 0; i < 64; i++)
        ck_assert_ptr_nonnull(pen_arena_alloc(arena, 1, 16));
    ck_assert_ptr_null(pen_arena_alloc(arena, 1, 1));
    ck_assert_ptr_null(pen_arena_strdup(arena, ""));
    pen_arena_free(arena);
}
END_TEST

START_TEST(test_arena__strdup_copies_the_terminating_zero)
{
    struct pen_arena *arena = pen_arena_new(0);
    char text[] = "caf\xC3\xA9";
    char *copy = pen_arena_strdup(arena, text);
    text[0] = 'x';
    ck_assert_str_eq(copy, "caf\xC3\xA9");
    ck_assert_str_eq(pen_arena_strdup(arena, ""), "");
    pen_arena_free(arena);
}
END_TEST

START_TEST(test_arena__reset_keeps_its_memory)
{
    struct pen_arena *arena = pen_arena_new(0);
    for (int i = 0; i < 500; i++)
        ck_assert_ptr_nonnull(pen_arena_alloc(arena, 1000, 1));
    pen_arena_reset(arena);
    alloc_fail_after(0);
    bool ok = true;
    for (int i = 0; i < 500; i++)
        ok = ok && pen_arena_alloc(arena, 1000, 1);
    bool refused = alloc_succeed();
    ck_assert(ok && !refused);
    pen_arena_free(arena);
}
END_TEST

/* Whichever allocation fails, the arena returns NULL, stays valid, and works again once there is
 * memory. */
START_TEST(test_arena__survives_every_failed_allocation)
{
    bool refused = true;
    for (long n = 0; refused; n++) {
        alloc_fail_after(n);
        struct pen_arena *arena = pen_arena_new(0);
        bool ok = arena;
        for (int i = 0; ok && i < 2000; i++)
            ok = pen_arena_alloc(arena, 100, 1);
        size_t used = arena ? pen_arena_used(arena) : 0;
        refused = alloc_succeed();
        ck_assert_msg(ok == !refused, "allocation %ld: the failure was lost", n);
        if (arena) {
            ck_assert_uint_eq(used % 112, 0);
            ck_assert_ptr_nonnull(pen_arena_alloc(arena, 100, 1));
            ck_assert_uint_eq(pen_arena_used(arena), used + 112);
        }
        pen_arena_free(arena);
        ck_assert_int_lt(n, 100);
    }
}
END_TEST

PEN_SUITE("arena", test_arena__allocations_are_zeroed_aligned_and_disjoint,
          test_arena__overflow_is_refused, test_arena__the_cap_is_exact,
          test_arena__strdup_copies_the_terminating_zero, test_arena__reset_keeps_its_memory,
          test_arena__survives_every_failed_allocation)
