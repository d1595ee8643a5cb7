/* SPDX-License-Identifier: MIT */
/* Common to the files of the scene reader: its state, errors with places, the reading of objects by
 * tables of their keys, and of single values.
 *
 * Every reading function takes the place of the value (io/error/place.h). It returns whether the
 * value is valid, and reports an error if not. Readers continue after an error, so that all errors
 * of a document are found. */
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

/* The largest magnitude of a number in a scene. It keeps sums, differences and products of
 * transforms finite for every document. */
#define PEN_NUMBER_MAX 1e100

/* A material's name and its index. An array of these, sorted by name, is searched. */
struct pen_name_index {
    const char *name;
    uint32_t index;
};

/* Maps places in the JSON values to the text of a document that is not JSON. With it, errors have a
 * line and a column instead of a JSON Pointer, and use the author's names. */
struct pen_source_map {
    void *user;
    /* Whether an error in the value at a place, or in a value that contains it, has already been
     * reported. */
    bool (*is_reported)(void *user, const struct pen_place *at);
    /* Fills *st with the message, preceded by the element's and attribute's names, and with line
     * and column. */
    void (*fail)(void *user, const struct pen_place *at, enum pen_code code, const char *message,
                 struct pen_status *st);
    /* The text at a place, for "found …". */
    struct pen_text (*found)(void *user, const struct pen_place *at, const json_t *value);
    /* The quoted name, in the text, of the member `key` of the object at `up`. */
    struct pen_text (*name)(void *user, const struct pen_place *up, const char *key);
    /* "line 3, column 7" */
    void (*position)(void *user, const struct pen_place *at, char *out, size_t bytes);
};

struct pen_reader {
    struct pen_errors *errors;
    const char *prefix;                  /* of every JSON Pointer */
    const struct pen_source_map *source; /* of an XML document; NULL for JSON */
    struct pen_arena *arena;
    const struct pen_limits *limits;
    bool no_memory; /* was reported; later allocations fail silently */
    /* Materials: named ones first, then the inline ones of objects in the order read. */
    uint32_t named_count, material_count, material_capacity;
    struct pen_material *materials;
    const struct pen_name_index *names; /* named_count, sorted by name */
    uint64_t object_count, primitive_count;
    uint32_t left_out_count,
        repeat_count; /* objects without area; objects that repeat their last vertex */
    uint64_t left_out_vertices;
    uint32_t mesh_flat_count;       /* triangles of meshes in the document, without area */
    struct pen_errors *model_notes; /* about model files */
};

/* Adds an error at a place. Does not add an error in a value that the source map has already
 * reported. When the list is full, errors are only counted. Returns false. */
bool pen_reader_fail(struct pen_reader *r, const struct pen_place *at, enum pen_code code,
                     const char *format, ...) __attribute__((format(printf, 4, 5)));

/* Allocates in the scene's arena.
 * Fails: NULL; reports PEN_NO_MEMORY once. */
void *pen_reader_alloc(struct pen_reader *r, size_t count, size_t size);

/* Whether the list of errors still keeps messages. If it is full, a costly message need not be
 * made. */
static inline bool pen_reader_wants_message(const struct pen_reader *r)
{
    return r->errors->count < PEN_ERRORS_MAX;
}

/* Whether messages name attributes and elements (XML) instead of keys (JSON). */
static inline bool pen_reader_is_xml(const struct pen_reader *r)
{
    return r->source != NULL;
}

/* Text for messages, in the document's format (JSON or XML): the value at a place, the name of the
 * member `key` of the object at `up`, and the position of a place. */
struct pen_text pen_reader_found(const struct pen_reader *r, const struct pen_place *at,
                                 const json_t *value);
struct pen_text pen_reader_name(const struct pen_reader *r, const struct pen_place *up,
                                const char *key);
void pen_reader_place(const struct pen_reader *r, const struct pen_place *at, char *out,
                      size_t bytes);

/* Reports that `key`, or the alternative `other` unless that is NULL, is missing. Returns false. */
bool pen_reader_missing(struct pen_reader *r, const struct pen_place *up, const char *key,
                        const char *other);

/* The allowed values of a number. Messages name a bound of +-PEN_NUMBER_MAX or INT_MAX only if the
 * number found exceeds it. */
struct pen_range {
    double lo, hi;
    bool lo_open, hi_open; /* the bound itself is not allowed */
};

extern const struct pen_range pen_range_any;          /* coordinates */
extern const struct pen_range pen_range_positive;     /* > 0 */
extern const struct pen_range pen_range_not_negative; /* >= 0 */
extern const struct pen_range pen_range_unit;         /* 0 to 1 */
extern const struct pen_range pen_range_turn;         /* degrees of a rotation, +-1e6 */
extern const struct pen_range pen_range_count;        /* 1 to INT_MAX */

