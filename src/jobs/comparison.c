/* SPDX-License-Identifier: MIT */
#include "jobs/comparison.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "film/encode.h"
#include "film/error_map.h"
#include "film/ssim.h"

static json_t *real_or_null(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

json_t *pen_comparison_json(const struct pen_comparison *comparison)
{
    const struct pen_difference *d = &comparison->difference;
    const struct pen_flip *flip = &comparison->flip;
    return json_pack(
        "{s:f, s:o, s:o, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:f, s:[i, i], s:I, s:b, s:I, s:I, "
        "s:I, s:f, s:b}",
        "rmse", d->rmse, "relative_mse", real_or_null(d->relative_mse), "psnr",
        real_or_null(d->psnr), "ssim", comparison->ssim, "flip", flip->mean, "flip_min", flip->min,
        "flip_first_quartile", flip->first_quartile, "flip_weighted_median", flip->weighted_median,
        "flip_third_quartile", flip->third_quartile, "flip_max", flip->max, "max_error",
        d->max_error, "max_at", d->max_x, d->max_y, "pixels",
        (json_int_t)comparison->width * comparison->height, "identical", d->differing == 0,
        "differing", (json_int_t)d->differing, "alpha_differing", (json_int_t)d->alpha,
        "over_tolerance", (json_int_t)d->over, "rmse_within", d->rmse_within, "tags_differ",
        comparison->tags_differ);
}

bool pen_comparison_map(const float *errors, int width, int height, const char *format,
                        struct pen_buf *out, struct pen_status *st)
{
    const bool numbers = strcmp(format, "pfm") == 0;
    const struct pen_png_options png = {.bits = strcmp(format, "png16") == 0 ? 16 : 8,
                                        .transfer = PEN_TRANSFER_SRGB,
                                        .description = "FLIP: black is 0, pale yellow is 1"};
    struct pen_film *film = pen_error_map(
        errors, width, height, numbers ? PEN_ERROR_MAP_VALUES : PEN_ERROR_MAP_COLOURS, st);
    const bool ok =
        film && (numbers ? pen_pfm_write(film, out, st) : pen_png_write(film, &png, out, st));
    pen_film_free(film);
    return ok;
}

static bool write_map(const struct pen_picture *a, const struct pen_picture *b, struct pen_buf *out,
                      struct pen_status *st)
{
    const int width = pen_picture_width(a), height = pen_picture_height(a);
    struct pen_flip flip;
    float *errors = malloc((size_t)width * (size_t)height * sizeof *errors);
    const bool ok = errors ? pen_picture_flip(a, b, errors, &flip, st) &&
                                 pen_comparison_map(errors, width, height, "png", out, st)
                           : pen_fail(st, PEN_NO_MEMORY,
                                      "no memory for the errors of %d x %d pixels", width, height);
    free(errors);
    return ok;
}

static bool write_figures(const struct pen_picture *a, const struct pen_picture *b,
                          bool tags_differ, struct pen_buf *out, struct pen_status *st)
{
    struct pen_comparison figures = {
        .width = pen_picture_width(a), .height = pen_picture_height(a), .tags_differ = tags_differ};
    if (!pen_picture_compare(a, b, 0, &figures.difference, st) ||
        !pen_picture_ssim(a, b, &figures.ssim, st) ||
        !pen_picture_flip(a, b, NULL, &figures.flip, st))
        return false;
    json_t *json = pen_comparison_json(&figures);
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    json_decref(json);
    const bool ok = text && pen_buf_puts(out, text) && pen_buf_puts(out, "\n");
    free(text);
    return ok || pen_fail(st, PEN_NO_MEMORY, "no memory for a comparison");
}

bool pen_comparison_write(struct pen_picture *a, struct pen_picture *b, bool map,
                          struct pen_buf *out, struct pen_status *st)
{
    const bool tags_differ = pen_picture_match(a, b);
    return map ? write_map(a, b, out, st) : write_figures(a, b, tags_differ, out, st);
}
