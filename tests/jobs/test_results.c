/* SPDX-License-Identifier: MIT */
/* Pictures of jobs: formats, views, the contact sheet, the preview of committed pixels, errors. */
#include <stdio.h>
#include <string.h>

#include "film/encode.h"
#include "support/jobs.h"
#include "support/suite.h"

static struct jobs_bed bed;
static char id[PEN_ID_BYTES];

static const char small[] = ", \"render\": {\"width\": 24, \"height\": 18, \"tile\": 8}";

static bool ask(const char *view, const char *layer, const char *format, struct pen_image *image,
                struct pen_status *st)
{
    struct pen_image_query query = {.view = view, .layer = layer, .format = format};
    return pen_jobs_image(bed.jobs, id, &query, image, st);
}

static void refuse(const char *view, const char *layer, const char *format, enum pen_code code)
{
    struct pen_image image;
    struct pen_status st;
    ck_assert(!ask(view, layer, format, &image, &st));
    ck_assert_msg(st.code == code, "%s: %s", pen_code_name(st.code), st.msg);
    ck_assert_ptr_null(image.bytes.data);
}

static void finished_job(const char *more)
{
    jobs_bed_open(&bed);
    jobs_worker_start(&bed);
    jobs_submit(&bed, jobs_scene(more), id);
    ck_assert_int_eq(jobs_wait(&bed, id), PEN_JOB_SUCCEEDED);
}

/* The job's PFM as a film. A PFM has its rows from the bottom up, after three header lines. */
static struct pen_film *film_of_job(const char *view, int width, int height)
{
    struct pen_status st;
    struct pen_buf pfm = jobs_image(&bed, id, view, "pfm");
    struct pen_film *film = pen_film_new(width, height, &st);
    size_t row = (size_t)width * 3 * sizeof(float);
    ck_assert_uint_gt(pfm.bytes, row * (size_t)height);
    const unsigned char *values = pfm.data + pfm.bytes - row * (size_t)height;
    for (int y = 0; y < height; y++)
        memcpy(film->rgb + (size_t)y * (size_t)width * 3, values + row * (size_t)(height - 1 - y),
               row);
    pen_buf_release(&pfm);
    return film;
}

static void expect_png(const struct pen_film *film, const struct pen_png_options *options,
                       const struct pen_buf *found)
{
    struct pen_buf expected = {0};
    struct pen_status st;
    store_must(pen_png_write(film, options, &expected, &st), &st, "png");
    ck_assert_uint_eq(found->bytes, expected.bytes);
    ck_assert_mem_eq(found->data, expected.data, expected.bytes);
    pen_buf_release(&expected);
}

START_TEST(test_results__formats_are_made_of_the_same_pixels)
{
    finished_job(small);
    struct pen_film *film = film_of_job(NULL, 24, 18);
    for (int bits = 8; bits <= 16; bits += 8) {
        struct pen_png_options options = {.bits = bits, .transfer = PEN_TRANSFER_SRGB};
        struct pen_buf png = jobs_image(&bed, id, "main", bits == 8 ? "png" : "png16");
        expect_png(film, &options, &png);
        pen_buf_release(&png);
    }
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_results__transfer_of_the_settings_is_applied)
{
    finished_job(", \"render\": {\"width\": 24, \"height\": 18, \"transfer\": \"linear\"}");
    struct pen_film *film = film_of_job(NULL, 24, 18);
    struct pen_png_options options = {.bits = 8, .transfer = PEN_TRANSFER_LINEAR};
    struct pen_buf png = jobs_image(&bed, id, NULL, NULL);
    expect_png(film, &options, &png);
    pen_buf_release(&png);
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_results__tag_and_type_are_stable_and_differ_by_format)
{
    struct pen_image first, again, other;
    struct pen_status st;
    finished_job(small);
    store_must(ask(NULL, "beauty", "pfm", &first, &st), &st, "image");
    store_must(ask(NULL, NULL, "pfm", &again, &st), &st, "image");
    store_must(ask(NULL, NULL, "png16", &other, &st), &st, "image");
    ck_assert_str_eq(first.etag, again.etag);
    ck_assert_str_ne(first.etag, other.etag);
    ck_assert_int_eq(first.etag[0], '"');
    ck_assert_int_eq(first.etag[strlen(first.etag) - 1], '"');
    ck_assert_str_eq(other.type, "image/png");
    ck_assert_str_ne(first.type, other.type);
    pen_buf_release(&first.bytes);
    pen_buf_release(&again.bytes);
    pen_buf_release(&other.bytes);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_results__missing_views_and_layers_are_refused)
{
    finished_job(small);
    refuse("left", NULL, NULL, PEN_NOT_FOUND);
    refuse(NULL, "depth", NULL, PEN_NOT_FOUND);
    refuse(NULL, "dept", NULL, PEN_USAGE);
    refuse(NULL, NULL, "jpeg", PEN_USAGE);
    strcpy(id, "01900000-0000-7000-8000-000000000000");
    refuse(NULL, NULL, NULL, PEN_NOT_FOUND);
    jobs_bed_close(&bed);
}
END_TEST

START_TEST(test_results__only_a_succeeded_job_has_its_picture)
{
    struct pen_status st;
    jobs_bed_open(&bed);
    jobs_submit(&bed, jobs_scene(small), id);
    refuse(NULL, NULL, NULL, PEN_CONFLICT);
    struct pen_claim claim = store_claim(bed.bed.store, "w");
    refuse(NULL, NULL, NULL, PEN_CONFLICT);
    store_must(pen_store_fail(bed.bed.store, &claim, "{}", &st), &st, "fail");
    refuse(NULL, NULL, "pfm", PEN_CONFLICT);
    jobs_submit(&bed, jobs_scene(small), id);
    store_must(pen_store_cancel(bed.bed.store, id, NULL, &st), &st, "cancel");
    refuse(NULL, NULL, "png16", PEN_CONFLICT);
    jobs_bed_close(&bed);
}
END_TEST

