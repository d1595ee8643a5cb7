/* SPDX-License-Identifier: MIT */
#include "io/figures.h"

#include <math.h>

#include "base/cpu.h"
#include "io/json_build.h"

json_t *pen_figure(double value)
{
    return json_real(round(value * 1e6) / 1e6);
}

json_t *pen_figure_error(double error)
{
    return json_real(round(error * 1e6) / 1e6);
}

static uint64_t ray_sum(const struct pen_ray_counts *rays)
{
    return rays->primary + rays->shadow + rays->reflection + rays->transmission;
}

json_t *pen_figure_rays(const struct pen_ray_counts *rays)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I}", "primary", (json_int_t)rays->primary, "shadow",
                     (json_int_t)rays->shadow, "reflection", (json_int_t)rays->reflection,
                     "transmission", (json_int_t)rays->transmission, "total",
                     (json_int_t)ray_sum(rays));
}

json_t *pen_figure_rate(const struct pen_ray_counts *rays, double render_ms)
{
    return pen_figure(render_ms > 0 ? (double)ray_sum(rays) / render_ms / 1000 : 0);
}

/* {none, tree, packets}: expected costs, without choices that do not exist. */
static json_t *expected_costs(const struct pen_accel_stats *accel)
{
    json_t *costs = json_object();
    for (int i = 0; i < PEN_AUTO_COUNT; i++) {
        if (isfinite(accel->expected[i]))
            costs = pen_json_with(costs, pen_auto_choice_name((enum pen_auto_choice)i),
                                  pen_figure(accel->expected[i]));
    }
    return costs;
}

json_t *pen_figure_accelerator(const struct pen_accel_stats *accel,
                               const struct pen_render_stats *stats)
{
    double rays = (double)ray_sum(&stats->rays);
    json_t *json =
        json_pack("{s:s, s:I, s:I, s:I, s:I, s:o, s:o}", "kind", pen_accelerator_name(accel->kind),
                  "nodes", (json_int_t)accel->nodes, "leaves", (json_int_t)accel->leaves, "depth",
                  (json_int_t)accel->depth, "bytes", (json_int_t)accel->bytes, "sah_cost",
                  pen_figure(accel->sah_cost), "build_ms", pen_figure(accel->build_ms));
    if (accel->kind == PEN_ACCEL_AUTO) {
        json = pen_json_with(json, "choice", json_string(pen_auto_choice_name(accel->choice)));
        json = pen_json_with(json, "expected_costs", expected_costs(accel));
    }
    if (!stats->tests_counted || !(rays > 0))
        return json;
    json = pen_json_with(json, "box_tests_per_ray", pen_figure((double)stats->tests.boxes / rays));
    return pen_json_with(json, "primitive_tests_per_ray",
                         pen_figure((double)stats->tests.primitives / rays));
}

json_t *pen_figure_effects(unsigned effects)
{
    json_t *list = json_array();
    for (int bit = 0; bit < PEN_FX_COUNT; bit++) {
        if ((effects & (1u << bit)) &&
            json_array_append_new(list, json_string(pen_effect_name(bit))) != 0) {
            json_decref(list);
            return NULL;
        }
    }
    return list;
}

json_t *pen_figure_host(void)
{
    char model[128];
    pen_cpu_model(model, sizeof model);
    return json_pack("{s:s, s:s, s:i, s:s}", "cpu", model, "isa", pen_isa_name(pen_cpu_isa()),
                     "cores", pen_cpu_count(), "version", PEN_VERSION);
}
