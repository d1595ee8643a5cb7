/* SPDX-License-Identifier: MIT */
/* Which effects a scene calls for and why, which it does not, and what a render is expected to
 * take. */
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
    const struct pen_render_stats *actual; /* of a render of the view; NULL: none */
};

/* The explanation (api/openapi.yaml, schema Explanation): {effects: [{name, because, rays_share}],
 * absent:
 * [{name, because}], kernel, rays: {primary, …: {expected, low, high}}, time_ms, memory_bytes}, and
 * with `actual` an `actual` in rays and time. Intervals are of 95 %. Fails: NULL when out of
 * memory. */
json_t *pen_explain_json(const struct pen_explain_task *task);

/* Appends an explanation as text; out->failed tells that memory ran out. */
void pen_explain_write_text(const json_t *explanation, struct pen_buf *out);

#endif
