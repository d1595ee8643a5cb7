/* SPDX-License-Identifier: MIT */
/* Whether two rows must show the same picture follows from the settings in which they differ. A
 * setting counts as changing the picture unless it is listed here. */
#include "study/internal/pictures.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"
#include "film/film.h"
#include "film/metrics.h"
#include "render/transfer.h"
#include "report/values.h"

struct pen_bench_pictures {
    const struct pen_bench *bench;
    size_t capacity;   /* number of values of the largest picture */
    float **target;    /* by view */
    float **reference; /* by row and view; NULL where an earlier row has the same picture */
};

static bool is_one_of(const char *key, const char *const *names)
{
    for (; *names; names++) {
        if (strcmp(key, *names) == 0)
            return true;
    }
    return false;
}

/* Whether two rows have the same value for every varied setting except those in names[]. */
static bool same_except(const struct pen_bench_row *a, const struct pen_bench_row *b,
                        const char *const *names)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)a->varied, key, value)
    {
        if (!is_one_of(key, names) && !json_equal(value, json_object_get(b->varied, key)))
            return false;
    }
    return true;
}

bool pen_bench_rows_same_work(const struct pen_bench_row *a, const struct pen_bench_row *b)
{
    static const char *const names[] = {"threads", "tile", NULL};
    return same_except(a, b, names);
}

bool pen_bench_rows_same_quality(const struct pen_bench_row *a, const struct pen_bench_row *b)
{
    static const char *const names[] = {"accelerator", "threads", "tile", "precision", NULL};
    return same_except(a, b, names);
}

static bool same_picture(const struct pen_bench_row *a, const struct pen_bench_row *b)
{
    static const char *const names[] = {"accelerator", "threads", "tile", NULL};
    /* In single precision a tree's boxes decide which intersections are found. */
    if (a->settings.precision == PEN_PRECISION_FAST)
        return pen_bench_rows_same_work(a, b);
    return same_except(a, b, names);
}

int pen_bench_pictures_first(const struct pen_bench *bench, int row)
{
    int first = 0;
    while (!same_picture(&bench->rows[first], &bench->rows[row]))
        first++;
    return first;
}

static int first_of_size(const struct pen_bench *bench, int row)
{
    const struct pen_settings *s = &bench->rows[row].settings;
    int first = 0;
    while (bench->rows[first].settings.width != s->width ||
           bench->rows[first].settings.height != s->height)
        first++;
    return first;
}

static size_t value_count(const struct pen_settings *s)
{
    return 3 * (size_t)s->width * (size_t)s->height;
}

double pen_bench_reference_pixels(const struct pen_bench *bench)
{
    double pixels = 0;
    for (int row = 0; row < bench->row_count; row++) {
        if (pen_bench_pictures_first(bench, row) == row)
            pixels += (double)value_count(&bench->rows[row].settings) / 3 * bench->view_count;
    }
    return pixels;
}

struct pen_bench_pictures *pen_bench_pictures_new(const struct pen_bench *bench)
{
    struct pen_bench_pictures *pictures = calloc(1, sizeof *pictures);
    size_t views = (size_t)bench->view_count;
    if (!pictures)
        return NULL;
    pictures->bench = bench;
    pictures->target = calloc(views, sizeof *pictures->target);
    pictures->reference = calloc((size_t)bench->row_count * views, sizeof *pictures->reference);
    for (int row = 0; row < bench->row_count; row++) {
        size_t values = value_count(&bench->rows[row].settings);
        pictures->capacity = values > pictures->capacity ? values : pictures->capacity;
    }
    bool ok = pictures->target && pictures->reference;
    for (size_t i = 0; ok && i < views; i++) {
        pictures->target[i] = pen_memory_large(pictures->capacity * sizeof(float));
        ok = pictures->target[i] != NULL;
    }
    if (ok)
        return pictures;
    pen_bench_pictures_free(pictures);
    return NULL;
}

static void free_all(float **pictures, size_t count)
{
    for (size_t i = 0; pictures && i < count; i++)
        free(pictures[i]);
    free(pictures);
}

void pen_bench_pictures_free(struct pen_bench_pictures *pictures)
{
    if (!pictures)
        return;
    size_t views = (size_t)pictures->bench->view_count;
    free_all(pictures->target, views);
    free_all(pictures->reference, (size_t)pictures->bench->row_count * views);
    free(pictures);
}

float *pen_bench_pictures_target(struct pen_bench_pictures *pictures, int view)
{
    return pictures->target[view];
}

static float **reference_of(const struct pen_bench_pictures *pictures, int row, int view)
{
    return &pictures->reference[row * pictures->bench->view_count + view];
}

/* "row 2 (accelerator none, threads 1)" */
static void name_row(const struct pen_bench *bench, int row, struct pen_buf *out)
{
    const json_t *varied = bench->rows[row].varied;
    pen_buf_printf(out, "row %d", row);
    if (json_object_size(varied) == 0)
        return;
    pen_buf_puts(out, " (");
    pen_write_settings(varied, out);
    pen_buf_puts(out, ")");
}

