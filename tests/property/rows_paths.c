/* SPDX-License-Identifier: MIT */
/* Trees of paths that fork at every surface, and where they are cut off. */
#include <stdlib.h>
#include <string.h>

#include "property/gen.h"
#include "property/rows.h"
#include "support/kit.h"

enum { SHEETS = 12, UNCUT = 2048 };

static struct kit kit;

/* Parallel planes, which a ray meets one after the other whatever its direction: the number of the
 * next one, and whether the numbers grow along the ray, say all about a path. */
struct sheets {
    int count, in_front; /* the eye is between number in_front - 1 and number in_front */
    int max_depth;
    double least, background;
    double emission[SHEETS], kt[SHEETS], kr[SHEETS];
};

/* What a pixel must be: the tree in depth-first order, the transmitted path before the reflected
 * one, cut off where it has as many surfaces as it may. */
struct expected {
    const struct sheets *sheets;
    double sum;
    uint64_t shaded, transmitted, reflected, cut;
};

static void follow(struct expected *e, int next, int step, double weight, int depth)
{
    const struct sheets *s = e->sheets;
    uint64_t most = s->max_depth > UNCUT ? (uint64_t)s->max_depth : UNCUT;
    if (next < 0 || next >= s->count) {
        e->sum += weight * s->background;
        return;
    }
    e->shaded++;
    e->sum += weight * s->emission[next];
    for (int mirrored = 0; mirrored < 2; mirrored++) {
        double w = weight * (mirrored ? s->kr[next] : s->kt[next]);
        int way = mirrored ? -step : step;
        if (depth == s->max_depth || !(w > 0) || w < s->least)
            continue;
        if (e->shaded == most) {
            e->cut++;
            continue;
        }
        ++*(mirrored ? &e->reflected : &e->transmitted);
        follow(e, next + way, way, w, depth + 1);
    }
}

static double draw_factor(struct random *r)
{
    static const double often[] = {0, 1, 1, .5, .25};
    uint32_t which = random_below(r, 8);
    return which < 5 ? often[which] : random_unit(r);
}

static void draw_sheets(struct random *r, struct sheets *s)
{
    s->count = 2 + (int)random_below(r, SHEETS - 1);
    s->in_front = (int)random_below(r, (uint32_t)s->count + 1);
    s->max_depth =
        random_below(r, 12) ? 1 + (int)random_below(r, 64) : UNCUT - 3 + (int)random_below(r, 1000);
    s->least = random_below(r, 3) ? 0 : gen_power(r, -30, -2);
    s->background = random_unit(r);
    bool clear = random_below(r, 2);
    for (int i = 0; i < s->count; i++) {
        s->emission[i] = random_unit(r);
        s->kt[i] = clear ? 1 : draw_factor(r);
        s->kr[i] = clear ? 1 : draw_factor(r);
    }
}

static vec3 grey(double x)
{
    return pen_vec3(x, x, x);
}

/* One pixel, whose ray crosses the sheets at up to 80 degrees from their normal. */
static void make_sheets(struct random *r, const struct sheets *s)
{
    double size = gen_power(r, -26, 26);
    vec3 n = random_direction(r), x, y;
    gen_frame(r, n, &x, &y);
    kit_init(&kit);
    kit.settings.max_depth = s->max_depth;
    kit.settings.min_contribution = s->least;
    kit.desc.background = grey(s->background);
    kit.view.camera.position = pen_scale(random_vec(r, 2), size);
    kit.view.camera.direction = pen_along(n, x, random_in(r, 0, 5));
    kit.view.camera.up = y;
    for (int i = 0; i < s->count; i++) {
        double height = i - s->in_front + random_in(r, .1, .9);
        struct pen_material m = pen_material_default();
        m.emission = grey(s->emission[i]);
        m.kt = grey(s->kt[i]);
        m.kr = grey(s->kr[i]);
        kit_plane(&kit, pen_along(kit.view.camera.position, n, size * height), n,
                  kit_material(&kit, m));
    }
}

static void draw_seed(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, (double)(random_bits(&d->random) >> 40));
}

static struct random of_seed(const struct row_case *c)
{
    uint64_t seed = (uint64_t)c->arg[0] * 0x9e3779b97f4a7c15u + 112;
    return (struct random){seed, seed};
}

static void judge_sheets(const struct row_case *c, struct row_verdict *v)
{
    struct random r = of_seed(c);
    struct sheets s;
    struct pen_ray_counts rays;
    struct pen_status st;
    double rgb[3];
    draw_sheets(&r, &s);
    make_sheets(&r, &s);
    struct expected e = {.sheets = &s};
    follow(&e, s.in_front, 1, 1, 1);
    struct pen_scene *scene = kit_freeze(&kit);
    bool ok = pen_render_pixel(scene, 0, &kit.settings, 0, 0, rgb, &rays, &st);
    pen_scene_free(scene);
    if (!row_require(v, ok, "not rendered"))
        return;
    if (rgb[0] != e.sum || rgb[1] != e.sum || rgb[2] != e.sum)
        row_fail(v, "%a, want %a", rgb[0], e.sum);
    if (rays.truncated_paths != e.cut)
        row_fail(v, "%llu paths cut off, want %llu", (unsigned long long)rays.truncated_paths,
                 (unsigned long long)e.cut);
    row_require(v, rays.transmission == e.transmitted && rays.reflection == e.reflected,
                "rays are not those of the tree");
    row_tally(v, e.cut ? "cut" : e.transmitted && e.reflected ? "whole" : "does not fork");
}

