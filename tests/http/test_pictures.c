/* SPDX-License-Identifier: MIT */
/* The large answers: one copy for all clients, and a budget. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "http/internal/pictures.h"
#include "support/suite.h"

enum { PART = 1 << 17 };

static struct pen_image image_of(size_t bytes)
{
    struct pen_image image = {.type = "image/png", .etag = "\"x\""};
    image.bytes.data = calloc(1, bytes + 1);
    ck_assert_ptr_nonnull(image.bytes.data);
    image.bytes.bytes = bytes;
    image.bytes.capacity = bytes + 1;
    return image;
}

static bool take(struct pictures *pictures, const char *job, size_t bytes, struct picture *out)
{
    const struct pen_image_query query = {0};
    struct pen_status st = {0};
    struct pen_image image = image_of(bytes);
    bool ok = pen_http_pictures_take(pictures, job, &query, &image, out, &st);
    ck_assert(ok || st.code == PEN_UNAVAILABLE);
    return ok;
}

START_TEST(test_pictures__readers_share_one_copy)
{
    struct pictures *pictures = pen_http_pictures_new(256 * PART);
    struct picture a, b, c;
    const struct pen_image_query same = {.layer = "beauty", .format = "png"};
    const struct pen_image_query others[] = {{.view = ""},       {.view = "a"},
                                             {.layer = "depth"}, {.format = "pfm"},
                                             {.max_edge = 64},   {.with = "other"}};
    ck_assert(take(pictures, "job", 10 * PART, &a));
    ck_assert(pen_http_pictures_find(pictures, "job", &same, &b));
    ck_assert_ptr_eq(a.blob, b.blob);
    ck_assert_str_eq(b.type, "image/png");
    ck_assert_str_eq(b.etag, "\"x\"");
    ck_assert(take(pictures, "job", 10 * PART, &c));
    ck_assert_ptr_eq(a.blob, c.blob);
    ck_assert(!pen_http_pictures_find(pictures, "jo", &same, &b));
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        ck_assert(!pen_http_pictures_find(pictures, "job", &others[i], &b));
    pen_http_blob_unref(a.blob);
    pen_http_blob_unref(b.blob);
    pen_http_blob_unref(c.blob);
    pen_http_pictures_free(pictures);
}
END_TEST

START_TEST(test_pictures__the_last_ones_are_kept)
{
    enum { MANY = 300 };
    struct pictures *pictures = pen_http_pictures_new(256 * PART);
    const struct pen_image_query query = {0};
    struct picture picture;
    char job[20];
    for (int i = 0; i < MANY; i++) {
        snprintf(job, sizeof job, "job %d", i);
        ck_assert(take(pictures, job, 1000, &picture));
        pen_http_blob_unref(picture.blob);
    }
    for (int i = MANY - 200; i < MANY; i++) {
        snprintf(job, sizeof job, "job %d", i);
        ck_assert(pen_http_pictures_find(pictures, job, &query, &picture));
        pen_http_blob_unref(picture.blob);
    }
    ck_assert(!pen_http_pictures_find(pictures, "job 0", &query, &picture));
    pen_http_pictures_free(pictures);
}
END_TEST

START_TEST(test_pictures__have_a_budget)
{
    enum { READ = 100 };
    struct pictures *pictures = pen_http_pictures_new(256 * PART);
    struct picture read[READ], small;
    int count = 0;
    char job[20];
    while (count < READ) {
        snprintf(job, sizeof job, "job %d", count);
        if (!take(pictures, job, 10 * PART, &read[count]))
            break;
        count++;
    }
    ck_assert_int_eq(count, 25);
    ck_assert(!take(pictures, "another", 10 * PART, &small));
    pen_http_blob_unref(read[--count].blob);
    ck_assert(take(pictures, "another", 10 * PART, &small));
    pen_http_blob_unref(small.blob);
    while (count > 0)
        pen_http_blob_unref(read[--count].blob);
    pen_http_pictures_free(pictures);
}
END_TEST

/* A picture that is larger than the budget is sent if nothing else is. */
START_TEST(test_pictures__beyond_the_budget_there_is_one_alone)
{
    enum { HUGE = 270 * PART };
    struct pictures *pictures = pen_http_pictures_new(256 * PART);
    struct picture usual, huge, other, small;
    ck_assert(take(pictures, "usual", PART, &usual));
    ck_assert(!take(pictures, "huge", HUGE, &huge));
    pen_http_blob_unref(usual.blob);
    ck_assert(take(pictures, "huge", HUGE, &huge)); /* the kept picture has no reader */
    ck_assert(!take(pictures, "another", HUGE, &other));
    ck_assert(!take(pictures, "usual", PART, &usual));
    ck_assert(take(pictures, "small", 1000, &small)); /* only large answers are counted */
    pen_http_blob_unref(small.blob);
    pen_http_blob_unref(huge.blob);
    ck_assert(take(pictures, "usual", PART, &usual));
    pen_http_blob_unref(usual.blob);
    pen_http_pictures_free(pictures);
}
END_TEST

/* Other answers count, too, if they are large. */
START_TEST(test_pictures__other_answers_are_counted)
{
    struct pictures *pictures = pen_http_pictures_new(256 * PART);
    struct picture most;
    struct pen_status st;
    struct pen_buf text = image_of(PART).bytes, small_text = image_of(1000).bytes;
    struct blob *large = pen_http_blob_take(&text), *small = pen_http_blob_take(&small_text);
    ck_assert(take(pictures, "job", 256 * PART - 1, &most));
    ck_assert(pen_http_pictures_count(pictures, NULL, &st));
    ck_assert(pen_http_pictures_count(pictures, small, &st));
    ck_assert(!pen_http_pictures_count(pictures, large, &st));
    ck_assert_int_eq(st.code, PEN_UNAVAILABLE);
    pen_http_blob_unref(most.blob);
    for (int i = 0; i < 2; i++)
        ck_assert(pen_http_pictures_count(pictures, large, &st));
    ck_assert(!take(pictures, "job", 256 * PART, &most));
    ck_assert(take(pictures, "job", 255 * PART, &most)); /* it was counted once */
    pen_http_blob_unref(most.blob);
    pen_http_blob_unref(large);
    ck_assert(take(pictures, "another", 256 * PART, &most));
    pen_http_blob_unref(most.blob);
    pen_http_blob_unref(small);
    pen_http_pictures_free(pictures);
}
END_TEST

PEN_SUITE("pictures", test_pictures__readers_share_one_copy, test_pictures__the_last_ones_are_kept,
          test_pictures__have_a_budget, test_pictures__beyond_the_budget_there_is_one_alone,
          test_pictures__other_answers_are_counted)
