/* SPDX-License-Identifier: MIT */
/* Soft shadows: the mean transmittance of shadow rays to points of a light's disk, which faces the
 * shaded point. */
#ifndef SHADE_SOFT_H
#define SHADE_SOFT_H

#include "pen/math/frame.h"
#include "shadow.h"

/* The disk seen from a shaded point: c + a u + b v with a^2 + b^2 <= 1. */
struct disk {
    struct pen_vec3 c, u, v;
};

/* A light's disk is perpendicular to the direction to it; that of a directional one is at unit
 * distance. */
static ALWAYS_INLINE struct disk disk_of(const struct pen_light *light, struct pen_vec3 to_light)
{
    struct pen_vec3 n = light->kind == PEN_LIGHT_DIRECTIONAL ? to_light : pen_normalize(to_light);
    struct pen_across across = pen_across(n);
    return (struct disk){to_light, pen_scale(across.u, light->radius),
                         pen_scale(across.v, light->radius)};
}

/* The samples of one light from one point. */
struct soft {
    struct disk disk;
    struct shadow_way way; /* of the sample at hand */
    struct pen_vec3 sum;   /* of transmittances */
    uint32_t points, rays;
};

/* Adds the sample at a point of the unit disk. One below the horizon is reached through the surface
 * itself, which takes its share first, or all of it. */
static ALWAYS_INLINE void soft_add(const struct pen_kernel_input *input,
                                   struct pen_kernel_scratch *scratch, const struct surface *s,
                                   struct soft *soft, struct pen_point2 at, const unsigned fx)
{
    struct shadow_way *way = &soft->way;
    way->d = pen_along(pen_along(soft->disk.c, soft->disk.u, at.x), soft->disk.v, at.y);
    way->through = !(pen_dot(s->n, way->d) > 0);
    way->in = way->through ? s->material->kt : pen_vec3(1, 1, 1);
    soft->points++;
    if (way->through && (!(fx & PEN_FX_SHADOW_TRANSMITTANCE) || is_black(way->in)))
        return;
    soft->rays++;
    uint32_t *last = &scratch->last_occluder[way->light], before = *last;
    soft->sum = pen_add(soft->sum, shadow_ray(input, scratch, s, way, fx));
    if (*last == PEN_NO_PRIM)
        *last = before; /* what blocked one sample may block the next but one */
}

/* The least m with m^2 >= n. */
static inline uint32_t soft_edge(uint32_t n)
{
    uint32_t m = (uint32_t)sqrt(n);
    return m * m < n ? m + 1 : m;
}

static ALWAYS_INLINE void soft_add_grid(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch, const struct surface *s,
                                        struct soft *soft, uint64_t hash, const unsigned fx)
{
    uint32_t edge = soft_edge((uint32_t)input->settings->light_samples);
    for (uint32_t cell = 0; cell < edge * edge; cell++) {
        struct pen_point2 p = pen_grid2(hash, edge, cell);
        struct pen_point2 at = {2 * p.x - 1, 2 * p.y - 1};
        if (at.x * at.x + at.y * at.y <= 1)
            soft_add(input, scratch, s, soft, at, fx);
    }
    if (soft->points == 0)
        soft_add(input, scratch, s, soft, (struct pen_point2){0, 0}, fx);
}

/* T(p) of a light with a disk. */
static ALWAYS_INLINE struct pen_vec3
soft_transmittance(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                   const struct surface *s, const struct lit *lit, struct pen_ray_counts *counts,
                   const unsigned fx)
{
    const struct pen_settings *settings = input->settings;
    struct soft soft = {.disk = disk_of(&input->scene->lights[lit->light], lit->to_light),
                        .way = {.to_point = lit->to_point, .light = lit->light}};
    scratch->key.light = input->scene->light_index[lit->light];
    uint64_t hash = pen_sample_hash(&scratch->key);
    if (settings->light_pattern == PEN_PATTERN_GRID) {
        soft_add_grid(input, scratch, s, &soft, hash, fx);
    } else {
        bool sobol = settings->light_pattern == PEN_PATTERN_SOBOL;
        for (uint32_t i = 0; i < (uint32_t)settings->light_samples; i++) {
            struct pen_point2 p = sobol ? pen_sobol2(hash, i) : pen_random2(hash, i);
            soft_add(input, scratch, s, &soft, pen_disk_of_square(p), fx);
        }
    }
    counts->shadow += soft.rays;
    double points = soft.points;
    return pen_vec3(soft.sum.x / points, soft.sum.y / points, soft.sum.z / points);
}

#endif
