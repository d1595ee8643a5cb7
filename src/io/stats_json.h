/* SPDX-License-Identifier: MIT */
/* The statistics object of a render, as `penumbra render --stats`, the worker and libpenumbra
 * report it (api/openapi.yaml, Statistics). */
#ifndef PEN_IO_STATS_JSON_H
#define PEN_IO_STATS_JSON_H

#include <jansson.h>
#include <stdint.h>

#include "render/audit.h"
#include "render/percentiles.h"
#include "render/render.h"
#include "scene/precision.h"

/* The input of a statistics object.
 * Units: times are in milliseconds. */
struct pen_stats_input {
    double queue_ms, parse_ms, build_ms, encode_ms, store_ms, total_ms;
    const struct pen_render_stats *render;
    const struct pen_accel_stats *accel;
    const struct pen_scene_precision *precision; /* of the view; NULL: leave it out */
    const struct pen_audit *audit;               /* NULL: there was no audit */
    const struct pen_scene *scene; /* for the figures of its meshes; NULL: leave them out */
    size_t scene_bytes;            /* with the acceleration structure and the description */
    /* For a render that a deadline ended: the data to repeat it. */
    const struct pen_settings *settings;
    const char *scene_sha256; /* of the scene document, hexadecimal */
};

/* The whole object.
 * Owns: the caller json_decref()s it.
 * Fails: NULL when out of memory. */
json_t *pen_stats_json(const struct pen_stats_input *in);

/* Reads the rounds of a render, and its settings, from a statistics object. `scene_sha256` is that
 * of the scene to render again.
 * Fails: PEN_INVALID (not the statistics of a render that a deadline ended; the message names the
 * missing part), PEN_CONFLICT (of another scene, or of another rule than PEN_ADAPTIVE_RULE). */
bool pen_stats_rounds_read(const json_t *stats, const char *scene_sha256,
                           struct pen_settings *settings, struct pen_adaptive_stats *rounds,
                           struct pen_status *st);

/* The member `audit`: {pixels, threshold, wrong, undecided, bound, seed}; the seed is 16
 * hexadecimal digits.
 * Owns: the caller json_decref()s it.
 * Fails: NULL when out of memory. */
json_t *pen_stats_audit(const struct pen_audit *audit);

/* The member `tiles` alone: {count, ms: {p50, p95, max}}.
 * Owns: the caller json_decref()s it.
 * Fails: NULL when out of memory. */
json_t *pen_stats_tiles(uint64_t count, const struct pen_percentiles *ms);

#endif