void rows_path_tree(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_sheets);
}

enum { WIDTH = 5, HEIGHT = 4, FLOATS = 3 * WIDTH * HEIGHT };

/* Balls close together, which reflect and transmit all light or most of it. */
static void make_balls(struct random *r)
{
    kit_init(&kit);
    kit.settings.width = WIDTH;
    kit.settings.height = HEIGHT;
    kit.settings.max_depth = 20 + (int)random_below(r, 41);
    kit.settings.min_contribution = 0;
    kit.settings.samples_per_pixel = 1 + (int)random_below(r, 2);
    kit.settings.light_samples = 2;
    kit.desc.background = random_vec(r, 1);
    kit.view.camera.fov_degrees = 12;
    for (int i = 3 + (int)random_below(r, 10); i > 0; i--) {
        struct pen_material m = kit_matte(random_unit(r));
        double most = random_below(r, 2) ? 1 : random_unit(r);
        m.kr = m.kt = grey(most);
        kit_sphere(&kit, random_vec(r, 1.5), random_in(r, .3, 1.2), kit_material(&kit, m));
    }
    if (random_below(r, 2))
        kit_point(&kit, pen_vec3(3, 6, 6), grey(1))->radius = random_below(r, 2) ? .5 : 0;
}

/* A way to render that must not matter. With `parts`, each half of the tiles is a run of its own,
 * as the batches of a job are. */
struct way {
    int threads, tile;
    enum pen_accelerator accelerator;
    bool base, parts;
};

static bool render_part(const struct pen_render_task *task, struct pen_ray_counts *sum)
{
    static struct pen_thread_pool *pool;
    struct pen_render_stats stats = {.threads = 0};
    struct pen_status st;
    if (!pool)
        pool = pen_thread_pool_new(8, &st);
    bool ok = pool && pen_render_run(pool, task, &stats, &st);
    pen_ray_counts_add(sum, &stats.rays);
    return ok;
}

static bool render_way(const struct way *way, float rgb[FLOATS], struct pen_ray_counts *rays)
{
    kit.settings.threads = way->threads;
    kit.settings.tile = way->tile;
    kit.settings.accelerator = (int)way->accelerator;
    if (way->base)
        setenv("PENUMBRA_ISA", "base", 1);
    struct pen_scene *scene = kit_freeze(&kit);
    int tiles = pen_tile_count(WIDTH, HEIGHT, way->tile);
    struct pen_render_task task = {.scene = scene,
                                   .settings = &kit.settings,
                                   .tile_count = way->parts ? tiles / 2 : -1,
                                   .rgb = rgb};
    *rays = (struct pen_ray_counts){0};
    bool ok = render_part(&task, rays);
    if (way->parts) {
        task.first_tile = task.tile_count;
        task.tile_count = -1;
        ok = ok && render_part(&task, rays);
    }
    pen_scene_free(scene);
    if (way->base)
        unsetenv("PENUMBRA_ISA");
    return ok;
}

static void judge_ways(const struct row_case *c, struct row_verdict *v)
{
    static const struct way ways[] = {
        {.threads = 1, .tile = 32, .accelerator = PEN_ACCEL_AUTO},
        {.threads = 2, .tile = 1, .accelerator = PEN_ACCEL_AUTO},
        {.threads = 8, .tile = 2, .accelerator = PEN_ACCEL_NONE},
        {.threads = 1, .tile = 2, .accelerator = PEN_ACCEL_MEDIAN, .base = true},
        {.threads = 2, .tile = 1, .accelerator = PEN_ACCEL_AUTO, .parts = true},
    };
    struct random r = of_seed(c);
    float want[FLOATS], got[FLOATS];
    struct pen_ray_counts want_rays, rays;
    make_balls(&r);
    bool ok = render_way(&ways[0], want, &want_rays);
    for (size_t i = 1; ok && i < sizeof ways / sizeof ways[0]; i++) {
        ok = render_way(&ways[i], got, &rays);
        row_require(v, memcmp(got, want, sizeof got) == 0, "another film");
        row_require(v, memcmp(&rays, &want_rays, sizeof rays) == 0, "other counts");
    }
    row_require(v, ok, "not rendered");
    row_tally(v, want_rays.truncated_paths ? "cut" : "whole");
}

void rows_tree_ways(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_ways);
}
