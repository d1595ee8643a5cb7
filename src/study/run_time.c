/* SPDX-License-Identifier: MIT */
#include "study/run_time.h"

#include <math.h>

#include "base/clock.h"
#include "base/cpu.h"
#include "study/host.h"
#include "study/verdict.h"

static const double least_used = 0.95, most_stolen = 0.05;
static const double wake_ms = 0.5, tick_ms = 10;

struct pen_run_watch pen_run_begin(void)
{
    const double steal_ms = pen_host_steal_ms();
    return (struct pen_run_watch){.begun_ns = pen_clock_ns(), .steal_ms = steal_ms};
}

struct pen_run_use pen_run_end(const struct pen_run_watch *watch,
                               const struct pen_render_stats *stats, double alone_ms,
                               double alone_cpu_ms)
{
    const double wall_ms = (double)(pen_clock_ns() - watch->begun_ns) * 1e-6,
                 stolen_ms = pen_host_steal_ms() - watch->steal_ms;
    const int processors = pen_cpu_count(), threads = stats->threads;
    const double share = threads > processors ? (double)processors / threads : 1,
                 cpu_ms = stats->cpu_ms + alone_cpu_ms,
                 could_ms = stats->thread_ms * share + alone_ms;
    struct pen_run_use use = {
        .used = could_ms > 0 && cpu_ms < could_ms ? cpu_ms / could_ms : 1,
        .steal_ms = watch->steal_ms < 0 || stolen_ms < 0 ? -1 : stolen_ms,
    };
    use.spoiled = (use.used < least_used && could_ms - cpu_ms > wake_ms * (threads + 1)) ||
                  use.steal_ms - tick_ms > most_stolen * wall_ms * pen_host_processors();
    return use;
}

struct pen_row_time pen_row_time_of(const struct pen_run_time *runs, int count)
{
    double values[PEN_RUN_TIMES_MAX];
    struct pen_row_time out = {.alone = HUGE_VAL, .runs = count};
    int kept = 0;
    for (int i = 0; i < count; i++)
        out.spoiled += runs[i].spoiled;
    for (int i = 0; i < count && kept < PEN_RUN_TIMES_MAX; i++) {
        if (runs[i].spoiled && out.spoiled < count)
            continue;
        values[kept++] = runs[i].ms;
        out.alone = fmin(out.alone, runs[i].ms * runs[i].used);
    }
    if (kept == 0)
        return (struct pen_row_time){0};
    out.median = pen_median(values, kept);
    out.min = values[0];
    out.max = values[kept - 1];
    return out;
}

/* Whether a is clearly faster. */
static bool is_quicker(const struct pen_row_time *a, const struct pen_row_time *b)
{
    return a->spoiled < a->runs && b->spoiled < b->runs &&
           a->max * (1 + PEN_LEAST_EFFECT) < b->alone;
}

int pen_row_time_compare(const struct pen_row_time *a, const struct pen_row_time *b)
{
    return is_quicker(b, a) - is_quicker(a, b);
}

uint64_t pen_rays_total(const struct pen_ray_counts *rays)
{
    return rays->primary + rays->shadow + rays->reflection + rays->transmission;
}

int pen_row_cost_compare(const struct pen_row_time *a, const struct pen_ray_counts *a_rays,
                         const struct pen_row_time *b, const struct pen_ray_counts *b_rays)
{
    const int order = pen_row_time_compare(a, b);
    const uint64_t of_a = pen_rays_total(a_rays), of_b = pen_rays_total(b_rays);
    return order != 0 ? order : (of_a > of_b) - (of_a < of_b);
}

void pen_runs_use_add(struct pen_runs_use *sum, const struct pen_run_time *runs, int count)
{
    for (int i = 0; i < count; i++) {
        sum->runs++;
        sum->spoiled += runs[i].spoiled;
        sum->used += (runs[i].used - sum->used) / sum->runs;
    }
}
