/* SPDX-License-Identifier: MIT */
/* Patterns in the place of a material's colours. */
#include <string.h>

#include "io/scene/reader.h"
#include "io/scene/tables.h"

enum { CHECKER, GRADIENT };
static const struct pen_word kinds[] = {
    {"checker", CHECKER, NULL}, {"gradient", GRADIENT, NULL}, {0}};

/* The target of the tables. */
struct target {
    int kind;
    struct pen_pattern pattern;
};

#define PATTERN_FIELDS(colour)                                                                     \
    {                                                                                              \
        {"pattern", PEN_FIELD_WORD, .required = true, .offset = offsetof(struct target, kind),     \
         .words = kinds},                                                                          \
            {"a", colour, .required = true, .offset = offsetof(struct target, pattern.a)},         \
            {"b", colour, .required = true, .offset = offsetof(struct target, pattern.b)},         \
            {"size", PEN_FIELD_NUMBER, .offset = offsetof(struct target, pattern.size),            \
             .range = &pen_range_positive},                                                        \
            {"from", PEN_FIELD_POINT, .offset = offsetof(struct target, pattern.from)},            \
            {"to", PEN_FIELD_POINT, .offset = offsetof(struct target, pattern.to)},                \
        {                                                                                          \
            0                                                                                      \
        }                                                                                          \
    }
const struct pen_field pen_colour_pattern_fields[] = PATTERN_FIELDS(PEN_FIELD_COLOUR);
const struct pen_field pen_factor_pattern_fields[] = PATTERN_FIELDS(PEN_FIELD_FACTOR);

/* The keys that only one of the kinds has and requires. */
static const struct {
    const char *key;
    int kind;
} own_keys[] = {{"size", CHECKER}, {"from", GRADIENT}, {"to", GRADIENT}};

static bool check_own_keys(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                           int kind)
{
    bool ok = true;
    for (size_t i = 0; i < sizeof own_keys / sizeof own_keys[0]; i++) {
        const char *key = own_keys[i].key;
        struct pen_place place = pen_place_key(at, key);
        bool here = json_object_get(json, key) != NULL;
        if (own_keys[i].kind == kind && !here)
            ok = pen_reader_missing(r, at, key, NULL);
        else if (own_keys[i].kind != kind && here)
            ok = pen_reader_fail(r, &place, PEN_INVALID, "belongs to a %s, found in a %s",
                                 kinds[own_keys[i].kind].name, kinds[kind].name);
    }
    return ok;
}

static bool read_pattern(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         const struct pen_field *fields, struct pen_pattern *out)
{
    struct target target = {.kind = CHECKER};
    if (!pen_fields_read_whole(r, at, json, fields, &target) ||
        !check_own_keys(r, at, json, target.kind))
        return false;
    *out = target.pattern;
    out->checker = target.kind == CHECKER;
    struct pen_vec3 way = pen_sub(out->to, out->from);
    struct pen_place to = pen_place_key(at, "to");
    if (!out->checker && way.x == 0 && way.y == 0 && way.z == 0)
        return pen_reader_fail(r, &to, PEN_INVALID, "must be another point than %s",
                               pen_reader_name(r, at, "from").text);
    return true;
}

/* The colour that replaces a pattern: 0 only if both of its colours are 0. */
static double mean(double a, double b)
{
    double half = 0.5 * a + 0.5 * b;
    return half > 0 ? half : a > b ? a : b;
}

bool pen_patterns_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_material *material)
{
    /* In the order of struct pen_material. */
    static const char *const keys[PEN_MATERIAL_COLOURS] = {"emission", "ka", "kd",
                                                           "ks",       "kt", "kr"};
    struct pen_patterns *patterns = NULL;
    bool ok = true;
    for (int i = 0; i < PEN_MATERIAL_COLOURS; i++) {
        const json_t *value = json_object_get(json, keys[i]);
        if (!json_is_object(value))
            continue;
        if (!patterns && !(patterns = pen_reader_alloc(r, 1, sizeof *patterns)))
            return false;
        struct pen_pattern *pattern = pen_reader_alloc(r, 1, sizeof *pattern);
        struct pen_place place = pen_place_key(at, keys[i]);
        if (!pattern)
            return false;
        if (!read_pattern(r, &place, value,
                          i == PEN_COLOUR_EMISSION ? pen_colour_pattern_fields
                                                   : pen_factor_pattern_fields,
                          pattern)) {
            ok = false;
            continue;
        }
        *pen_material_colour(material, i) =
            pen_vec3(mean(pattern->a.x, pattern->b.x), mean(pattern->a.y, pattern->b.y),
                     mean(pattern->a.z, pattern->b.z));
        patterns->of[i] = pattern;
    }
    material->patterns = patterns;
    return ok;
}
