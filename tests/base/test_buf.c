/* SPDX-License-Identifier: MIT */
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "base/buf.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

START_TEST(test_buf__appends_and_ends_with_zero)
{
    struct pen_buf buf;
    pen_buf_init(&buf);
    ck_assert(buf.data == NULL && buf.bytes == 0 && !buf.failed);
    ck_assert(pen_buf_puts(&buf, ""));
    ck_assert_str_eq((const char *)buf.data, "");
    ck_assert(pen_buf_puts(&buf, "ab") && pen_buf_add(&buf, "c\0d", 3));
    ck_assert(pen_buf_printf(&buf, "%d-%s", 42, "x") && pen_buf_printf(&buf, "%s", ""));
    ck_assert_uint_eq(buf.bytes, 9);
    ck_assert_mem_eq(buf.data, "abc\0d42-x", 10);
    ck_assert(pen_buf_add(&buf, NULL, 0));
    pen_buf_release(&buf);
    ck_assert(buf.data == NULL && buf.bytes == 0 && buf.capacity == 0);
    pen_buf_release(&buf);
}
END_TEST

/* Compares the contents with a plain array, through many growth steps. */
START_TEST(test_buf__holds_what_was_appended)
{
    struct random r = random_begin(1);
    enum { MAX = 1 << 20 };
    static char expected[MAX];
    size_t used = 0;
    struct pen_buf buf = {0};
    while (used < MAX / 2) {
        char piece[3000];
        size_t bytes = random_below(&r, random_below(&r, 20) ? 40 : sizeof piece - 1);
        for (size_t i = 0; i < bytes; i++)
            piece[i] = (char)('a' + random_below(&r, 26));
        piece[bytes] = '\0';
        if (random_below(&r, 2))
            pen_buf_add(&buf, piece, bytes);
        else
            pen_buf_printf(&buf, "%s", piece);
        memcpy(expected + used, piece, bytes + 1);
        used += bytes;
        if (buf.bytes != used || buf.capacity <= used || buf.data[used] != '\0')
            ck_abort_msg("seed %llu: %zu bytes", (unsigned long long)r.seed, used);
    }
    ck_assert(memcmp(buf.data, expected, used + 1) == 0);
    pen_buf_release(&buf);
}
END_TEST

START_TEST(test_buf__writes_numbers_as_printf_does)
{
    uint64_t numbers[] = {0, 9, 10, 99, 100, 429, 9999999999, UINT64_MAX / 10, UINT64_MAX};
    for (size_t i = 0; i < sizeof numbers / sizeof numbers[0]; i++) {
        struct pen_buf written = {0}, formatted = {0};
        ck_assert(pen_buf_number(&written, numbers[i]));
        ck_assert(pen_buf_printf(&formatted, "%" PRIu64, numbers[i]));
        ck_assert_str_eq((char *)written.data, (char *)formatted.data);
        ck_assert_uint_eq(written.bytes, formatted.bytes);
        pen_buf_release(&written);
        pen_buf_release(&formatted);
    }
}
END_TEST

START_TEST(test_buf__a_failed_append_changes_nothing_and_sticks)
{
    bool refused = true;
    for (long n = 0; refused; n++) {
        struct pen_buf buf = {0};
        bool ok = true, all = true;
        size_t last = 0;
        alloc_fail_after(n);
        for (int i = 0; i < 3000; i++) {
            ok = i % 2 ? pen_buf_puts(&buf, "twelve bytes") : pen_buf_printf(&buf, "%012d", i);
            all = all && ok;
            if (all)
                last = buf.bytes;
        }
        refused = alloc_succeed();
        bool later = pen_buf_puts(&buf, "x");
        ck_assert_msg(all == !refused && buf.failed == refused && later == !refused,
                      "allocation %ld", n);
        ck_assert_uint_eq(buf.bytes, refused ? last : last + 1);
        ck_assert(!buf.data || buf.data[buf.bytes] == '\0');
        pen_buf_release(&buf);
        ck_assert(!buf.failed && pen_buf_puts(&buf, "again"));
        pen_buf_release(&buf);
        ck_assert_int_lt(n, 100);
    }
}
END_TEST

START_TEST(test_buf__reserved_space_is_neither_more_nor_moved)
{
    struct pen_buf buf = {0};
    ck_assert(pen_buf_add(&buf, "begin", 5) && pen_buf_reserve(&buf, 1000));
    ck_assert_uint_eq(buf.capacity, 1001); /* with the zero byte */
    ck_assert_str_eq((const char *)buf.data, "begin");
    const unsigned char *data = buf.data;
    for (int i = 5; i < 1000; i++)
        ck_assert(pen_buf_add(&buf, "x", 1));
    ck_assert_ptr_eq(buf.data, data);
    ck_assert(!pen_buf_reserve(&buf, SIZE_MAX) && !buf.failed);
    ck_assert_uint_eq(buf.bytes, 1000);
    pen_buf_release(&buf);
}
END_TEST

START_TEST(test_buf__sizes_beyond_memory_are_refused)
{
    struct pen_buf buf = {0};
    ck_assert(pen_buf_puts(&buf, "x"));
    ck_assert(!pen_buf_add(&buf, "", SIZE_MAX));
    ck_assert(buf.failed && buf.bytes == 1 && strcmp((const char *)buf.data, "x") == 0);
    pen_buf_release(&buf);
}
END_TEST

PEN_SUITE("buf", test_buf__reserved_space_is_neither_more_nor_moved,
          test_buf__appends_and_ends_with_zero, test_buf__holds_what_was_appended,
          test_buf__a_failed_append_changes_nothing_and_sticks,
          test_buf__sizes_beyond_memory_are_refused, test_buf__writes_numbers_as_printf_does)
