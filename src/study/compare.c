/* SPDX-License-Identifier: MIT */
/* Which rows show the same picture follows from the settings that the rows name: whatever is not
 * known to leave the picture alone is taken to change it. */
#include "study/internal/compare.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "film/metrics.h"

struct pen_gallery {
    const struct pen_bench *bench;
    size_t capacity; /* values of the largest picture */
    float **canvas;  /* by view */
    float **kept;    /* by row and view; NULL where an earlier row has the picture */
};

static bool is_one_of(const char *key, const char *const *names)
{
    for (; *names; names++) {
        if (strcmp(key, *names) == 0)
            return true;
    }
    return false;
}

/* Whether two rows name the same value for every setting but those of names[]. */
static bool same_but(const struct pen_bench_row *a, const struct pen_bench_row *b,
                     const char *const *names)
{
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)(uintptr_t)a->chosen, key, value)
    {
        if (!is_one_of(key, names) && !json_equal(value, json_object_get(b->chosen, key)))
            return false;
    }
    return true;
}

bool pen_rows_same_work(const struct pen_bench_row *a, const struct pen_bench_row *b)
{
    static const char *const names[] = {"threads", "tile", NULL};
    return same_but(a, b, names);
}

bool pen_rows_same_picture(const struct pen_bench_row *a, const struct pen_bench_row *b)
{
    static const char *const names[] = {"accelerator", "threads", "tile", NULL};
    /* In single precision a tree's boxes decide which crossings are found. */
    if (a->settings.precision == PEN_PRECISION_FAST)
        return pen_rows_same_work(a, b);
    return same_but(a, b, names);
}

