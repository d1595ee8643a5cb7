/* SPDX-License-Identifier: MIT */
/* What the scene reader's files share: places in the document, errors with places, and objects
 * read by tables of fields.
 *
 * A place is a chain of stack frames towards the document's root, so a valid document never pays
 * for the text of a pointer. Every reading function returns whether what it read is valid, has
 * reported an error if not, and goes on after one: a document is checked as a whole. */
#ifndef PEN_IO_SCENE_READER_H
#define PEN_IO_SCENE_READER_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/arena.h"
#include "base/status.h"
#include "io/error/place.h"
#include "io/error/text.h"
#include "io/scene_json.h"
#include "math/vec3.h"

/* No coordinate, length or colour of a scene is larger in magnitude: sums, differences and the
 * products of transforms stay finite whatever a document holds. */
#define PEN_NUMBER_MAX 1e100

/* The names of `materials`, sorted, for looking them up. */
struct pen_name_index {
    const char *name;
    uint32_t index;
};

/* Where the values of a document stand in the text that it was made from: for documents that were
 * not written as JSON. The reader then places errors by line and column instead of by JSON Pointer,
 * and names what the author wrote. */
struct pen_source_map {
    void *user;
    /* Whether the value at a place, or one around it, was reported when the document was made. */
    bool (*is_reported)(void *user, const struct pen_place *at);
    /* Fills *st with the message, the names of what stands there, and line and column. */
    void (*fail)(void *user, const struct pen_place *at, enum pen_code code, const char *message,
                 struct pen_status *st);
    /* The text that stands at a place. */
    struct pen_text (*found)(void *user, const struct pen_place *at, const json_t *value);
    /* The quoted name that the member `key` of the object at `up` has in the text. */
    struct pen_text (*name)(void *user, const struct pen_place *up, const char *key);
    /* "line 3, column 7" */
    void (*position)(void *user, const struct pen_place *at, char *out, size_t bytes);
};

struct pen_reader {
    struct pen_errors *errors;
    const char *prefix;                  /* of every pointer */
    const struct pen_source_map *source; /* of a document in XML; NULL: it is JSON as sent */
    struct pen_arena *arena;
    const struct pen_limits *limits;
    bool no_memory; /* reported already: what follows is read no more */
    /* For objects: named materials first, then inline ones, grown as they come. */
    uint32_t named_count, material_count, material_capacity;
    struct pen_material *materials;
    const struct pen_name_index *names; /* named_count, sorted by name */
    uint64_t object_count, primitive_count;
};

/* Adds an error, in a document made from XML with line and column and the names that stand there.
 * Returns false. Once the list is full it only counts. */
