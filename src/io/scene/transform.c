/* SPDX-License-Identifier: MIT */
/* Transforms of groups, and the check that quadrics are under similarities only. */
#include <math.h>
#include <stdio.h>

#include "io/scene/object.h"
#include "io/scene/tables.h"

struct transform_parts {
    double scale;
    struct pen_vec3 axis, translate;
    double degrees;
};

#define PART(name) offsetof(struct transform_parts, name)

const struct pen_field pen_transform_fields[] = {
    {"scale", PEN_FIELD_NUMBER, .offset = PART(scale), .range = &pen_range_positive},
    {"rotate", .type = PEN_FIELD_OTHER},
    {"translate", PEN_FIELD_POINT, .offset = PART(translate)},
    {"matrix", .type = PEN_FIELD_OTHER},
    {0}};

const struct pen_field pen_transform_rotate_fields[] = {
    {"axis", PEN_FIELD_DIRECTION, .required = true, .offset = PART(axis)},
    {"degrees", PEN_FIELD_NUMBER, .required = true, .offset = PART(degrees),
     .range = &pen_range_turn},
    {0}};

static bool read_matrix(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                        struct pen_transform *f)
{
    if (json_array_size(json) != 12) {
        struct pen_text found = pen_reader_found(r, at, json);
        return pen_reader_fail(r, at, PEN_INVALID,
                               "must be an array of 12 numbers, three rows of four, found %s",
                               found.text);
    }
    bool ok = true;
    for (size_t i = 0; i < 12; i++) {
        struct pen_place place = pen_place_index(at, i);
        ok &= pen_read_number(r, &place, json_array_get(json, i), &pen_range_any,
                              &f->m[i / 4][i % 4]);
    }
    return ok;
}

static bool read_parts(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_transform *f)
{
    struct transform_parts parts = {.scale = 1, .axis = {0, 0, 1}};
    const json_t *rotate = json_object_get(json, "rotate");
    struct pen_place rotate_at = pen_place_key(at, "rotate");
    bool ok = pen_fields_read(r, at, json, pen_transform_fields, &parts);
    if (rotate)
        ok &= pen_fields_read_whole(r, &rotate_at, rotate, pen_transform_rotate_fields, &parts);
    if (ok)
        *f = pen_transform_make(parts.scale, parts.axis, parts.degrees, parts.translate);
    return ok;
}

static bool in_range(const struct pen_transform *f)
{
    bool ok = true;
    for (int i = 0; i < 3; i++) {
        for (int j = 0; j < 4; j++)
            ok &= fabs(f->m[i][j]) <= PEN_NUMBER_MAX;
    }
    return ok;
}

static bool is_similarity(const struct pen_transform *f)
{
    double scale;
    return pen_transform_similarity(f, &scale);
}

bool pen_group_transform_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                              struct pen_transform *f)
{
    const json_t *matrix = json_object_get(json, "matrix");
    struct pen_place matrix_at = pen_place_key(at, "matrix");
    if (!matrix)
        return read_parts(r, at, json, f);
    struct transform_parts ignored;
    bool ok = pen_fields_read(r, at, json, pen_transform_fields, &ignored);
    if (pen_fields_count(json) > 1 && ok)
        ok = pen_reader_fail(r, &matrix_at, PEN_INVALID,
                             "\"matrix\" excludes \"scale\", \"rotate\" and \"translate\", found "
                             "both");
    if (!read_matrix(r, &matrix_at, matrix, f) || !ok)
        return false;
    if (!pen_transform_invertible(f))
        return pen_reader_fail(r, &matrix_at, PEN_INVALID,
                               "must be invertible, found a matrix that flattens space");
    return true;
}

bool pen_transform_chain_add(struct pen_reader *r, const struct pen_place *at,
                             const struct pen_transform *f, struct pen_transform_chain *chain)
{
    bool similar = is_similarity(f);
    chain->f = pen_transform_compose(&chain->f, f);
    chain->similar = is_similarity(&chain->f);
    if (!chain->stretch_at && (!similar || !chain->similar)) {
        chain->stretch_at = at;
        chain->stretch = similar ? chain->f : *f; /* if similar, small deviations have added up */
    }
    if (in_range(&chain->f) && pen_transform_invertible(&chain->f))
        return true;
    return pen_reader_fail(r, at, PEN_INVALID,
                           "together with the transforms of the groups around it, this one %s",
                           in_range(&chain->f) ? "flattens space, and must be invertible"
                                               : "reaches beyond 1e100 in magnitude");
}

bool pen_transform_chain_check_quadric(struct pen_reader *r, const struct pen_place *at,
                                       const char *what, const struct pen_transform_chain *chain)
{
    if (chain->similar)
        return true;
    double length[3];
    for (int j = 0; j < 3; j++)
        length[j] = pen_length(
            pen_vec3(chain->stretch.m[0][j], chain->stretch.m[1][j], chain->stretch.m[2][j]));
    bool equal = fabs(length[0] - length[1]) <= 5e-7 * length[0] &&
                 fabs(length[0] - length[2]) <= 5e-7 * length[0];
    struct pen_text a = pen_text_number(length[0]), b = pen_text_number(length[1]),
                    c = pen_text_number(length[2]);
    char place[PEN_AT_BYTES], why[128];
    pen_reader_place(r, chain->stretch_at, place, sizeof place);
    snprintf(why, sizeof why, "of lengths %.30s, %.30s, %.30s", a.text, b.text, c.text);
    return pen_reader_fail(
        r, at, PEN_INVALID,
        "a %s takes only similarities (uniform scale, rotation, translation, mirror), and the "
        "transform at %s is none: the columns of its matrix are %s",
        what, place, equal ? "not at right angles" : why);
}
