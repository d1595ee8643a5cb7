/* SPDX-License-Identifier: MIT */
#include "io/stats_json.h"

#include "base/memory.h"
#include "io/figures.h"
#include "io/json_build.h"

static json_t *timing_json(const struct pen_stats_input *in)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "queue_ms",
                     pen_figure(in->queue_ms), "parse_ms", pen_figure(in->parse_ms), "build_ms",
                     pen_figure(in->build_ms), "render_ms", pen_figure(in->render->render_ms),
                     "encode_ms", pen_figure(in->encode_ms), "store_ms", pen_figure(in->store_ms),
                     "total_ms", pen_figure(in->total_ms), "cpu_ms",
                     pen_figure(in->render->cpu_ms));
}

json_t *pen_stats_tiles(uint64_t count, const struct pen_percentiles *ms)
{
    return json_pack("{s:I, s:{s:o, s:o, s:o}}", "count", (json_int_t)count, "ms", "p50",
                     pen_figure(ms->p50), "p95", pen_figure(ms->p95), "max", pen_figure(ms->max));
}

/* Scene units can have any magnitude, so these lengths are not rounded by pen_figure. */
static json_t *precision_json(const struct pen_scene_precision *p)
{
    char warning[PEN_MSG_BYTES], thin[PEN_MSG_BYTES];
    bool warns = pen_precision_warning(p, warning, sizeof warning);
    if (!warns && pen_thinness_warning(p, thin, sizeof thin)) {
        snprintf(warning, sizeof warning, "primitive %u %.400s", (unsigned)p->thin_prim, thin);
        warns = true;
    }
    return json_pack("{s:f, s:f, s:f, s:f, s:f, s:f, s:s*}", "extent", p->extent, "coordinate_max",
                     p->coordinate_max, "ulp", p->ulp, "pixel_footprint", p->pixel_footprint,
                     "resolution", p->resolution, "thinness", p->thinness, "warning",
                     warns ? warning : NULL);
}

json_t *pen_stats_json(const struct pen_stats_input *in)
{
    const struct pen_render_stats *r = in->render;
    struct pen_percentiles tiles;
    if (!pen_percentiles_of(r->tile_ms, r->tile_ms ? r->tile_count : 0, &tiles))
        return NULL;
    json_t *json = json_pack(
        "{s:o, s:o, s:o, s:i, s:o, s:o, s:s, s:o, s:{s:I}, s:I, s:I, s:I, s:i, s:o}", "timing",
        timing_json(in), "rays", pen_figure_rays(&r->rays), "mrays_per_second",
        pen_figure_rate(&r->rays, r->render_ms), "threads", r->threads, "tiles",
        pen_stats_tiles(r->tile_count, &tiles), "accelerator", pen_figure_accelerator(in->accel, r),
        "kernel", r->kernel ? r->kernel : "", "effects", pen_figure_effects(r->effects), "memory",
        "peak_bytes", (json_int_t)pen_memory_peak_bytes(), "dropped_samples",
        (json_int_t)r->rays.dropped_samples, "truncated_paths", (json_int_t)r->rays.truncated_paths,
        "unmatched_exits", (json_int_t)r->rays.unmatched_exits, "float_resets", r->float_resets,
        "host", pen_figure_host());
    return in->precision ? pen_json_with(json, "precision", precision_json(in->precision)) : json;
}
