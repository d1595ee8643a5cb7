/* SPDX-License-Identifier: MIT */
#include "io/stats_json.h"

#include "base/memory.h"
#include "io/figures.h"
#include "io/json_build.h"
#include "io/settings_json.h"

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

static json_t *rounds_json(const struct pen_adaptive_stats *adaptive)
{
    json_t *rounds = json_array();
    for (int i = 0; i < adaptive->rounds; i++) {
        const struct pen_round *r = &adaptive->round[i];
        json_t *round = json_pack("{s:I, s:i, s:o}", "pixels", (json_int_t)r->pixels, "level",
                                  r->level, "estimated_error", pen_figure_error(r->error));
        if (adaptive->timed)
            round = pen_json_with(round, "tiles", json_integer(r->tiles));
        json_array_append_new(rounds, round);
    }
    return pen_json_all(rounds, (size_t)adaptive->rounds);
}

/* {rule, target_error, met, interval, confidence, samples_per_pixel: {mean, min, p50, p95, max},
 * capped_pixels, unproven, rounds}. */
static json_t *adaptive_json(const struct pen_adaptive_stats *adaptive)
{
    const struct pen_round *last = &adaptive->round[adaptive->rounds - 1];
    const struct pen_sample_spread *s = &adaptive->samples;
    json_t *target = adaptive->target > PEN_TARGET_NONE ? json_real(adaptive->target) : json_null();
    return json_pack("{s:i, s:o, s:b, s:[o, o], s:f, s:{s:o, s:I, s:I, s:I, s:I}, s:I, s:f, s:o}",
                     "rule", PEN_ADAPTIVE_RULE, "target_error", target, "met", adaptive->met,
                     "interval", pen_figure_error(last->low), pen_figure_error(last->high),
                     "confidence", PEN_ADAPTIVE_CONFIDENCE, "samples_per_pixel", "mean",
                     pen_figure(s->mean), "min", (json_int_t)s->least, "p50", (json_int_t)s->median,
                     "p95", (json_int_t)s->p95, "max", (json_int_t)s->most, "capped_pixels",
                     (json_int_t)adaptive->capped, "unproven", adaptive->unproven, "rounds",
                     rounds_json(adaptive));
}

/* Adds the data of an adaptive render. For a render that a deadline ended, also the data to repeat
 * it. */
static json_t *with_adaptive(json_t *json, const struct pen_stats_input *in)
{
    const struct pen_adaptive_stats *adaptive = &in->render->adaptive;
    if (adaptive->rounds == 0)
        return json;
    json = pen_json_with(json, "estimated_error",
                         pen_figure_error(adaptive->round[adaptive->rounds - 1].error));
    json = pen_json_with(json, "adaptive", adaptive_json(adaptive));
    if (!adaptive->timed || !in->settings)
        return json;
    json = pen_json_with(json, "render", pen_settings_json(in->settings));
    return pen_json_with(json, "scene_sha256", json_string(in->scene_sha256));
}

static json_t *clusters_json(const struct pen_audit *audit)
{
    json_t *list = json_array();
    for (int i = 0; i < audit->clusters; i++) {
        const struct pen_audit_cluster *c = &audit->cluster[i];
        json_array_append_new(list, json_pack("{s:i, s:i, s:i, s:i, s:I, s:I}", "x", c->rect.x, "y",
                                              c->rect.y, "width", c->rect.width, "height",
                                              c->rect.height, "wrong", (json_int_t)c->wrong,
                                              "pixels", (json_int_t)c->pixels));
    }
    return pen_json_all(list, (size_t)audit->clusters);
}

json_t *pen_stats_audit(const struct pen_audit *audit)
{
    char seed[17];
    snprintf(seed, sizeof seed, "%016llx", (unsigned long long)audit->seed);
    return json_pack("{s:I, s:f, s:I, s:I, s:o, s:s, s:o}", "pixels", (json_int_t)audit->pixels,
                     "threshold", audit->threshold, "wrong", (json_int_t)audit->wrong, "undecided",
                     (json_int_t)audit->undecided, "bound", pen_figure_error(audit->bound), "seed",
                     seed, "clusters", clusters_json(audit));
}

/* {count, triangles, tree_bytes_per_triangle, bytes_per_triangle}. */
static json_t *meshes_json(const struct pen_stats_input *in)
{
    const struct pen_prims *prims = &in->scene->prims;
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < prims->mesh_count; i++)
        triangles += prims->mesh[i].count;
    return json_pack("{s:I, s:I, s:o, s:o}", "count", (json_int_t)prims->mesh_count, "triangles",
                     (json_int_t)triangles, "tree_bytes_per_triangle",
                     pen_figure((double)in->accel->bytes / (double)triangles), "bytes_per_triangle",
                     pen_figure((double)in->scene_bytes / (double)triangles));
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
    json = with_adaptive(json, in);
    if (in->audit)
        json = pen_json_with(json, "audit", pen_stats_audit(in->audit));
    if (in->scene && in->scene->prims.mesh_count > 0)
        json = pen_json_with(json, "meshes", meshes_json(in));
    return in->precision ? pen_json_with(json, "precision", precision_json(in->precision)) : json;
}
