/* SPDX-License-Identifier: MIT */
/* The pictures in memory: one copy for all, and a budget that leaves room for small ones. */
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
    ck_assert_int_ge(count, 8);
    ck_assert_int_le(count, 16);
    ck_assert(take(pictures, NULL, MIB / 2, &small));
    pen_http_blob_unref(small.blob);
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
    const bool ok = pen_http_pictures_reserve(pictures, room, 0, &st);
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
    struct picture_room a, b, small;
    struct picture picture;
    ck_assert(reserve(pictures, 100 * MIB, &a));
    ck_assert(!reserve(pictures, 100 * MIB, &b));
    ck_assert(reserve(pictures, 4 * MIB, &small)); /* small ones go on */
    pen_http_pictures_give_up(pictures, &small);
    pen_http_pictures_give_up(pictures, &a);
    ck_assert(reserve(pictures, 100 * MIB, &b));
    /* What is made takes less than making it; a kept picture gives way. */
    ck_assert(take_made(pictures, "job", 40 * MIB, &b, &picture));
    ck_assert(!reserve(pictures, 100 * MIB, &a));
    pen_http_blob_unref(picture.blob);
    ck_assert(reserve(pictures, 100 * MIB, &a));
    pen_http_pictures_give_up(pictures, &a);
    pen_http_pictures_free(pictures);
}
END_TEST

/* Of a picture that is made in the memory of its file it is known that it will not be small. */
START_TEST(test_pictures__that_will_not_be_small_have_no_reserve)
{
    struct pictures *pictures = pen_http_pictures_new();
    struct picture_room large, small, file = {.bytes = 4 * MIB, .file_bytes = 4 * MIB};
    struct pen_status st = {0};
    ck_assert(reserve(pictures, 126 * MIB, &large));
    ck_assert(!pen_http_pictures_reserve(pictures, &file, 0, &st));
    ck_assert_int_eq(st.code, PEN_UNAVAILABLE);
    ck_assert(reserve(pictures, 4 * MIB, &small));
    pen_http_pictures_give_up(pictures, &small);
    pen_http_pictures_give_up(pictures, &large);
    file = (struct picture_room){.bytes = 4 * MIB, .file_bytes = 4 * MIB};
    ck_assert(pen_http_pictures_reserve(pictures, &file, 0, &st));
    pen_http_pictures_give_up(pictures, &file);
    pen_http_pictures_free(pictures);
}
END_TEST

START_TEST(test_pictures__beyond_the_budget_there_is_one_at_a_time)
{
    struct pictures *pictures = pen_http_pictures_new();
    const struct picture_key key = {.job = "huge"};
    struct picture_room huge, other, usual;
    struct picture picture, again;
    ck_assert(reserve(pictures, 900 * (size_t)MIB, &huge));
    ck_assert(!reserve(pictures, 800 * (size_t)MIB, &other));
    ck_assert(reserve(pictures, 100 * MIB, &usual)); /* the budget is as it was */
    pen_http_pictures_give_up(pictures, &usual);
    ck_assert(take_made(pictures, "huge", 130 * MIB, &huge, &picture));
    ck_assert(!reserve(pictures, 800 * (size_t)MIB, &other));
    ck_assert(pen_http_pictures_find(pictures, &key, &again));
    ck_assert_ptr_eq(again.blob, picture.blob);
    pen_http_blob_unref(picture.blob);
    ck_assert(!reserve(pictures, 800 * (size_t)MIB, &other));
    pen_http_blob_unref(again.blob); /* its last reader goes, and so does it */
    ck_assert(!pen_http_pictures_find(pictures, &key, &again));
    ck_assert(reserve(pictures, 800 * (size_t)MIB, &other));
    /* One whose file fits into the budget is kept as any other, and its place is free. */
    ck_assert(take_made(pictures, "huge", 10 * MIB, &other, &picture));
    pen_http_blob_unref(picture.blob);
    ck_assert(pen_http_pictures_find(pictures, &key, &again));
    ck_assert(reserve(pictures, 800 * (size_t)MIB, &other));
    pen_http_pictures_give_up(pictures, &other);
    pen_http_blob_unref(again.blob);
    pen_http_pictures_free(pictures);
}
END_TEST

PEN_SUITE("pictures", test_pictures__readers_share_one_copy, test_pictures__have_a_budget,
          test_pictures__memory_is_reserved_before_they_are_made,
          test_pictures__that_will_not_be_small_have_no_reserve,
          test_pictures__beyond_the_budget_there_is_one_at_a_time)
