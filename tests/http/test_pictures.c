/* SPDX-License-Identifier: MIT */
/* The large answers: one copy for all, and a budget. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "http/internal/pictures.h"
#include "support/suite.h"

enum { MIB = 1 << 20 };

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
    const struct picture_key key = {.job = job};
    struct pen_status st = {0};
    struct pen_image image = image_of(bytes);
    bool ok = pen_http_pictures_take(pictures, job ? &key : NULL, &image, NULL, out, &st);
    ck_assert(ok || st.code == PEN_UNAVAILABLE);
    return ok;
}

START_TEST(test_pictures__readers_share_one_copy)
{
    struct pictures *pictures = pen_http_pictures_new();
    struct picture a, b, c;
    const struct picture_key same = {.job = "job", .layer = "beauty", .format = "png"};
    const struct picture_key others[] = {{.job = "jo"},
                                         {.job = "job", .view = ""},
                                         {.job = "job", .view = "a"},
                                         {.job = "job", .layer = "depth"},
                                         {.job = "job", .format = "pfm"}};
    ck_assert(take(pictures, "job", 10 * MIB, &a));
    ck_assert(pen_http_pictures_find(pictures, &same, &b));
    ck_assert_ptr_eq(a.blob, b.blob);
    ck_assert_str_eq(b.type, "image/png");
    ck_assert_str_eq(b.etag, "\"x\"");
    ck_assert(take(pictures, "job", 10 * MIB, &c));
    ck_assert_ptr_eq(a.blob, c.blob);
    for (size_t i = 0; i < sizeof others / sizeof others[0]; i++)
        ck_assert(!pen_http_pictures_find(pictures, &others[i], &b));
    pen_http_blob_unref(a.blob);
    pen_http_blob_unref(b.blob);
    pen_http_blob_unref(c.blob);
    pen_http_pictures_free(pictures);
}
END_TEST

START_TEST(test_pictures__have_a_budget)
{
    enum { READ = 100 };
    struct pictures *pictures = pen_http_pictures_new();
    struct picture read[READ], small;
    int count = 0;
    char job[20];
    while (count < READ) {
        snprintf(job, sizeof job, "job %d", count);
        if (!take(pictures, count % 2 ? job : NULL, 10 * MIB, &read[count]))
            break;
        count++;
    }
    ck_assert_int_eq(count, 25);
    ck_assert(!take(pictures, "another", 10 * MIB, &small));
    pen_http_blob_unref(read[--count].blob);
    ck_assert(take(pictures, "another", 10 * MIB, &small));
    pen_http_blob_unref(small.blob);
    while (count > 0)
        pen_http_blob_unref(read[--count].blob);
    pen_http_pictures_free(pictures);
}
END_TEST

static bool reserve(struct pictures *pictures, size_t bytes, struct picture_room *room)
{
    struct pen_status st = {0};
    *room = (struct picture_room){.bytes = bytes};
    const bool ok = pen_http_pictures_reserve(pictures, room, &st);
    ck_assert(ok || (st.code == PEN_UNAVAILABLE && room->bytes == 0));
    return ok;
}

/* Takes a picture that was made in a room. */
static bool take_made(struct pictures *pictures, const char *job, size_t bytes,
                      struct picture_room *room, struct picture *out)
{
    const struct picture_key key = {.job = job};
    struct pen_status st = {0};
    struct pen_image image = image_of(bytes);
    const bool ok = pen_http_pictures_take(pictures, &key, &image, room, out, &st);
    ck_assert(ok || st.code == PEN_UNAVAILABLE);
    ck_assert_uint_eq(room->bytes, 0);
    return ok;
}

START_TEST(test_pictures__memory_is_reserved_before_they_are_made)
{
    struct pictures *pictures = pen_http_pictures_new();
    struct picture_room a, b;
    struct picture picture;
    ck_assert(reserve(pictures, 200 * MIB, &a));
    ck_assert(!reserve(pictures, 200 * MIB, &b));
    pen_http_pictures_give_up(pictures, &a);
    ck_assert(reserve(pictures, 200 * MIB, &b));
    /* What is made takes less than making it. A kept picture that nobody reads is dropped. */
    ck_assert(take_made(pictures, "job", 80 * MIB, &b, &picture));
    ck_assert(!reserve(pictures, 200 * MIB, &a));
    pen_http_blob_unref(picture.blob);
    ck_assert(reserve(pictures, 200 * MIB, &a));
    pen_http_pictures_give_up(pictures, &a);
    pen_http_pictures_free(pictures);
}
END_TEST

START_TEST(test_pictures__beyond_the_budget_there_is_one_at_a_time)
{
    struct pictures *pictures = pen_http_pictures_new();
    struct picture_room huge, other, usual;
    struct picture picture;
    ck_assert(reserve(pictures, 900 * (size_t)MIB, &huge));
    ck_assert(!reserve(pictures, 800 * (size_t)MIB, &other));
    ck_assert(reserve(pictures, 200 * MIB, &usual)); /* the budget is as it was */
    ck_assert(take_made(pictures, "huge", 270 * MIB, &huge, &picture));
    ck_assert(!reserve(pictures, 800 * (size_t)MIB, &other));
    pen_http_blob_unref(picture.blob);
    ck_assert(reserve(pictures, 800 * (size_t)MIB, &other)); /* nobody reads the kept one */
    pen_http_pictures_give_up(pictures, &other);
    pen_http_pictures_give_up(pictures, &usual);
    pen_http_pictures_free(pictures);
}
END_TEST

/* Other answers count, too, if they are large. */
START_TEST(test_pictures__other_answers_are_counted)
{
    struct pictures *pictures = pen_http_pictures_new();
    struct picture_room most;
    struct pen_status st;
    struct pen_buf text = image_of(MIB).bytes, small_text = image_of(1000).bytes;
    struct blob *large = pen_http_blob_take(&text), *small = pen_http_blob_take(&small_text);
    ck_assert(reserve(pictures, 256 * MIB - 1, &most));
    ck_assert(pen_http_pictures_count(pictures, NULL, &st));
    ck_assert(pen_http_pictures_count(pictures, small, &st));
    ck_assert(!pen_http_pictures_count(pictures, large, &st));
    ck_assert_int_eq(st.code, PEN_UNAVAILABLE);
    pen_http_pictures_give_up(pictures, &most);
    ck_assert(pen_http_pictures_count(pictures, large, &st));
    ck_assert(!reserve(pictures, 256 * MIB, &most));
    pen_http_blob_unref(large);
    ck_assert(reserve(pictures, 256 * MIB, &most));
    pen_http_pictures_give_up(pictures, &most);
    pen_http_blob_unref(small);
    pen_http_pictures_free(pictures);
}
END_TEST

PEN_SUITE("pictures", test_pictures__readers_share_one_copy, test_pictures__have_a_budget,
          test_pictures__memory_is_reserved_before_they_are_made,
          test_pictures__beyond_the_budget_there_is_one_at_a_time,
          test_pictures__other_answers_are_counted)
