/* SPDX-License-Identifier: MIT */
/* Reads scenes (`penumbra-scene/1`, see api/scene-format.md) and the render settings of jobs from
 * memory into pen_scene_desc and pen_settings. Every error names its place. No input is repaired,
 * except as the description's notes state.
 *
 * Errors:
 *  - Syntax (malformed JSON, duplicate keys, NaN, overflowing numbers): PEN_SYNTAX, only the first
 *    error, with the line and column where the offending token begins. Both count from 1; a column
 *    is a character.
 *  - All others are collected, up to PEN_ERRORS_MAX, each with a JSON Pointer: PEN_INVALID;
 *    PEN_UNSUPPORTED for a part of the format that this version does not support; PEN_NO_MEMORY for
 *    a full arena. Messages name the allowed values and the value found. */
#ifndef PEN_IO_SCENE_JSON_H
#define PEN_IO_SCENE_JSON_H

#include <jansson.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/arena.h"
#include "base/status.h"
#include "io/message.h"
#include "scene/desc.h"

struct pen_models;

/* Limits of api/scene-format.md; pen_limits_default gives the defaults. */
struct pen_limits {
    size_t body_bytes;
    size_t parsed_bytes; /* estimated memory of the JSON values of a document */
    int nesting;         /* levels of arrays and objects */
    uint64_t objects;
    uint64_t pixels_per_view;
    uint32_t views;
    double work;         /* rays of all views together; see pen_limits_check */
    int timeout_seconds; /* of a job */
    int samples;         /* of a pixel; 0: only the limit of the format */
    int priority;        /* the largest priority that a job may request */
    int queue;           /* jobs that wait or run; 0: no limit */
    int address_queue;   /* the same for one client's address; 0: half of `queue` */
    /* The longest expected time of all rays together, at this rate per second; 0: no limit. */
    double seconds, rays_per_second;
    struct pen_models *models; /* for the model files that scenes name; NULL: none may be named */
};

struct pen_limits pen_limits_default(void);

/* Parses JSON strictly by RFC 8259; duplicate keys are refused. Integers that fit into 64 bits
 * become jansson's integers, longer ones reals.
 * Owns: the caller json_decref()s the value.
 * Fails: NULL; PEN_TOO_LARGE (bytes of the text or memory of the values), PEN_SYNTAX, PEN_INVALID
 * (nesting, with the JSON Pointer), PEN_NO_MEMORY. */
json_t *pen_json_parse(const char *text, size_t bytes, const struct pen_limits *limits,
                       struct pen_status *st);

/* Reads a scene from a parsed document. `at` is the prefix of every JSON Pointer: "" for a bare
 * scene, "/scene" inside a job.
 * Owns: everything in *desc lives in `arena`.
 * Fails: returns false with errors->count > 0; *desc must not be used then. */
bool pen_scene_read(const json_t *document, const char *at, const struct pen_limits *limits,
                    struct pen_arena *arena, struct pen_scene_desc *desc,
                    struct pen_errors *errors);

/* Replaces the settings that a `render` object has; `at` is as in pen_scene_read.
 * Fails: returns false, adds to *errors and leaves *settings unchanged. */
bool pen_settings_read(const json_t *render, const char *at, struct pen_settings *settings,
                       struct pen_errors *errors);

/* Applies one `key=value` of the command line (`--set`); the value is JSON or a bare word.
 * Fails: PEN_USAGE, PEN_UNSUPPORTED, PEN_NO_MEMORY; the message names the key, and *settings is
 * unchanged. */
bool pen_settings_set(struct pen_settings *settings, const char *assignment, struct pen_status *st);

/* Checks the limits that depend on the settings and on the number of views to render: pixels per
 * view, and work. Also checks that no settings exclude each other. Work is the rays of
 * pen_work_per_pixel. If paths fork (pen_desc_forks), it is multiplied by the most surfaces that a
 * pixel sample shades, min(2^max_depth - 1, pen_tree_surfaces_max). The place of the status is
 * `at`, a JSON Pointer.
 * Fails: PEN_TOO_LARGE, PEN_INVALID. */
bool pen_limits_check(const struct pen_limits *limits, const struct pen_scene_desc *desc,
                      const struct pen_settings *settings, uint32_t views, const char *at,
                      struct pen_status *st);

/* Checks the expected time of this number of primary and shadow rays, which follows from counts
 * alone. Rays of forking paths and of blur are left out: their known bound is far above their
 * number in most scenes.
 * Fails: PEN_TOO_LARGE. */
bool pen_limits_check_time(const struct pen_limits *limits, double rays, const char *at,
                           struct pen_status *st);

/* An upper bound of the primary rays of one pixel and of the shadow rays from their hits, from the
 * counts of samples and lights alone. */
double pen_work_per_pixel(const struct pen_scene_desc *desc, const struct pen_settings *settings);

/* Adds warnings about a valid scene: its notes (scene/desc.h), views in which nothing is visible,
 * T-junctions (scene/tjunction.h), and named materials that no object uses. Also lights of
 * intensity 0, a picture that will be empty or black, and views for which double precision is too
 * coarse (scene/precision.h). Each warning has code PEN_OK, a JSON Pointer and a sentence. *desc
 * was read from `document` and `at`. When memory runs out, some warnings are missing.
 * Cost: linear in the document, plus a limited number of steps. The last warnings list the checks
 * that this limit left out; if there are PEN_ERRORS_MAX warnings, they replace others. */
void pen_scene_warnings(const json_t *document, const char *at, const struct pen_scene_desc *desc,
                        struct pen_errors *warnings);

/* Parses and reads the text of a bare scene, for `penumbra render FILE`. Text that begins with `<`
 * is XML (see io/document.h), whose errors have a line and column. */
bool pen_scene_load(const char *text, size_t bytes, const struct pen_limits *limits,
                    struct pen_arena *arena, struct pen_scene_desc *desc,
                    struct pen_errors *errors);

#endif
