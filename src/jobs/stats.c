/* SPDX-License-Identifier: MIT */
/* The statistics object of http-api.md for one render. What a batch's statistics carry besides,
 * so that those of several batches can be put together, is in stats.h. */
#include "stats.h"

#include <fcntl.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

#include "jobs.h"
#include "pen/base/cpu.h"

double pen_stats_round(double ms)
{
    return round(ms * 1000) / 1000;
}

json_t *pen_stats_ms(double ms)
{
    return json_real(pen_stats_round(ms));
}

void pen_peak_reset(void)
{
    int fd = open("/proc/self/clear_refs", O_WRONLY | O_CLOEXEC);
    if (fd < 0)
        return;
    /* "5" resets the peak of the resident set, see proc(5). Without it the peak is the whole
     * process's, which is an upper bound. */
    if (write(fd, "5", 1) < 0) {
        close(fd);
        return;
    }
    close(fd);
}

int64_t pen_peak_bytes(void)
{
    char text[4096];
    int fd = open("/proc/self/status", O_RDONLY | O_CLOEXEC);
    ssize_t n = fd >= 0 ? read(fd, text, sizeof text - 1) : 0;
    if (fd >= 0)
        close(fd);
    text[n > 0 ? n : 0] = '\0';
    const char *peak = strstr(text, "VmHWM:");
    if (peak)
        return strtoll(peak + strlen("VmHWM:"), NULL, 10) * 1024;
    struct rusage usage;
    return getrusage(RUSAGE_SELF, &usage) == 0 ? (int64_t)usage.ru_maxrss * 1024 : 0;
}

json_t *pen_stats_host(void)
{
    char model[128];
    pen_cpu_model(model, sizeof model);
    return json_pack("{s:s, s:s, s:i, s:s}", "cpu", model, "isa", pen_isa_name(pen_cpu_isa()),
                     "cores", pen_cpu_count(), "version", PEN_VERSION);
}

json_t *pen_effects_json(unsigned effects)
{
    json_t *list = json_array();
    size_t count = 0;
    for (int bit = 0; bit < PEN_FX_COUNT; bit++) {
        if (!(effects & (1u << bit)))
            continue;
        json_array_append_new(list, json_string(pen_effect_name(bit)));
        count++;
    }
    return pen_json_all(list, count);
}

json_t *pen_stats_rays(const struct pen_ray_counts *rays)
{
    return json_pack("{s:I, s:I, s:I, s:I, s:I}", "primary", (json_int_t)rays->primary, "shadow",
                     (json_int_t)rays->shadow, "reflection", (json_int_t)rays->reflection,
                     "transmission", (json_int_t)rays->transmission, "total",
                     (json_int_t)pen_stats_total(rays));
}

uint64_t pen_stats_total(const struct pen_ray_counts *rays)
{
    return rays->primary + rays->shadow + rays->reflection + rays->transmission;
}

json_t *pen_stats_rate(uint64_t rays, double render_ms)
{
    return pen_stats_ms(render_ms > 0 ? (double)rays / render_ms / 1000 : 0);
}

static json_t *accelerator_json(const struct pen_accel_stats *s, const struct pen_render_stats *r)
{
    json_t *json =
        json_pack("{s:s, s:I, s:I, s:I, s:I, s:o, s:o}", "kind", pen_accelerator_name(s->kind),
                  "nodes", (json_int_t)s->nodes, "leaves", (json_int_t)s->leaves, "depth",
                  (json_int_t)s->depth, "bytes", (json_int_t)s->bytes, "sah_cost",
                  pen_stats_ms(s->sah_cost), "build_ms", pen_stats_ms(s->build_ms));
    double rays = (double)pen_stats_total(&r->rays);
    if (!r->tests_counted || !(rays > 0))
        return json;
    json = pen_json_with(json, "box_tests_per_ray", pen_stats_ms((double)r->tests.boxes / rays));
    return pen_json_with(json, "primitive_tests_per_ray",
                         pen_stats_ms((double)r->tests.primitives / rays));
}

static json_t *timing_json(const struct pen_stats_input *in)
{
    return json_pack("{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "queue_ms",
                     pen_stats_ms(in->queue_ms), "parse_ms", pen_stats_ms(in->parse_ms), "build_ms",
                     pen_stats_ms(in->build_ms), "render_ms", pen_stats_ms(in->render->render_ms),
                     "encode_ms", pen_stats_ms(in->encode_ms), "store_ms",
                     pen_stats_ms(in->store_ms), "total_ms", pen_stats_ms(in->total_ms), "cpu_ms",
                     pen_stats_ms(in->render->cpu_ms));
}

json_t *pen_stats_tiles(uint64_t count, const struct pen_percentiles *ms)
{
    return json_pack("{s:I, s:{s:o, s:o, s:o}}", "count", (json_int_t)count, "ms", "p50",
                     pen_stats_ms(ms->p50), "p95", pen_stats_ms(ms->p95), "max",
                     pen_stats_ms(ms->max));
}

json_t *pen_stats_json(const struct pen_stats_input *in)
{
    const struct pen_render_stats *r = in->render;
    struct pen_percentiles tiles;
    if (!pen_percentiles_of(r->tile_ms, r->tile_ms ? r->tile_count : 0, &tiles))
        return NULL;
    return json_pack("{s:o, s:o, s:o, s:i, s:o, s:o, s:s, s:o, s:{s:I}, s:I, s:o}", "timing",
                     timing_json(in), "rays", pen_stats_rays(&r->rays), "mrays_per_second",
                     pen_stats_rate(pen_stats_total(&r->rays), r->render_ms), "threads", r->threads,
                     "tiles", pen_stats_tiles(r->tile_count, &tiles), "accelerator",
                     accelerator_json(pen_accel_get_stats(in->scene->accel), r), "kernel",
                     r->kernel ? r->kernel : "", "effects", pen_effects_json(r->effects), "memory",
                     "peak_bytes", (json_int_t)pen_peak_bytes(), "dropped_samples",
                     (json_int_t)r->rays.dropped_samples, "host", pen_stats_host());
}