/* The first row that shows the same picture. */
static int first_alike(const struct pen_bench *bench, int row)
{
    int first = 0;
    while (!pen_rows_same_picture(&bench->rows[first], &bench->rows[row]))
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

static size_t values_of(const struct pen_settings *s)
{
    return 3 * (size_t)s->width * (size_t)s->height;
}

double pen_bench_kept_pixels(const struct pen_bench *bench)
{
    double pixels = 0;
    for (int row = 0; row < bench->row_count; row++) {
        if (first_alike(bench, row) == row)
            pixels += (double)values_of(&bench->rows[row].settings) / 3 * bench->view_count;
    }
    return pixels;
}

struct pen_gallery *pen_gallery_new(const struct pen_bench *bench)
{
    struct pen_gallery *gallery = calloc(1, sizeof *gallery);
    size_t views = (size_t)bench->view_count;
    if (!gallery)
        return NULL;
    gallery->bench = bench;
    gallery->canvas = calloc(views, sizeof *gallery->canvas);
    gallery->kept = calloc((size_t)bench->row_count * views, sizeof *gallery->kept);
    for (int row = 0; row < bench->row_count; row++) {
        size_t values = values_of(&bench->rows[row].settings);
        gallery->capacity = values > gallery->capacity ? values : gallery->capacity;
    }
    bool ok = gallery->canvas && gallery->kept;
    for (size_t i = 0; ok && i < views; i++) {
        gallery->canvas[i] = malloc(gallery->capacity * sizeof(float));
        ok = gallery->canvas[i] != NULL;
    }
    if (ok)
        return gallery;
    pen_gallery_free(gallery);
    return NULL;
}

static void free_all(float **pictures, size_t count)
{
    for (size_t i = 0; pictures && i < count; i++)
        free(pictures[i]);
    free(pictures);
}

void pen_gallery_free(struct pen_gallery *gallery)
{
    if (!gallery)
        return;
    size_t views = (size_t)gallery->bench->view_count;
    free_all(gallery->canvas, views);
    free_all(gallery->kept, (size_t)gallery->bench->row_count * views);
    free(gallery);
}

float *pen_gallery_canvas(struct pen_gallery *gallery, int view)
{
    return gallery->canvas[view];
}

static float **place_of(const struct pen_gallery *gallery, int row, int view)
{
    return &gallery->kept[row * gallery->bench->view_count + view];
}

/* "row 2 (accelerator none, threads 1)" */
static void name_row(const struct pen_bench *bench, int row, char *out, size_t bytes)
{
    const char *key;
    json_t *value;
    size_t used = (size_t)snprintf(out, bytes, "row %d", row);
    json_object_foreach((json_t *)(uintptr_t)bench->rows[row].chosen, key, value)
    {
        char *text = json_dumps(value, JSON_ENCODE_ANY | JSON_REAL_PRECISION(15));
        bool first = strchr(out, '(') == NULL;
        if (used < bytes)
            used += (size_t)snprintf(out + used, bytes - used, "%s%s %s", first ? " (" : ", ", key,
                                     text ? text : "?");
        free(text);
    }
    if (strchr(out, '(') && used + 1 < bytes)
        strcpy(out + used, ")");
}

/* Says where two pictures part first. */
static bool fail_different(const struct pen_gallery *gallery, int row, int view, size_t value,
                           struct pen_status *st)
{
    static const char *const channels[] = {"red", "green", "blue"};
    const struct pen_bench *bench = gallery->bench;
    int first = first_alike(bench, row);
    size_t pixel = value / 3, width = (size_t)bench->rows[row].settings.width;
    char a[160], b[160];
    name_row(bench, first, a, sizeof a);
    name_row(bench, row, b, sizeof b);
    return pen_fail(
        st, PEN_DIFFERENT,
        "the pictures of %s and %s must be the same, but differ: view %s, pixel %zu,%zu,"
        " %s is %.9g in the one and %.9g in the other",
        a, b, bench->desc->views[bench->views[view]].name, pixel % width, pixel / width,
        channels[value % 3], (double)(*place_of(gallery, first, view))[value],
        (double)gallery->canvas[view][value]);
}

/* Holds one picture against the kept one, bit by bit. */
static bool check_picture(const struct pen_gallery *gallery, int row, int view,
                          struct pen_status *st)
{
    const float *kept = *place_of(gallery, first_alike(gallery->bench, row), view);
    const float *drawn = gallery->canvas[view];
    size_t values = values_of(&gallery->bench->rows[row].settings), i = 0;
    if (memcmp(kept, drawn, values * sizeof *kept) == 0)
        return true;
    while (memcmp(&kept[i], &drawn[i], sizeof *kept) == 0)
        i++;
    return fail_different(gallery, row, view, i, st);
}

bool pen_gallery_hang(struct pen_gallery *gallery, int row, struct pen_status *st)
{
    const struct pen_bench *bench = gallery->bench;
    size_t bytes = values_of(&bench->rows[row].settings) * sizeof(float);
    for (int view = 0; view < bench->view_count; view++) {
        float **place = place_of(gallery, first_alike(bench, row), view);
        if (*place) {
            if (!check_picture(gallery, row, view, st))
                return false;
            continue;
        }
        *place = malloc(bytes);
        if (!*place)
            return pen_fail(st, PEN_NO_MEMORY, "no memory to keep a picture of row %d", row);
        memcpy(*place, gallery->canvas[view], bytes);
    }
    return true;
}

/* The difference of two kept pictures; of several views the mean square and the largest. */
static bool measure(const struct pen_gallery *gallery, int row, int view,
                    struct pen_bench_outcome *out, double *square, struct pen_status *st)
{
    const struct pen_settings *s = &gallery->bench->rows[row].settings;
    struct pen_film a = {s->width, s->height, *place_of(gallery, out->compared_with, view)};
    struct pen_film b = {s->width, s->height, *place_of(gallery, out->same_as, view)};
    struct pen_difference difference;
    struct pen_picture *left = pen_picture_of_film(&a, st);
    struct pen_picture *right = left ? pen_picture_of_film(&b, st) : NULL;
    bool ok = right && pen_picture_compare(left, right, 0, &difference, st);
    pen_picture_free(left);
    pen_picture_free(right);
    if (!ok)
        return false;
    *square += difference.rmse * difference.rmse;
    if (difference.max_error > out->max_difference)
        out->max_difference = difference.max_error;
    out->identical &= memcmp(a.rgb, b.rgb, values_of(s) * sizeof(float)) == 0;
    return true;
}

bool pen_gallery_compare(const struct pen_gallery *gallery, int row, struct pen_bench_outcome *out,
                         struct pen_status *st)
{
    const struct pen_bench *bench = gallery->bench;
    double square = 0;
    out->same_as = first_alike(bench, row);
    out->compared_with = first_of_size(bench, row);
    out->identical = true;
    if (out->same_as == out->compared_with)
        return true;
    for (int view = 0; view < bench->view_count; view++) {
        if (!measure(gallery, row, view, out, &square, st))
            return false;
    }
    out->rmse = sqrt(square / bench->view_count);
    return true;
}
