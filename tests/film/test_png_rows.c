/* SPDX-License-Identifier: MIT */
/* A PNG written some rows at a time has the bytes of a PNG written at once, even if rows are not
 * finished when they are due. A file that is given up or fails leaves nothing behind. */
#include <stdlib.h>
#include <string.h>

#include "film/encode.h"
#include "support/alloc.h"
#include "support/random.h"
#include "support/suite.h"

enum { SIDE_MAX = 70, PIXELS_MAX = SIDE_MAX * SIDE_MAX };

static float pixels[PIXELS_MAX * 3], shown[PIXELS_MAX * 3];
static unsigned char mask[PIXELS_MAX];

static struct pen_film random_film(struct random *r, int width, int height)
{
    for (int i = 0; i < width * height * 3; i++)
        pixels[i] = (float)random_in(r, -0.1, 1.3);
    for (int i = 0; i < width * height; i++)
        mask[i] = random_below(r, 2) == 0;
    return (struct pen_film){width, height, pixels};
}

/* Writes the film through another whose rows are filled in only just before they are due. */
static void write_in_parts(struct random *r, const struct pen_film *film,
                           const struct pen_png_options *options, struct pen_buf *out)
{
    struct pen_status st;
    struct pen_film late = {film->width, film->height, shown};
    memset(shown, 0, sizeof shown);
    struct pen_png_writer *writer = pen_png_begin(&late, options, out, &st);
    ck_assert(writer != NULL);
    for (int rows = 0; rows < film->height;) {
        int more = 1 + (int)random_below(r, 12);
        rows = rows + more < film->height ? rows + more : film->height;
        memcpy(shown, pixels, (size_t)rows * (size_t)film->width * 3 * sizeof *shown);
        if (rows < film->height || random_below(r, 2))
            pen_png_rows(writer, rows); /* the end writes what is left */
    }
    ck_assert_msg(pen_png_end(writer, &st), "%s", st.msg);
    pen_png_free(writer);
}

START_TEST(test_png_rows__parts_have_the_bytes_of_the_whole)
{
    struct random r = random_begin(11);
    for (int i = 0; i < 120; i++) {
        int width = 1 + (int)random_below(&r, SIDE_MAX),
            height = 1 + (int)random_below(&r, SIDE_MAX);
        struct pen_film film = random_film(&r, width, height);
        struct pen_png_options options = {.bits = i & 1 ? 16 : 8,
                                          .transfer =
                                              i & 2 ? PEN_TRANSFER_LINEAR : PEN_TRANSFER_SRGB,
                                          .mask = i & 4 ? mask : NULL};
        struct pen_buf whole = {0}, parts = {0};
        struct pen_status st;
        ck_assert(pen_png_write(&film, &options, &whole, &st));
        write_in_parts(&r, &film, &options, &parts);
        ck_assert_msg(whole.bytes == parts.bytes &&
                          memcmp(whole.data, parts.data, whole.bytes) == 0,
                      "seed %llu, %d x %d, case %d", (unsigned long long)r.seed, width, height, i);
        pen_buf_release(&whole);
        pen_buf_release(&parts);
    }
}
END_TEST

/* Rows that are due twice, or beyond the last, change nothing. */
START_TEST(test_png_rows__rows_are_written_once)
{
    struct random r = random_begin(12);
    struct pen_film film = random_film(&r, 33, 21);
    struct pen_png_options options = {.bits = 8};
    struct pen_buf whole = {0}, parts = {0};
    struct pen_status st;
    ck_assert(pen_png_write(&film, &options, &whole, &st));
    struct pen_png_writer *writer = pen_png_begin(&film, &options, &parts, &st);
    static const int ends[] = {5, 5, 3, 0, 20, 21, 21};
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++)
        pen_png_rows(writer, ends[i]);
    ck_assert(pen_png_end(writer, &st));
    ck_assert(whole.bytes == parts.bytes && memcmp(whole.data, parts.data, whole.bytes) == 0);
    pen_png_free(writer);
    pen_buf_release(&whole);
    pen_buf_release(&parts);
}
END_TEST

START_TEST(test_png_rows__a_file_can_be_given_up)
{
    struct random r = random_begin(13);
    struct pen_film film = random_film(&r, SIDE_MAX, SIDE_MAX);
    struct pen_png_options options = {.bits = 16};
    for (int rows = 0; rows <= SIDE_MAX; rows += 10) {
        struct pen_buf out = {0};
        struct pen_status st;
        struct pen_png_writer *writer = pen_png_begin(&film, &options, &out, &st);
        pen_png_rows(writer, rows);
        pen_png_free(writer);
        pen_buf_release(&out);
    }
    pen_png_free(NULL);
}
END_TEST

/* An allocation that fails during some rows makes the end fail, even if memory is there again, and
 * nothing is written after it. */
START_TEST(test_png_rows__a_failure_is_kept_until_the_end)
{
    struct random r = random_begin(14);
    struct pen_film film = random_film(&r, SIDE_MAX, SIDE_MAX);
    struct pen_png_options options = {.bits = 16};
    int failed = 0;
    for (long n = 0; n < 3; n++) {
        struct pen_buf out = {0};
        struct pen_status st = {.code = PEN_OK};
        struct pen_png_writer *writer = pen_png_begin(&film, &options, &out, &st);
        ck_assert(writer != NULL);
        alloc_fail_after(n);
        pen_png_rows(writer, SIDE_MAX - 1);
        bool refused = alloc_succeed();
        size_t bytes = out.bytes;
        pen_png_rows(writer, SIDE_MAX);
        ck_assert(!refused || out.bytes == bytes);
        ck_assert_int_eq(pen_png_end(writer, &st), !refused);
        ck_assert_int_eq(st.code, refused ? PEN_NO_MEMORY : PEN_OK);
        ck_assert(!refused || out.bytes == bytes);
        failed += refused;
        pen_png_free(writer);
        pen_buf_release(&out);
    }
    ck_assert_int_gt(failed, 0);
}
END_TEST

PEN_SUITE("png_rows", test_png_rows__parts_have_the_bytes_of_the_whole,
          test_png_rows__rows_are_written_once, test_png_rows__a_file_can_be_given_up,
          test_png_rows__a_failure_is_kept_until_the_end)
