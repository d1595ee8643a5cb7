/* SPDX-License-Identifier: MIT */
/* Materials, and the references of objects to them. */
#include <stdlib.h>
#include <string.h>

#include "io/scene/reader.h"
#include "io/scene/tables.h"

static const struct pen_range blur_range = {0, 90, false, true};

const struct pen_field pen_material_fields[] = {
    {"emission", PEN_FIELD_COLOUR_OR_PATTERN, .offset = offsetof(struct pen_material, emission)},
    {"ka", PEN_FIELD_FACTOR_OR_PATTERN, .offset = offsetof(struct pen_material, ka)},
    {"kd", PEN_FIELD_FACTOR_OR_PATTERN, .offset = offsetof(struct pen_material, kd)},
    {"ks", PEN_FIELD_FACTOR_OR_PATTERN, .offset = offsetof(struct pen_material, ks)},
    {"shininess", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_material, shininess),
     .range = &pen_range_not_negative},
    {"kt", PEN_FIELD_FACTOR_OR_PATTERN, .offset = offsetof(struct pen_material, kt)},
    {"kr", PEN_FIELD_FACTOR_OR_PATTERN, .offset = offsetof(struct pen_material, kr)},
    {"ior", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_material, ior),
     .range = &pen_range_positive},
    {"reflection_blur", PEN_FIELD_NUMBER, .offset = offsetof(struct pen_material, reflection_blur),
     .range = &blur_range},
    {"transmission_blur", PEN_FIELD_NUMBER,
     .offset = offsetof(struct pen_material, transmission_blur), .range = &blur_range},
    {0}};

static bool read_material(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                          struct pen_material *material)
{
    *material = pen_material_default();
    bool ok = pen_fields_read(r, at, json, pen_material_fields, material);
    material->ior_written = json_object_get(json, "ior") != NULL;
    ok &= pen_patterns_read(r, at, json, material);
    return ok;
}

static int compare_names(const void *a, const void *b)
{
    return strcmp(((const struct pen_name_index *)a)->name,
                  ((const struct pen_name_index *)b)->name);
}

bool pen_materials_read(struct pen_reader *r, const struct pen_place *at, const json_t *json)
{
    if (!json_is_object(json)) {
        struct pen_text found = pen_text_value(json);
        return pen_reader_fail(r, at, PEN_INVALID, "must be an object of named materials, found %s",
                               found.text);
    }
    uint32_t count = (uint32_t)json_object_size(json);
    struct pen_name_index *names = pen_reader_alloc(r, count, sizeof *names);
    r->materials = names ? pen_reader_alloc(r, count, sizeof *r->materials) : NULL;
    if (!r->materials)
        return false;
    bool ok = true;
    const char *key;
    json_t *value;
    uint32_t i = 0;
    json_object_foreach((json_t *)json, key, value)
    {
        struct pen_place place = pen_place_key(at, key);
        ok &= read_material(r, &place, value, &r->materials[i]);
        names[i] = (struct pen_name_index){key, i};
        i++;
    }
    qsort(names, count, sizeof *names, compare_names);
    r->names = names;
    r->named_count = r->material_count = r->material_capacity = count;
    return ok;
}

static bool unknown_name(struct pen_reader *r, const struct pen_place *at, const char *name)
{
    if (!pen_reader_wants_message(r))
        return pen_reader_fail(r, at, PEN_INVALID, "unknown material");
    struct pen_text near = {""}, quoted = pen_text_quote(name);
    const char **names = malloc((r->named_count + 1) * sizeof *names);
    if (names) { /* when out of memory, the message has no hint */
        for (uint32_t i = 0; i < r->named_count; i++)
            names[i] = r->names[i].name;
        names[r->named_count] = NULL;
        near = pen_text_nearest(name, names);
        free(names);
    }
    return pen_reader_fail(r, at, PEN_INVALID, "unknown material %s: must be %s%s", quoted.text,
                           pen_reader_is_xml(r) ? "the name of a <material>"
                                                : "a name in \"materials\" or a material object",
                           near.text);
}

/* Makes sure that one more inline material fits. The capacity doubles, so copying costs O(n) in
 * all. */
static bool reserve_material(struct pen_reader *r)
{
    if (r->material_count < r->material_capacity)
        return true;
    uint32_t capacity = r->material_capacity < 8 ? 16 : 2 * r->material_capacity;
    struct pen_material *wider = pen_reader_alloc(r, capacity, sizeof *wider);
    if (!wider)
        return false;
    if (r->material_count > 0)
        memcpy(wider, r->materials, r->material_count * sizeof *wider);
    r->materials = wider;
    r->material_capacity = capacity;
    return true;
}

bool pen_material_add(struct pen_reader *r, const struct pen_material *material, int *index)
{
    if (!reserve_material(r))
        return false;
    *index = (int)r->material_count++;
    r->materials[*index] = *material;
    return true;
}

bool pen_material_ref_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                           int *index)
{
    if (json_is_string(json)) {
        struct pen_name_index wanted = {json_string_value(json), 0};
        const struct pen_name_index *found =
            r->named_count == 0
                ? NULL
                : bsearch(&wanted, r->names, r->named_count, sizeof wanted, compare_names);
        if (!found)
            return unknown_name(r, at, wanted.name);
        *index = (int)found->index;
        return true;
    }
    if (!json_is_object(json)) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must be the name of a material or a material object, found %s",
                               found.text);
    }
    if (!reserve_material(r))
        return false;
    *index = (int)r->material_count++;
    return read_material(r, at, json, &r->materials[*index]);
}