enum pen_field_type {
    PEN_FIELD_OTHER, /* a known key that code reads rather than the table */
    PEN_FIELD_NOTE,  /* a string for editors or people: checked, then discarded */
    PEN_FIELD_NUMBER,
    PEN_FIELD_INTEGER,           /* int */
    PEN_FIELD_SEED,              /* uint64_t */
    PEN_FIELD_BOOL,              /* bool */
    PEN_FIELD_WORD,              /* int, one of `words` */
    PEN_FIELD_STRING,            /* const char *, copied into the arena */
    PEN_FIELD_COLOUR,            /* struct pen_vec3, each >= 0 */
    PEN_FIELD_FACTOR,            /* struct pen_vec3 from a number or a triple, each in 0 to 1 */
    PEN_FIELD_COLOUR_OR_PATTERN, /* the same, or an object, which code reads */
    PEN_FIELD_FACTOR_OR_PATTERN,
    PEN_FIELD_POINT,       /* struct pen_vec3 */
    PEN_FIELD_DIRECTION,   /* struct pen_vec3, not zero */
    PEN_FIELD_COEFFICIENTS /* double[3], each >= 0, not all 0 */
};

/* An allowed string value of a key. */
struct pen_word {
    const char *name; /* NULL ends a list */
    int value;
    const char *unsupported; /* as in struct pen_field */
};

/* One key of an object. A table of them ends with a null key. */
struct pen_field {
    const char *key;
    enum pen_field_type type;
    bool required;
    size_t offset; /* of the value in the target */
    const struct pen_range *range;
    const struct pen_word *words;
    /* The unsupported feature that any value other than `off` turns on; NULL: all values are
     * supported. */
    const char *unsupported;
    double off;
};

/* The key for text for people, which any object may have. No table lists it. */
#define PEN_COMMENT_KEY "comment"

/* The number of an object's members, without its comment. */
size_t pen_fields_count(const json_t *object);

/* Reads the fields that the object has into *target, leaves the others unchanged, and refuses
 * unknown keys. Fields of type PEN_FIELD_OTHER are accepted but not read. */
bool pen_fields_read(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                     const struct pen_field *fields, void *target);

/* The row of `key`, or NULL. */
const struct pen_field *pen_field_find(const struct pen_field *fields, const char *key);

/* Reads one member of the object at `at` into *target, or refuses its key. */
bool pen_fields_read_member(struct pen_reader *r, const struct pen_place *at, const char *key,
                            const json_t *value, const struct pen_field *fields, void *target);

/* As pen_fields_read, and also reports required fields that are missing. */
bool pen_fields_read_whole(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                           const struct pen_field *fields, void *target);

/* Reads the `type` of an object. Reports a value that is not an object, and a missing or unknown
 * type. */
bool pen_read_type(struct pen_reader *r, const struct pen_place *at, const json_t *object,
                   const struct pen_word *types, int *type);

/* Readers of single values:
 *  - factor: a number or an array of 3, each 0 to 1;
 *  - coefficients: an array of 3 numbers, each >= 0, not all 0;
 *  - vec3: an array of 3 numbers in `range`;
 *  - direction: an array of 3 numbers, not all 0;
 *  - array: only checks the type; `what` names its elements in the message. */
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
bool pen_read_vec3(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   const struct pen_range *range, struct pen_vec3 *out);
bool pen_read_direction(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                        struct pen_vec3 *out);
bool pen_read_array(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                    const char *what);
bool pen_read_word(struct pen_reader *r, const struct pen_place *at, const json_t *value,
                   const struct pen_word *words, int *out);

/* Reports "known, not supported yet: FEATURE". Returns false. */
bool pen_reader_unsupported(struct pen_reader *r, const struct pen_place *at, const char *feature);

/* As pen_scene_read; `source` maps places to the text of an XML document, NULL for JSON. */
bool pen_scene_read_from(const json_t *document, const struct pen_source_map *source,
                         const char *at, const struct pen_limits *limits, struct pen_arena *arena,
                         struct pen_scene_desc *desc, struct pen_errors *errors);

/* The readers of a scene's parts. */
bool pen_background_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         struct pen_scene_desc *desc);
bool pen_camera_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_camera_desc *camera);
/* Replaces the keys that a view overrides in *camera; `check`: the result must be a valid frame. */
bool pen_camera_override(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                         bool check, struct pen_camera_desc *camera);
/* Reads the patterns of a material's colours: the colours that are objects. */
bool pen_patterns_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                       struct pen_material *material);
bool pen_materials_read(struct pen_reader *r, const struct pen_place *at, const json_t *json);
/* Reads an object's `material`: a name, or an inline material, which is added to the materials. */
bool pen_material_ref_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                           int *index);
/* Adds a material to the scene's.
 * Fails: PEN_NO_MEMORY. */
bool pen_material_add(struct pen_reader *r, const struct pen_material *material, int *index);
bool pen_lights_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                     struct pen_scene_desc *desc);
bool pen_objects_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                      struct pen_scene_desc *desc);
/* Adds notes to *desc, which has been read without errors: omissions and choices of the reader, and
 * probable errors of the author. */
void pen_notes_read(struct pen_reader *r, const json_t *document, struct pen_scene_desc *desc);
bool pen_settings_fields_read(struct pen_reader *r, const struct pen_place *at, const json_t *json,
                              struct pen_settings *settings);

#endif