/* Fails, and names the first value in which two pictures differ. */
static bool fail_different(const struct pen_bench_pictures *pictures, int row, int view,
                           size_t value, struct pen_status *st)
{
    static const char *const channels[] = {"red", "green", "blue"};
    const struct pen_bench *bench = pictures->bench;
    const int first = pen_bench_pictures_first(bench, row);
    const size_t pixel = value / 3, width = (size_t)bench->rows[row].settings.width;
    struct pen_buf names = {0};
    name_row(bench, first, &names);
    pen_buf_puts(&names, " and ");
    name_row(bench, row, &names);
    pen_fail(st, PEN_DIFFERENT,
             "the pictures of %s must be the same, but differ: view %s, pixel %zu,%zu, %s is %.9g "
             "in the one and %.9g in the other",
             names.data ? (const char *)names.data : "two rows",
             bench->frame.desc->views[bench->views[view]].name, pixel % width, pixel / width,
             channels[value % 3], (double)(*reference_of(pictures, first, view))[value],
             (double)pictures->target[view][value]);
    pen_buf_release(&names);
    return false;
}

/* Compares a view's target with its reference, bit for bit. */
static bool check_picture(const struct pen_bench_pictures *pictures, int row, int view,
                          struct pen_status *st)
{
    const float *reference =
        *reference_of(pictures, pen_bench_pictures_first(pictures->bench, row), view);
    const float *rendered = pictures->target[view];
    size_t values = value_count(&pictures->bench->rows[row].settings), i = 0;
    if (memcmp(reference, rendered, values * sizeof *reference) == 0)
        return true;
    while (memcmp(&reference[i], &rendered[i], sizeof *reference) == 0)
        i++;
    return fail_different(pictures, row, view, i, st);
}

bool pen_bench_pictures_check(struct pen_bench_pictures *pictures, int row, struct pen_status *st)
{
    const struct pen_bench *bench = pictures->bench;
    size_t bytes = value_count(&bench->rows[row].settings) * sizeof(float);
    for (int view = 0; view < bench->view_count; view++) {
        float **reference = reference_of(pictures, pen_bench_pictures_first(bench, row), view);
        if (*reference) {
            if (!check_picture(pictures, row, view, st))
                return false;
            continue;
        }
        *reference = malloc(bytes);
        if (!*reference)
            return pen_fail(st, PEN_NO_MEMORY, "no memory to keep a picture of row %d", row);
        memcpy(*reference, pictures->target[view], bytes);
    }
    return true;
}

/* Measures one view against the row that it is compared with. Updates out->max_difference and
 * out->identical, and adds the mean square error to *square. */
static bool measure_view(const struct pen_bench_pictures *pictures, int row, int view,
                         struct pen_bench_row_result *out, double *square, struct pen_status *st)
{
    const struct pen_settings *s = &pictures->bench->rows[row].settings;
    struct pen_film a = {.width = s->width,
                         .height = s->height,
                         .rgb = *reference_of(pictures, out->compared_with, view)};
    struct pen_film b = {
        .width = s->width, .height = s->height, .rgb = *reference_of(pictures, out->same_as, view)};
    struct pen_difference difference;
    struct pen_picture *left = pen_picture_of_film(&a, pen_settings_transfer(s), st);
    struct pen_picture *right = left ? pen_picture_of_film(&b, pen_settings_transfer(s), st) : NULL;
    bool ok = right && pen_picture_compare(left, right, 0, &difference, st);
    pen_picture_free(left);
    pen_picture_free(right);
    if (!ok)
        return false;
    *square += difference.rmse * difference.rmse;
    if (difference.max_error > out->max_difference)
        out->max_difference = difference.max_error;
    out->identical &= memcmp(a.rgb, b.rgb, value_count(s) * sizeof(float)) == 0;
    return true;
}

uint64_t pen_bench_pictures_hash(const struct pen_bench_pictures *pictures, int row)
{
    const struct pen_settings *s = &pictures->bench->rows[row].settings;
    const int same_as = pen_bench_pictures_first(pictures->bench, row);
    uint64_t all = UINT64_C(0xcbf29ce484222325); /* of several views: FNV-1a over their hashes */
    for (int view = 0; view < pictures->bench->view_count; view++) {
        const struct pen_film film = {
            .width = s->width, .height = s->height, .rgb = *reference_of(pictures, same_as, view)};
        const uint64_t hash = pen_film_hash(&film);
        if (pictures->bench->view_count == 1)
            return hash;
        for (int shift = 0; shift < 64; shift += 8)
            all = (all ^ (hash >> shift & 0xff)) * UINT64_C(0x100000001b3);
    }
    return all;
}

bool pen_bench_pictures_measure(const struct pen_bench_pictures *pictures, int row,
                                struct pen_bench_row_result *out, struct pen_status *st)
{
    const struct pen_bench *bench = pictures->bench;
    double square = 0;
    out->picture_hash = pen_bench_pictures_hash(pictures, row);
    out->same_as = pen_bench_pictures_first(bench, row);
    out->compared_with = first_of_size(bench, row);
    out->identical = true;
    if (out->same_as == out->compared_with)
        return true;
    for (int view = 0; view < bench->view_count; view++) {
        if (!measure_view(pictures, row, view, out, &square, st))
            return false;
    }
    out->rmse = sqrt(square / bench->view_count);
    return true;
}
