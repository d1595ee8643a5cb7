/* SPDX-License-Identifier: MIT */
/* Pictures of spheres that only shine, before an even background. Rays go from points of the lens
 * to points of each sphere, instead of through pixels. So every ray brings light, however small and
 * bright a sphere is. */
#ifndef BENCH_GLOW_H
#define BENCH_GLOW_H

#include <math.h>
#include <stdlib.h>

#include "math/sample.h"
#include "math/scale.h"
#include "scene/scene.h"

/* Returns true if a scene has only such spheres. */
static inline bool bench_glow_only(const struct pen_scene *scene)
{
    const struct pen_sky *sky = &scene->sky;
    bool only = scene->light_count == 0 && scene->prims.count > 0 &&
                pen_norm1(pen_sub(sky->zenith, scene->background)) == 0 &&
                pen_norm1(pen_sub(sky->nadir, scene->background)) == 0;
    for (uint32_t i = 0; only && i < scene->prims.count; i++) {
        const struct pen_material *m = pen_scene_material(scene, i);
        only = pen_prim_kind(&scene->prims, i) == PEN_PRIM_SPHERE && !m->patterns &&
               pen_norm1(m->kr) + pen_norm1(m->kt) + pen_norm1(m->ka) == 0;
    }
    return only;
}

/* A picture in work. */
struct bench_glow {
    const struct pen_scene *scene;
    struct pen_pinhole pinhole;
    struct pen_lens lens;
    int width, height;
    double *sum; /* for each pixel: the part that spheres cover, then their light */
};

/* Returns true if a ray from o along the unit vector w meets another sphere before the sphere at
 * `distance`. */
static inline bool bench_glow_hidden(const struct bench_glow *g, uint32_t sphere, struct pen_vec3 o,
                                     struct pen_vec3 w, double distance)
{
    for (uint32_t i = 0; i < g->scene->prims.count; i++) {
        const struct pen_sphere *s = &g->scene->prims.sphere[i];
        const struct pen_vec3 to = pen_sub(s->c, o);
        const double along = pen_dot(to, w), off = s->rr - pen_dot(to, to) + along * along;
        if (i != sphere && off > 0 && along - sqrt(off) > 0 && along - sqrt(off) < distance)
            return true;
    }
    return false;
}

/* Adds a ray from the point `aside` of the lens towards a sphere, by a point of the unit square. */
static inline void bench_glow_ray(struct bench_glow *g, uint32_t sphere, struct pen_point2 lens,
                                  struct pen_point2 at, double rays)
{
    const double tau = 6.283185307179586;
    const struct pen_pinhole *p = &g->pinhole;
    const struct pen_sphere *s = &g->scene->prims.sphere[sphere];
    struct pen_vec3 aside = {0, 0, 0};
    double focus = 1;
    if (g->lens.open) {
        aside = pen_along(pen_scale(g->lens.right, lens.x), g->lens.up, lens.y);
        focus = g->lens.focus;
    }
    const struct pen_vec3 o = pen_add(p->eye, aside), to = pen_sub(s->c, o);
    const double dd = pen_dot(to, to), cosine = sqrt(1 - s->rr / dd);
    const double part = s->rr / dd / (1 + cosine); /* 1 - cosine, of the cone around the sphere */
    const struct pen_vec3 n = pen_normalize(to),
                          any = fabs(n.x) < 0.6 ? pen_vec3(1, 0, 0) : pen_vec3(0, 1, 0),
                          u = pen_normalize(pen_cross(n, any)), v = pen_cross(n, u);
    const double c = 1 - at.x * part, sine = sqrt(at.x * part * (1 + c));
    const struct pen_vec3 w =
        pen_along(pen_along(pen_scale(n, c), u, sine * cos(tau * at.y)), v, sine * sin(tau * at.y));
    const double along = c * sqrt(dd);
    const double distance = along - sqrt(pen_larger(0, s->rr - dd * (1 - c) * (1 + c)));
    const double mm = pen_dot(p->middle, p->middle), forward = pen_dot(w, p->middle);
    if (!(forward > 0) || bench_glow_hidden(g, sphere, o, w, distance))
        return;
    const struct pen_vec3 d = pen_scale(pen_along(aside, w, focus * mm / forward), 1 / focus);
    const double xx = pen_dot(p->dx, p->dx), yy = pen_dot(p->dy, p->dy);
    const double x = p->half_width + pen_dot(d, p->dx) / xx,
                 y = p->half_height + pen_dot(d, p->dy) / yy;
    if (!(x >= 0 && x < g->width && y >= 0 && y < g->height))
        return;
    const double slope = forward / sqrt(mm);
    const double share = tau * part * mm / (sqrt(xx * yy) * slope * slope * slope * rays);
    const struct pen_vec3 light = pen_scene_material(g->scene, sphere)->emission;
    double *sum = &g->sum[4 * ((size_t)y * (size_t)g->width + (size_t)x)];
    sum[0] += share;
    sum[1] += share * light.x;
    sum[2] += share * light.y;
    sum[3] += share * light.z;
}

/* Makes the picture. Returns false when out of memory. */
static inline bool bench_glow_render(const struct pen_scene *scene, const struct pen_settings *s,
                                     uint64_t seed, float *rgb)
{
    uint32_t rays = 1 << 20; /* rays to each sphere; fewer if there are many spheres */
    while (rays > 1 << 14 && rays / 4 * scene->prims.count > 1 << 20)
        rays /= 2;
    const size_t pixels = (size_t)s->width * (size_t)s->height;
    struct bench_glow g = {.scene = scene,
                           .pinhole = pen_scene_pinhole(scene, 0, s->width, s->height),
                           .width = s->width,
                           .height = s->height,
                           .sum = calloc(pixels, 4 * sizeof *g.sum)};
    if (!g.sum)
        return false;
    g.lens = pen_scene_lens(scene, 0, &g.pinhole);
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        struct pen_sample_key key = {.seed = seed, .x = i, .purpose = PEN_PURPOSE_LENS};
        const uint64_t lens = pen_sample_hash(&key);
        key.purpose = PEN_PURPOSE_LIGHT;
        const uint64_t light = pen_sample_hash(&key);
        for (uint32_t k = 0; k < rays; k++)
            bench_glow_ray(&g, i, pen_disk_of_square(pen_sobol2(lens, k)), pen_sobol2(light, k),
                           rays);
    }
    for (size_t i = 0; i < pixels; i++) {
        const double left = pen_larger(0, 1 - g.sum[4 * i]);
        rgb[3 * i] = (float)(g.sum[4 * i + 1] + left * scene->background.x);
        rgb[3 * i + 1] = (float)(g.sum[4 * i + 2] + left * scene->background.y);
        rgb[3 * i + 2] = (float)(g.sum[4 * i + 3] + left * scene->background.z);
    }
    free(g.sum);
    return true;
}

#endif
