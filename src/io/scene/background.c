/* SPDX-License-Identifier: MIT */
/* The background: a colour, or a sky. */
#include "io/scene/reader.h"
#include "io/scene/tables.h"

/* The target of pen_sky_fields. */
struct target {
    struct pen_vec3 horizon;
    struct pen_sky sky;
};

const struct pen_field pen_sky_fields[] = {
    {"zenith", PEN_FIELD_COLOUR, .required = true, .offset = offsetof(struct target, sky.zenith)},
    {"horizon", PEN_FIELD_COLOUR, .required = true, .offset = offsetof(struct target, horizon)},
    {"nadir", PEN_FIELD_COLOUR, .offset = offsetof(struct target, sky.nadir)},
    {"up", PEN_FIELD_DIRECTION, .offset = offsetof(struct target, sky.up)},
    {0}};

static const struct pen_field background_fields[] = {{"sky", PEN_FIELD_OTHER, .required = true},
                                                     {0}};

/* Reads a sky. Without `nadir`, everything below the horizon has the horizon's colour. */
static bool read_sky(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_scene_desc *desc)
{
    struct target target = {.sky.up = {0, 1, 0}};
    if (!pen_fields_read_whole(r, at, json, pen_sky_fields, &target))
        return false;
    if (!json_object_get(json, "nadir"))
        target.sky.nadir = target.horizon;
    desc->has_sky = true;
    desc->background = target.horizon;
    desc->sky = target.sky;
    return true;
}

bool pen_background_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         struct pen_scene_desc *desc)
{
    if (json_is_array(json))
        return pen_read_vec3(r, at, json, &pen_range_not_negative, &desc->background);
    if (!json_is_object(json)) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must be an array of 3 numbers, or an object with a sky, found %s",
                               found.text);
    }
    struct pen_place sky_at = pen_place_key(at, "sky");
    const json_t *sky = json_object_get(json, "sky");
    if (!pen_fields_read_whole(r, at, json, background_fields, desc))
        return false;
    return read_sky(r, &sky_at, sky, desc);
}
