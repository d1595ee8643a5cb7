/* SPDX-License-Identifier: MIT */
/* Lights. */
#include "io/scene/reader.h"
#include "io/scene/tables.h"

static const struct pen_range angular_range = {0, 90, false, true};

static const struct pen_word kinds[] = {{"directional", PEN_LIGHT_DIRECTIONAL, NULL},
                                        {"point", PEN_LIGHT_POINT, NULL},
                                        {"spot", PEN_LIGHT_SPOT, NULL},
                                        {0}};

const struct pen_field pen_directional_fields[] = {
    {"type", PEN_FIELD_OTHER, .required = true},
    {"intensity", PEN_FIELD_COLOUR, .required = true,
     .offset = offsetof(struct pen_light_desc, intensity)},
    {"shadows", PEN_FIELD_BOOL, .offset = offsetof(struct pen_light_desc, shadows)},
    {"direction", PEN_FIELD_DIRECTION, .required = true,
     .offset = offsetof(struct pen_light_desc, direction)},
    {"angular_radius", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_light_desc, angular_radius),
     .range = &angular_range},
    {0}};

const struct pen_field pen_point_fields[] = {
    {"type", PEN_FIELD_OTHER, .required = true},
    {"intensity", PEN_FIELD_COLOUR, .required = true,
     .offset = offsetof(struct pen_light_desc, intensity)},
    {"shadows", PEN_FIELD_BOOL, .offset = offsetof(struct pen_light_desc, shadows)},
    {"position", PEN_FIELD_POINT, .required = true,
     .offset = offsetof(struct pen_light_desc, position)},
    {"attenuation", PEN_FIELD_COEFFICIENTS, .offset = offsetof(struct pen_light_desc, attenuation)},
    {"radius", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_light_desc, radius),
     .range = &pen_range_not_negative},
    {0}};

const struct pen_field pen_spot_fields[] = {
    {"type", PEN_FIELD_OTHER, .required = true},
    {"intensity", PEN_FIELD_COLOUR, .required = true,
     .offset = offsetof(struct pen_light_desc, intensity)},
    {"shadows", PEN_FIELD_BOOL, .offset = offsetof(struct pen_light_desc, shadows)},
    {"position", PEN_FIELD_POINT, .required = true,
     .offset = offsetof(struct pen_light_desc, position)},
    {"attenuation", PEN_FIELD_COEFFICIENTS, .offset = offsetof(struct pen_light_desc, attenuation)},
    {"radius", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_light_desc, radius),
     .range = &pen_range_not_negative},
    {"direction", PEN_FIELD_DIRECTION, .required = true,
     .offset = offsetof(struct pen_light_desc, direction)},
    {"beam_exponent", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_light_desc, beam_exponent),
     .range = &pen_range_not_negative},
    {0}};

static bool read_light(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_light_desc *light)
{
    static const struct pen_field *const tables[] = {[PEN_LIGHT_DIRECTIONAL] =
                                                         pen_directional_fields,
                                                     [PEN_LIGHT_POINT] = pen_point_fields,
                                                     [PEN_LIGHT_SPOT] = pen_spot_fields};
    *light = (struct pen_light_desc){.shadows = true, .attenuation = {1, 0, 0}, .beam_exponent = 1};
    int kind;
    if (!pen_read_type(r, at, json, kinds, &kind))
        return false;
    light->kind = (enum pen_light_kind)kind;
    return pen_fields_read_whole(r, at, json, tables[kind], light);
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
