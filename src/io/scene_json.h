/* SPDX-License-Identifier: MIT */
/* Reads scenes (`penumbra-scene/1`, see api/scene-format.md) and the render settings of jobs from
 * memory into pen_scene_desc and pen_settings. Every error has a place; nothing is repaired
 * silently.
 *
 * Syntax errors (malformed JSON, duplicate keys, NaN, overflowing numbers) are reported alone,
 * as PEN_SYNTAX with line and column: both count from 1, a column is a character, and the place is
 * where the offending token begins. All other errors are collected, up to PEN_ERRORS_MAX, each with
 * a JSON Pointer: PEN_INVALID, PEN_UNSUPPORTED for what the format has and this version does not
 * support, and PEN_NO_MEMORY for a full arena. Messages name what is allowed and what was found. */
#ifndef PEN_IO_SCENE_JSON_H
#define PEN_IO_SCENE_JSON_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "base/status.h"
#include "io/message.h"
#include "scene/desc.h"

/* Limits of api/scene-format.md; pen_limits_default gives the defaults. */
struct pen_limits {
    size_t body_bytes;
    size_t parsed_bytes; /* memory that the values of a document may take, by an estimate */
    int nesting;
    uint64_t objects;
    uint64_t pixels_per_view;
    uint32_t views;
    double work; /* upper bound of primary and shadow rays */
};

struct pen_limits pen_limits_default(void);

/* Parses JSON strictly: bytes and nesting are checked before parsing, the memory that the values
 * take while parsing, duplicate keys refused.
 * Integers that fit into 64 bits are jansson's integers, longer ones are reals.
 * Owns: the caller json_decref()s. Fails: PEN_TOO_LARGE, PEN_SYNTAX, PEN_INVALID (nesting,
 * with at), PEN_NO_MEMORY. */
json_t *pen_json_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                       struct pen_status *st);

/* Reads a scene from a parsed document. `at` is prefixed to every pointer ("" for a bare scene,
 * "/scene" inside a job). Owns: everything in *desc lives in `arena`.
 * Fails: returns false with errors->count > 0; *desc is then not to be used. */
bool pen_scene_read(const json_t *document, const char *at, const struct pen_limits *limits,
                    struct pen_arena *arena, struct pen_scene_desc *desc,
                    struct pen_errors *errors);

/* Applies a `render` object on top of *settings, which an error leaves as they were. Errors as
 * pen_scene_read. */
bool pen_settings_read(const json_t *render, const char *at, struct pen_settings *settings,
                       struct pen_errors *errors);

/* Applies one `key=value` of the command line (`--set`), the value as JSON or a bare word.
 * Fails: PEN_USAGE, PEN_UNSUPPORTED, PEN_NO_MEMORY; the message names the key, *settings stay. */
bool pen_settings_set(struct pen_settings *settings, const char *assignment, struct pen_status *st);

/* Checks the limits that depend on settings and on the number of views to be rendered: pixels per
 * view, work. `at` points at the document. Fails: PEN_TOO_LARGE. */
bool pen_limits_check(const struct pen_limits *limits, const struct pen_scene_desc *desc,
                      const struct pen_settings *settings, uint32_t views, const char *at,
                      struct pen_status *st);

/* Upper bound of primary and shadow rays of one pixel, from counts alone. */
double pen_work_per_pixel(const struct pen_scene_desc *desc, const struct pen_settings *settings);

/* Adds warnings about a valid scene: T-junctions (scene/tjunction.h), named materials that no
 * object uses, lights of intensity 0, a picture that will be empty or black, views for which double
 * precision is too coarse (scene/precision.h). Each has code PEN_OK, a JSON Pointer and a sentence.
 * `document` is what *desc was read from, with the same `at`. When memory runs out, some warnings
 * are missing. */
void pen_scene_warnings(const json_t *document, const char *at, const struct pen_scene_desc *desc,
                        struct pen_errors *warnings);

/* Parses and reads a whole bare scene in one go: the path of `penumbra render FILE`. Text that
 * begins with `<` is XML, see document.h; errors are then placed by line and column. */
bool pen_scene_load(const char *text, size_t bytes, const struct pen_limits *limits,
                    struct pen_arena *arena, struct pen_scene_desc *desc,
                    struct pen_errors *errors);

#endif