static const char three_views[] =
    ", \"views\": [{\"name\": \"a\"}, {\"name\": \"b\", \"camera\": {\"position\": [4, 2, 8]}},"
    " {\"name\": \"c\", \"camera\": {\"position\": [-4, 2, 8]}}],"
    " \"render\": {\"width\": 24, \"height\": 18}";

START_TEST(test_results__contact_sheet_holds_the_views_in_a_grid)
{
    static const char *const names[] = {"a", "b", "c"};
    finished_job(three_views);
    struct pen_film *sheet = film_of_job("all", 49, 37); /* a gap of one pixel */
    for (int i = 0; i < 3; i++) {
        struct pen_film *view = film_of_job(names[i], 24, 18);
        for (int y = 0; y < 18; y++) {
            const float *cell = sheet->rgb + 3 * ((i / 2 * 19 + y) * 49 + i % 2 * 25);
            ck_assert_mem_eq(cell, view->rgb + (ptrdiff_t)3 * 24 * y, 24 * 3 * sizeof(float));
        }
        pen_film_free(view);
    }
    for (int i = 0; i < 24 * 3; i++) /* the fourth cell is empty, and so are the gaps */
        ck_assert(sheet->rgb[3 * (19 * 49 + 25) + i] == 0);
    for (int i = 0; i < 49 * 3; i++)
        ck_assert(sheet->rgb[3 * 18 * 49 + i] == 0);
    for (int i = 0; i < 37 * 3; i++)
        ck_assert(sheet->rgb[3 * (i / 3 * 49 + 24) + i % 3] == 0);
    struct pen_png_options options = {.bits = 8, .transfer = PEN_TRANSFER_SRGB};
    struct pen_buf png = jobs_image(&bed, id, "all", "png");
    expect_png(sheet, &options, &png);
    pen_buf_release(&png);
    pen_film_free(sheet);
    jobs_bed_close(&bed);
}
END_TEST

/* Commits a batch of the job without rendering: the value of each pixel is its number. */
static void commit_numbers(const struct pen_claim *claim)
{
    struct pen_status st;
    static float rgb[64 * 64 * 3];
    ck_assert_int_le(claim->pixels, 64 * 64);
    for (int64_t i = 0; i < claim->pixels * 3; i++)
        rgb[i] = (float)i / (float)(claim->pixels * 3);
    struct pen_result result = {.rgb = rgb, .pixels = claim->pixels, .stats = "{}"};
    store_must(pen_store_commit(bed.bed.store, claim, &result, NULL, &st), &st, "commit");
}

static struct pen_buf preview(void)
{
    struct pen_image image;
    struct pen_status st;
    store_must(pen_jobs_preview(bed.jobs, id, NULL, &image, &st), &st, "preview");
    ck_assert_str_eq(image.type, "image/png");
    return image.bytes;
}

START_TEST(test_results__preview_shows_committed_pixels_and_is_transparent_elsewhere)
{
    enum { SIZE = 64, TILE = 16 };
    struct pen_status st;
    unsigned char mask[SIZE * SIZE] = {0};
    struct pen_png_options options = {.bits = 8, .transfer = PEN_TRANSFER_SRGB, .mask = mask};
    struct pen_film *film = pen_film_new(SIZE, SIZE, &st);
    jobs_bed_open(&bed);
    jobs_submit(&bed,
                jobs_scene(", \"render\": {\"width\": 64, \"height\": 64, \"tile\": 16,"
                           " \"samples_per_pixel\": 2000}"),
                id);
    struct pen_buf empty = preview();
    expect_png(film, &options, &empty);
    pen_buf_release(&empty);
    store_claim(bed.bed.store, "w");
    struct pen_claim claim = store_claim(bed.bed.store, "w");
    ck_assert_int_gt(claim.first_tile, 0);
    commit_numbers(&claim);
    int64_t n = 0;
    for (int t = claim.first_tile; t < claim.first_tile + claim.tile_count; t++) {
        for (int i = 0; i < TILE * TILE; i++, n++) {
            int x = t % (SIZE / TILE) * TILE + i % TILE, y = t / (SIZE / TILE) * TILE + i / TILE;
            mask[y * SIZE + x] = 1;
            for (int c = 0; c < 3; c++)
                film->rgb[3 * (y * SIZE + x) + c] = (float)(3 * n + c) / (float)(claim.pixels * 3);
        }
    }
    struct pen_buf partly = preview();
    expect_png(film, &options, &partly);
    pen_buf_release(&partly);
    store_must(pen_store_cancel(bed.bed.store, id, NULL, &st), &st, "cancel");
    partly = preview();
    expect_png(film, &options, &partly);
    pen_buf_release(&partly);
    struct pen_image image;
    const struct pen_image_query nowhere = {.view = "nowhere"};
    ck_assert(!pen_jobs_preview(bed.jobs, id, &nowhere, &image, &st));
    ck_assert_int_eq(st.code, PEN_NOT_FOUND);
    pen_film_free(film);
    jobs_bed_close(&bed);
}
END_TEST

PEN_SUITE("results", test_results__formats_are_made_of_the_same_pixels,
          test_results__transfer_of_the_settings_is_applied,
          test_results__tag_and_type_are_stable_and_differ_by_format,
          test_results__missing_views_and_layers_are_refused,
          test_results__only_a_succeeded_job_has_its_picture,
          test_results__contact_sheet_holds_the_views_in_a_grid,
          test_results__preview_shows_committed_pixels_and_is_transparent_elsewhere)
