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
    bool ok = pen_http_pictures_take(pictures, job ? &key : NULL, &image, out, &st);
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
    /* Pictures that nobody reads give way; one alone may be larger than the budget. */
    ck_assert(take(pictures, NULL, 200 * MIB, &small));
    pen_http_blob_unref(small.blob);
    pen_http_pictures_free(pictures);
}
END_TEST

PEN_SUITE("pictures", test_pictures__readers_share_one_copy, test_pictures__have_a_budget)
