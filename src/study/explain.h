/* SPDX-License-Identifier: MIT */
/* Explains a scene: the effects that it needs and why, those that it does not need, and the
 * expected rays, time and memory of a render. */
#ifndef PEN_STUDY_EXPLAIN_H
#define PEN_STUDY_EXPLAIN_H

#include <jansson.h>

#include "base/buf.h"
#include "render/forecast.h"
#include "render/render.h"

struct pen_explain_task {
    const struct pen_scene_desc *desc;
    const struct pen_settings *settings;
    int view;
    const struct pen_forecast *forecast;
    const struct pen_render_stats *actual; /* of a finished render of the view; NULL: none */
};

/* Makes the explanation (api/openapi.yaml, schema Explanation):
 *    {view, effects: [{name, because, rays_share}], absent: [{name, because}], kernel,
 *    rays: {primary, …: {expected, low, high}}, cpu_ms, time_ms, load, memory_bytes, pre_render}
 * With task->actual, each member of `rays`, `cpu_ms` and `time_ms` also has a member `actual`.
 * Intervals are of 95 %.
 * Owns: the caller json_decref()s.
 * Fails: NULL when out of memory. */
json_t *pen_explain_json(const struct pen_explain_task *task);

/* Appends an explanation as text.
 * Fails: out->failed is set when out of memory. */
void pen_explain_write_text(const json_t *explanation, struct pen_buf *out);

#endif
