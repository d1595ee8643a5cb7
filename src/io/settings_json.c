/* SPDX-License-Identifier: MIT */
/* The members are in the order of the table in api/scene-format.md. */
#include "io/settings_json.h"

#include "io/json_build.h"

static const char *pattern_name(enum pen_light_pattern pattern)
{
    switch (pattern) {
    case PEN_PATTERN_SOBOL:
        break;
    case PEN_PATTERN_GRID:
        return "grid";
    case PEN_PATTERN_RANDOM:
        return "random";
    }
    return "sobol";
}

json_t *pen_settings_json(const struct pen_settings *s)
{
    json_t *json = json_pack(
        "{s:i, s:i, s:i, s:i, s:s, s:i, s:i, s:i, s:f, s:i, s:s, s:s, s:s, s:I, s:i, s:i}", "width",
        s->width, "height", s->height, "samples_per_pixel", s->samples_per_pixel, "light_samples",
        s->light_samples, "light_pattern", pattern_name((enum pen_light_pattern)s->light_pattern),
        "blur_samples", s->blur_samples, "lens_samples", s->lens_samples, "max_depth", s->max_depth,
        "min_contribution", s->min_contribution, "max_samples", s->max_samples, "precision",
        s->precision == PEN_PRECISION_FAST ? "fast" : "robust", "accelerator",
        pen_accelerator_name((enum pen_accelerator)s->accelerator), "transfer",
        s->transfer == PEN_SETTING_LINEAR ? "linear" : "srgb", "seed", (json_int_t)s->seed, "tile",
        s->tile, "threads", s->threads);
    return s->target_error > 0 ? pen_json_with(json, "target_error", json_real(s->target_error))
                               : json;
}