bool pen_reader_fail(struct pen_reader *r, const struct pen_place *at, enum pen_code code,
                     const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Memory of the scene's arena; NULL after reporting PEN_NO_MEMORY once. */
void *pen_reader_alloc(struct pen_reader *r, size_t count, size_t size);

/* Whether the list still keeps errors: where it does not, a costly message is not worth making. */
static inline bool pen_reader_explains(const struct pen_reader *r)
{
    return r->errors->count < PEN_ERRORS_MAX;
}

/* Whether messages speak of XML's attributes and elements instead of JSON's keys. */
static inline bool pen_reader_is_xml(const struct pen_reader *r)
{
    return r->source != NULL;
}

/* For messages, in the terms of the document as sent: the value at a place, the name of the member
 * `key` of the object at `up`, and where a place is. */
struct pen_text pen_reader_found(const struct pen_reader *r, const struct pen_place *at,
                                 const json_t *value);
struct pen_text pen_reader_name(const struct pen_reader *r, const struct pen_place *up,
                                const char *key);
void pen_reader_place(const struct pen_reader *r, const struct pen_place *at, char *out,
                      size_t bytes);

/* Reports that `key`, or `other` in its place if that is not NULL, is missing. Returns false. */
bool pen_reader_missing(struct pen_reader *r, const struct pen_place *up, const char *key,
                        const char *other);

/* What a number may be. A bound of +-PEN_NUMBER_MAX is one in practice only. */
struct pen_range {
    double lo, hi;
    bool lo_open, hi_open; /* the bound itself is refused */
};

extern const struct pen_range pen_range_any;          /* coordinates */
extern const struct pen_range pen_range_positive;     /* > 0 */
extern const struct pen_range pen_range_not_negative; /* >= 0 */
extern const struct pen_range pen_range_unit;         /* 0 to 1 */
extern const struct pen_range pen_range_turn;         /* degrees, as many turns as sense makes */
extern const struct pen_range pen_range_count;        /* 1 to what an int holds */

enum pen_field_type {
    PEN_FIELD_OTHER, /* known here, read by code */
    PEN_FIELD_NUMBER,
    PEN_FIELD_INTEGER,     /* int */
    PEN_FIELD_SEED,        /* uint64_t */
    PEN_FIELD_BOOL,        /* bool */
    PEN_FIELD_WORD,        /* int, one of `words` */
    PEN_FIELD_STRING,      /* const char *, copied into the arena */
    PEN_FIELD_COLOUR,      /* struct pen_vec3, each >= 0 */
    PEN_FIELD_FACTOR,      /* struct pen_vec3 from a number or a triple, each in 0 to 1 */
    PEN_FIELD_POINT,       /* struct pen_vec3 */
    PEN_FIELD_DIRECTION,   /* struct pen_vec3, not zero */
    PEN_FIELD_COEFFICIENTS /* double[3], each >= 0, not all 0 */
};

/* One of the strings that a key may have. */
struct pen_word {
    const char *name; /* NULL ends a list */
    int value;
    const char *later; /* as in struct pen_field */
};

/* One key of an object. A table of them ends with a null key. */
struct pen_field {
    const char *key;
    enum pen_field_type type;
    bool required;
    size_t offset; /* of the value in the target */
    const struct pen_range *range;
    const struct pen_word *words;
    /* The feature, still to come, that any other value than `off` calls for; NULL: it is there. */
    const char *later;
    double off;
};

/* Reads the fields that are there into *target, leaving the others alone, and refuses unknown
 * keys. Fields of type PEN_FIELD_OTHER are only known. */
bool pen_fields_read(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                     const struct pen_field *fields, void *target);

/* The row of a key; NULL if the table has none. */
const struct pen_field *pen_field_find(const struct pen_field *fields, const char *key);

/* Reads one member of the object at `at` into *target, or refuses its key. */
bool pen_fields_read_member(struct pen_reader *r, const struct pen_place *at, const char *key,
                            const json_t *value, const struct pen_field *fields, void *target);

/* As pen_fields_read, for an object that must be whole: also reports the required fields that are
 * missing. */
bool pen_fields_read_whole(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                           const struct pen_field *fields, void *target);

/* The `type` of an object that has one: reports what is no object, and a missing or unknown type.
 */
bool pen_read_type(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                   const struct pen_word *types, int *type);

/* Single values. */
bool pen_read_number(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     const struct pen_range *range, double *out);
bool pen_read_integer(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                      const struct pen_range *range, int *out);
bool pen_read_seed(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   uint64_t *out);
bool pen_read_string(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     const char **out);
bool pen_read_factor(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     struct pen_vec3 *out);
bool pen_read_coefficients(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                           double out[3]);
bool pen_read_three(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                    const struct pen_range *range, double out[3]);
bool pen_read_triple(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                     const struct pen_range *range, struct pen_vec3 *out);
bool pen_read_direction(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                        struct pen_vec3 *out);
bool pen_read_array(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                    const char *what);
bool pen_read_word(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   const struct pen_word *words, int *out);

/* "… are known, not supported yet". Returns false. */
bool pen_reader_later(struct pen_reader *r, const struct pen_place *at, const char *feature);

/* pen_scene_read, of a document whose text is described by `source`; NULL: it is JSON as sent. */
bool pen_scene_read_from(const json_t *document, const struct pen_source_map *source,
                         const char *at, const struct pen_limits *limits, struct pen_arena *arena,
                         struct pen_scene_desc *desc, struct pen_errors *errors);

/* Parts of a scene. */
bool pen_camera_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_camera_desc *camera);
bool pen_camera_override(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         bool check, struct pen_camera_desc *camera);
bool pen_material_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_material *material);
bool pen_materials_read(struct pen_reader *r, const struct pen_place *at, const json_t *json);
bool pen_material_of(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     int *index);
bool pen_lights_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_scene_desc *desc);
bool pen_objects_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      struct pen_scene_desc *desc);
bool pen_settings_fields_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                              struct pen_settings *settings);

#endif
