/* SPDX-License-Identifier: MIT */
/* Writes the members in the order of the table in api/scene-format.md. */
#include "io/settings_json.h"

#include "io/json_build.h"
#include "io/scene/tables.h"

/* The name of a setting's value, from the table by which pen_settings_read reads it. */
static const char *name_of(const char *key, int value)
{
    const struct pen_word *word = pen_field_find(pen_settings_fields, key)->words;
    while (word->name && word->value != value)
        word++;
    return word->name;
}

json_t *pen_settings_json(const struct pen_settings *s)
{
    json_t *json = json_pack(
        "{s:i, s:i, s:i, s:i, s:s, s:i, s:i, s:i, s:f, s:i, s:s, s:s, s:s, s:I, s:i, s:i}", "width",
        s->width, "height", s->height, "samples_per_pixel", s->samples_per_pixel, "light_samples",
        s->light_samples, "light_pattern", name_of("light_pattern", s->light_pattern),
        "blur_samples", s->blur_samples, "lens_samples", s->lens_samples, "max_depth", s->max_depth,
        "min_contribution", s->min_contribution, "max_samples", s->max_samples, "precision",
        name_of("precision", s->precision), "accelerator", name_of("accelerator", s->accelerator),
        "transfer", name_of("transfer", s->transfer), "seed", (json_int_t)s->seed, "tile", s->tile,
        "threads", s->threads);
    return s->target_error > 0 ? pen_json_with(json, "target_error", json_real(s->target_error))
                               : json;
}
