/* SPDX-License-Identifier: MIT */
/* Lights. */
#include "io/scene/reader.h"
#include "io/scene/tables.h"

static const struct pen_range angular_range = {0, 90, false, true};

static const struct pen_word kinds[] = {{"directional", PEN_LIGHT_DIRECTIONAL, NULL},
                                        {"point", PEN_LIGHT_POINT, NULL},
                                        {"spot", PEN_LIGHT_SPOT, NULL},
                                        {0}};

#define MEMBER(name) offsetof(struct pen_light_desc, name)

/* The keys of every light. */
#define LIGHT_FIELDS                                                                               \
    {"type", PEN_FIELD_OTHER, .required = true},                                                   \
        {"intensity", PEN_FIELD_COLOUR, .required = true, .offset = MEMBER(intensity)},            \
    {                                                                                              \
        "shadows", PEN_FIELD_BOOL, .offset = MEMBER(shadows)                                       \
    }

/* The keys of every light that has a position. */
#define POSITIONAL_LIGHT_FIELDS                                                                    \
    {"position", PEN_FIELD_POINT, .required = true, .offset = MEMBER(position)},                   \
        {"attenuation", PEN_FIELD_COEFFICIENTS, .offset = MEMBER(attenuation)},                    \
    {                                                                                              \
        "radius", PEN_FIELD_NUMBER, .offset = MEMBER(radius), .range = &pen_range_not_negative     \
    }

const struct pen_field pen_directional_fields[] = {
    LIGHT_FIELDS,
    {"direction", PEN_FIELD_DIRECTION, .required = true, .offset = MEMBER(direction)},
    {"angular_radius", PEN_FIELD_NUMBER, .offset = MEMBER(angular_radius), .range = &angular_range},
    {0}};

const struct pen_field pen_point_fields[] = {LIGHT_FIELDS, POSITIONAL_LIGHT_FIELDS, {0}};

const struct pen_field pen_spot_fields[] = {
    LIGHT_FIELDS,
    POSITIONAL_LIGHT_FIELDS,
    {"direction", PEN_FIELD_DIRECTION, .required = true, .offset = MEMBER(direction)},
    {"beam_exponent", PEN_FIELD_NUMBER, .offset = MEMBER(beam_exponent),
     .range = &pen_range_not_negative},
    {0}};

static const struct pen_field *fields_of(enum pen_light_kind kind)
{
    switch (kind) {
    case PEN_LIGHT_DIRECTIONAL:
        return pen_directional_fields;
    case PEN_LIGHT_POINT:
        return pen_point_fields;
    case PEN_LIGHT_SPOT:
        return pen_spot_fields;
    }
    return NULL;
}

static bool read_light(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_light_desc *light)
{
    *light = (struct pen_light_desc){.shadows = true, .attenuation = {1, 0, 0}, .beam_exponent = 1};
    int kind;
    if (!pen_read_type(r, at, json, kinds, &kind))
        return false;
    light->kind = (enum pen_light_kind)kind;
    return pen_fields_read_whole(r, at, json, fields_of(light->kind), light);
}

bool pen_lights_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_scene_desc *desc)
{
    if (!pen_read_array(r, at, json, "lights"))
        return false;
    size_t count = json_array_size(json);
    desc->lights = pen_reader_alloc(r, count, sizeof *desc->lights);
    if (!desc->lights)
        return false;
    bool ok = true;
    for (size_t i = 0; i < count; i++) {
        struct pen_place place = pen_place_index(at, i);
        ok &= read_light(r, &place, json_array_get(json, i), &desc->lights[i]);
    }
    desc->light_count = (uint32_t)count;
    return ok;
}
