/* SPDX-License-Identifier: MIT */
/* The block kernel: the pixels of a block, rendered together in waves of up to 64 rays, with the
 * same bits as the pixel kernel (kernel_body.h).
 *
 * The first wave are the camera rays. A wave is traced as one packet; then, light by light in
 * document order, the shadow rays of all its points; then its transmitted and reflected paths are
 * put on two stacks, from which the next waves are taken. What each surface sends to its pixel is
 * kept in a *record*. When no path is left, each pixel adds up its records in the order in which
 * the pixel kernel traverses its tree: a surface, the tree behind it, the tree that it reflects.
 *
 * Memory is bounded: BLOCK_RECORDS records, PIXEL_RECORDS of them for one pixel,
 * so that no tree that the cap on surfaces cuts fits in; BLOCK_PATHS paths. A pixel sample that
 * has no room left, that meets coincident surfaces, or whose point is not finite, is *left* to the
 * pixel kernel, and what the block knows of it is forgotten. */
#ifndef PEN_SHADE_INTERNAL_BLOCK_BODY_H
#define PEN_SHADE_INTERNAL_BLOCK_BODY_H

#include "shade/internal/pixel_sample.h"
#include "shade/internal/secondary_rays.h"
#include "shade/internal/soft_shadow.h"

enum {
    BLOCK_PIXELS = PEN_BLOCK_SIDE * PEN_BLOCK_SIDE,
    BLOCK_RECORDS = 64 * BLOCK_PIXELS,
    BLOCK_PATHS = 1024,
    WAVE_GROUPS = PEN_RAY_PACKET_MAX / LANES,
    PIXEL_RECORDS = 1024, /* less than pen_tree_surfaces_max */
    NO_RECORD = -1
};
_Static_assert((int)BLOCK_PIXELS <= (int)PEN_RAY_PACKET_MAX,
               "the camera rays of a block are one wave");

/* What one surface, or the background, sends to its pixel, and the records of the paths from it. */
struct block_record {
    struct pen_vec3 radiance; /* times the path's weight */
    int32_t transmitted, reflected;
};

/* A path of a pixel that is traced, or waits for it. */
struct block_path {
    struct path path;
    int32_t record;
    uint8_t pixel;
};

/* A stack of paths, by their place in the pool. */
struct block_stack {
    int count;
    uint16_t path[BLOCK_PATHS];
};

/* Points of the image, one for each pixel of a block. */
struct block_points {
    double x[BLOCK_PIXELS], y[BLOCK_PIXELS];
};

/* The working memory of a block: pen_kernel_scratch owns one. Its size is that of the instruction
 * set's vectors, so only the block kernels know it. */
struct pen_block_scratch {
    /* By groups of LANES points of the wave. */
    struct surface surface[WAVE_GROUPS];
    struct arriving_light arriving[WAVE_GROUPS];
    lane_mask lit[WAVE_GROUPS]; /* points to which lights contribute */
    struct lanes3 radiance[WAVE_GROUPS];
    /* By paths of the wave; after it has been traced, only those that meet a surface. */
    int count;
    struct block_path *wave[PEN_RAY_PACKET_MAX];
    double transmittance[3][PEN_RAY_PACKET_MAX];
    struct pen_ray shadow_ray[PEN_RAY_PACKET_MAX];
    struct pen_shadow query[PEN_RAY_PACKET_MAX];
    struct pen_ray_packet packet;
    int of_packet[PEN_RAY_PACKET_MAX]; /* the points of its shadow rays */
    /* By pixel. */
    int x[BLOCK_PIXELS], y[BLOCK_PIXELS];
    uint64_t left; /* bits of pixels that are left to the pixel kernel */
    struct pen_ray_counts counts[BLOCK_PIXELS];
    int surfaces[BLOCK_PIXELS]; /* records of each pixel */
    struct block_stack transmitted, reflected, unused;
    int used; /* of the pool, from its beginning */
    struct block_path pool[BLOCK_PATHS];
    int record_count;
    struct block_record record[BLOCK_RECORDS];
};

/* A new record for a pixel; NO_RECORD if there is no room. */
static ALWAYS_INLINE int32_t block_record_new(struct pen_block_scratch *b, int pixel)
{
    if (b->record_count == BLOCK_RECORDS || b->surfaces[pixel]++ == PIXEL_RECORDS)
        return NO_RECORD;
    b->record[b->record_count] = (struct block_record){{0, 0, 0}, NO_RECORD, NO_RECORD};
    return b->record_count++;
}

static ALWAYS_INLINE void stack_push(struct block_stack *stack, const struct pen_block_scratch *b,
                                     const struct block_path *path)
{
    stack->path[stack->count++] = (uint16_t)(path - b->pool);
}

/* A path from the pool; NULL if there is none. */
static ALWAYS_INLINE struct block_path *block_path_new(struct pen_block_scratch *b)
{
    if (b->unused.count > 0)
        return &b->pool[b->unused.path[--b->unused.count]];
    return b->used < BLOCK_PATHS ? &b->pool[b->used++] : NULL;
}

/* Takes the next wave from a stack, without the paths of pixels that are left. */
static ALWAYS_INLINE void block_take(struct pen_block_scratch *b, struct block_stack *stack)
{
    b->count = 0;
    while (stack->count > 0 && b->count < PEN_RAY_PACKET_MAX) {
        struct block_path *next = &b->pool[stack->path[--stack->count]];
        if (b->left >> next->pixel & 1)
            stack_push(&b->unused, b, next);
        else
            b->wave[b->count++] = next;
    }
}

/* Whether the path's next hit is one of several layers: see path_nearest. */
static ALWAYS_INLINE bool is_layered(const struct pen_kernel_input *input, const struct path *path,
                                     struct pen_hit hit)
{
    const uint32_t *first = input->scene->layer_first;
    return first && first[hit.prim] != first[hit.prim + 1] && hit.t > PEN_LAST_LAYER_T &&
           pen_layers_met(input, path, hit);
}

/* Leaves the pixel of a path to the pixel kernel. */
static ALWAYS_INLINE void block_leave(struct pen_block_scratch *b, const struct block_path *path)
{
    b->left |= UINT64_C(1) << path->pixel;
}

static ALWAYS_INLINE int block_groups(const struct pen_block_scratch *b)
{
    return (b->count + LANES - 1) / LANES;
}

/* The paths of one group of the wave. Returns how many. */
static ALWAYS_INLINE int block_group_paths(const struct pen_block_scratch *b, int group,
                                           const struct path **path)
{
    const int first = group * LANES, left = b->count - first, count = left < LANES ? left : LANES;
    for (int i = 0; i < count; i++)
        path[i] = &b->wave[first + i]->path;
    return count;
}

/* Of the wave's points, as bits, those of one group. */
static ALWAYS_INLINE unsigned group_bits(uint64_t points, int group)
{
    return (unsigned)(points >> (group * LANES)) & LANES_ALL;
}

/* Traces the wave. The paths that meet a surface remain in it. */
static ALWAYS_INLINE void block_trace(const struct pen_kernel_input *input,
                                      struct pen_block_scratch *b)
{
    const struct pen_scene *scene = input->scene;
    struct pen_ray_packet *packet = &b->packet;
    packet->count = b->count;
    for (int i = 0; i < b->count; i++) {
        const struct path *path = &b->wave[i]->path;
        packet->ray[i] = &path->ray;
        packet->origin[i] = &path->origin;
        packet->after[i] = path->after;
    }
    const uint64_t met = input->trace->nearest_packet(scene->accel, packet);
    int points = 0;
    for (int i = 0; i < b->count; i++) {
        struct block_path *at = b->wave[i];
        const struct pen_hit hit = packet->hit[i];
        if (!(met >> i & 1)) {
            b->record[at->record].radiance = pen_mul(at->path.weight, scene->background);
            stack_push(&b->unused, b, at);
        } else if (is_layered(input, &at->path, hit)) {
            block_leave(b, at);
            stack_push(&b->unused, b, at);
        } else {
            b->surface[points / LANES].hit[points % LANES] = hit;
            b->wave[points++] = at;
        }
    }
    b->count = points;
}

/* Computes the surfaces of the wave. */
static ALWAYS_INLINE void block_surfaces(const struct pen_kernel_input *input,
                                         struct pen_block_scratch *b)
{
    for (int g = 0; g < block_groups(b); g++) {
        const struct path *path[LANES];
        const int first = g * LANES, count = block_group_paths(b, g, path);
        surface_at(&b->surface[g], input->scene, path, count);
        const unsigned finite = lane_mask_bits(b->surface[g].finite);
        for (int i = 0; i < count; i++)
            if (!(finite >> i & 1))
                block_leave(b, b->wave[first + i]);
    }
}

static ALWAYS_INLINE void block_set_transmittance(struct pen_block_scratch *b, int point,
                                                  struct pen_vec3 t)
{
    b->transmittance[0][point] = t.x;
    b->transmittance[1][point] = t.y;
    b->transmittance[2][point] = t.z;
}

/* Adds the shadow rays from a group of points to the packet. */
static ALWAYS_INLINE void block_add_shadow_rays(const struct pen_kernel_input *input,
                                                struct pen_block_scratch *b, int g, unsigned points,
                                                const unsigned fx)
{
    struct pen_ray_packet *packet = &b->packet;
    const struct arriving_light *arriving = &b->arriving[g];
    const struct surface *s = &b->surface[g];
    const int first = g * LANES;
    struct pen_ray *ray[LANES];
    for (int i = 0; i < LANES; i++)
        ray[i] = &b->shadow_ray[first + i];
    const unsigned made = lane_mask_bits(lanes_ray_make(ray, s->p, arriving->to_light));
    for (; points; points &= points - 1) {
        const int i = __builtin_ctz(points), k = packet->count;
        b->counts[b->wave[first + i]->pixel].shadow++;
        if (!(made >> i & 1)) {
            block_set_transmittance(b, first + i, no_sample());
            continue;
        }
        shadow_query(input, &b->query[first + i], arriving->to_point, fx);
        packet->ray[k] = ray[i];
        packet->origin[k] = &s->origin[i];
        packet->query[k] = &b->query[first + i];
        b->of_packet[packet->count++] = first + i;
    }
}

/* Transmittances of the shadow rays from points of the wave to one hard light. */
static ALWAYS_INLINE void block_hard_shadows(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_block_scratch *b, uint32_t light,
                                             uint64_t points, const unsigned fx)
{
    struct pen_ray_packet *packet = &b->packet;
    packet->count = 0;
    packet->light = input->scene->lights[light].position;
    packet->last_occluder = scratch->last_occluder[light];
    for (int g = 0; g < block_groups(b); g++)
        if (group_bits(points, g))
            block_add_shadow_rays(input, b, g, group_bits(points, g), fx);
    const uint64_t blocked = input->trace->shadow_packet(input->scene->accel, packet);
    scratch->last_occluder[light] = packet->last_occluder;
    for (int k = 0; k < packet->count; k++) {
        const struct pen_vec3 white = {1, 1, 1};
        struct pen_vec3 t = {0, 0, 0};
        if (!(blocked >> k & 1))
            t = shadow_colour(input, packet->ray[k], packet->origin[k], packet->query[k], white,
                              fx);
        block_set_transmittance(b, b->of_packet[k], t);
    }
}

/* The same for a light with a radius, point by point. */
static ALWAYS_INLINE void block_soft_shadows(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_block_scratch *b, uint64_t points,
                                             const unsigned fx)
{
    for (; points; points &= points - 1) {
        const int i = __builtin_ctzll(points), pixel = b->wave[i]->pixel, g = i / LANES;
        scratch->key.x = (uint32_t)b->x[pixel];
        scratch->key.y = (uint32_t)b->y[pixel];
        scratch->key.node = b->wave[i]->path.node;
        block_set_transmittance(b, i,
                                soft_transmittance(input, scratch, &b->surface[g], i % LANES,
                                                   &b->arriving[g], &b->counts[pixel], fx));
    }
}

/* Multiplies what arrives at a group of points by its transmittance. */
static ALWAYS_INLINE void block_filter(struct pen_block_scratch *b, int g)
{
    struct arriving_light *arriving = &b->arriving[g];
    const struct lanes3 t = {lanes_load(b->transmittance[0] + g * LANES),
                             lanes_load(b->transmittance[1] + g * LANES),
                             lanes_load(b->transmittance[2] + g * LANES)};
    arriving->arrives &= lane_mask_not(lanes_black(t));
    arriving->term = lanes3_mul(arriving->term, t);
}

/* Adds what one light brings to the wave's points. */
static ALWAYS_INLINE void block_light(const struct pen_kernel_input *input,
                                      struct pen_kernel_scratch *scratch,
                                      struct pen_block_scratch *b, uint32_t light,
                                      const unsigned fx)
{
    const struct pen_light *l = &input->scene->lights[light];
    const bool shadows = (fx & PEN_FX_HARD_SHADOWS) && l->shadows;
    uint64_t points = 0;
    for (int g = 0; g < block_groups(b); g++) {
        light_unshadowed(&b->arriving[g], l, &b->surface[g], b->lit[g], fx);
        b->arriving[g].light = light;
        points |= (uint64_t)lane_mask_bits(b->arriving[g].arrives) << (g * LANES);
    }
    if (shadows && points) {
        if ((fx & PEN_FX_SOFT_SHADOWS) && l->soft)
            block_soft_shadows(input, scratch, b, points, fx);
        else
            block_hard_shadows(input, scratch, b, light, points, fx);
    }
    for (int g = 0; g < block_groups(b); g++) {
        if (!group_bits(points, g))
            continue;
        if (shadows)
            block_filter(b, g);
        b->radiance[g] =
            lanes3_select(b->arriving[g].arrives, lanes3_add(b->radiance[g], b->arriving[g].term),
                          b->radiance[g]);
    }
}

/* The radiance of the wave's points, as shade_surface of the pixel kernel. */
static ALWAYS_INLINE void block_shade(const struct pen_kernel_input *input,
                                      struct pen_kernel_scratch *scratch,
                                      struct pen_block_scratch *b, const unsigned fx)
{
    bool any = false;
    for (int g = 0; g < block_groups(b); g++) {
        const bool primary = b->wave[g * LANES]->path.depth == 0; /* as all of the wave */
        b->radiance[g] = light_emitted(input->scene, &b->surface[g], primary, fx);
        b->lit[g] = surface_lit(&b->surface[g]);
        any |= lane_mask_bits(b->lit[g]) != 0;
    }
    for (uint32_t light = 0; light < input->scene->light_count && any; light++)
        block_light(input, scratch, b, light, fx);
}

/* Puts a path, which is in the pool, on a stack with a new record, its number in *link. The pixel
 * is left if there is no room. */
static ALWAYS_INLINE void block_push(struct pen_block_scratch *b, struct block_stack *stack,
                                     struct block_path *path, int32_t *link)
{
    const int32_t record = block_record_new(b, path->pixel);
    if (record == NO_RECORD) {
        block_leave(b, path);
        stack_push(&b->unused, b, path);
        return;
    }
    *link = path->record = record;
    stack_push(stack, b, path);
}

/* Puts the reflected paths of a group of points on their stack. Those of pixels without room for
 * one are left. */
static ALWAYS_INLINE void block_reflect(const struct pen_kernel_input *input,
                                        struct pen_block_scratch *b, int g, unsigned points,
                                        const struct path *const *path, const unsigned fx)
{
    struct block_path *const *at = &b->wave[g * LANES];
    struct block_path *made[LANES];
    struct path *reflected[LANES];
    for (int i = 0; i < LANES; i++) {
        if (!(points >> i & 1))
            continue;
        made[i] = block_path_new(b);
        if (!made[i]) {
            block_leave(b, at[i]);
            points &= ~(1u << i);
            continue;
        }
        made[i]->pixel = at[i]->pixel;
        reflected[i] = &made[i]->path;
    }
    points = paths_reflect(input, &b->surface[g], points, path, reflected, fx);
    for (; points; points &= points - 1) {
        const int i = __builtin_ctz(points);
        b->counts[at[i]->pixel].reflection++;
        block_push(b, &b->reflected, made[i], &b->record[at[i]->record].reflected);
    }
}

/* Continues a path through the surface, or ends it. */
static ALWAYS_INLINE void block_transmit(const struct pen_kernel_input *input,
                                         struct pen_block_scratch *b, struct block_path *at,
                                         const struct surface *s, int lane, bool deeper,
                                         const unsigned fx)
{
    if ((fx & PEN_FX_TRANSMISSION) && deeper && !(b->left >> at->pixel & 1) &&
        path_transmit(input, &at->path, s, lane, fx)) {
        b->counts[at->pixel].transmission++;
        block_push(b, &b->transmitted, at, &b->record[at->record].transmitted);
    } else {
        stack_push(&b->unused, b, at);
    }
}

/* Records the radiance of a group of points and puts their paths on the stacks. */
static ALWAYS_INLINE void block_continue(const struct pen_kernel_input *input,
                                         struct pen_block_scratch *b, int g, const unsigned fx)
{
    const struct surface *s = &b->surface[g];
    const struct path *path[LANES];
    struct pen_vec3 radiance[LANES];
    const int first = g * LANES, count = block_group_paths(b, g, path);
    unsigned deeper = 0;
    lanes3_store(radiance, b->radiance[g]);
    for (int i = 0; i < count; i++) {
        const struct block_path *at = b->wave[first + i];
        b->record[at->record].radiance = pen_mul(path[i]->weight, radiance[i]);
        deeper |= (unsigned)(path[i]->depth + 1 < input->settings->max_depth &&
                             !(b->left >> at->pixel & 1))
                  << i;
    }
    if (fx & PEN_FX_MIRROR) {
        const unsigned points = deeper & paths_reflected(input, s, path, count);
        if (points)
            block_reflect(input, b, g, points, path, fx);
    }
    for (int i = 0; i < count; i++)
        block_transmit(input, b, b->wave[first + i], s, i, deeper >> i & 1, fx);
}

/* Renders the wave. */
static ALWAYS_INLINE void block_wave(const struct pen_kernel_input *input,
                                     struct pen_kernel_scratch *scratch,
                                     struct pen_block_scratch *b, const unsigned fx)
{
    block_trace(input, b);
    block_surfaces(input, b);
    block_shade(input, scratch, b, fx);
    for (int g = 0; g < block_groups(b); g++)
        block_continue(input, b, g, fx);
}

/* Adds up a tree of records in the pixel kernel's order: depth first, the transmitted path before
 * the reflected one. */
static inline struct pen_vec3 block_sum(const struct pen_block_scratch *b, int32_t record,
                                        struct pen_vec3 sum)
{
    while (record != NO_RECORD) {
        const struct block_record *r = &b->record[record];
        sum = pen_add(sum, r->radiance);
        if (r->transmitted != NO_RECORD && r->reflected != NO_RECORD)
            sum = block_sum(b, r->transmitted, sum);
        else if (r->transmitted != NO_RECORD) {
            record = r->transmitted;
            continue;
        }
        record = r->reflected;
    }
    return sum;
}

/* Puts the path of a camera ray, which is made, into the wave. */
static ALWAYS_INLINE void block_begin_path(struct pen_block_scratch *b, struct block_path *wave,
                                           int pixel, int32_t record)
{
    wave->path.origin = pen_origin_none;
    wave->path.after = pen_after_start;
    wave->path.weight = pen_vec3(1, 1, 1);
    wave->path.depth = 0;
    wave->path.node = 1;
    wave->record = record;
    wave->pixel = (uint8_t)pixel;
    b->wave[b->count++] = wave;
}

/* The camera rays through points of the block's pixels. The first paths of the pool are theirs, in
 * whole groups of LANES. */
static ALWAYS_INLINE void block_camera_rays(const struct pen_kernel_input *input,
                                            struct pen_block_scratch *b,
                                            const struct block_points *at, int pixels)
{
    b->count = b->record_count = 0;
    b->transmitted.count = b->reflected.count = b->unused.count = 0;
    b->used = BLOCK_PIXELS;
    for (int first = 0; first < pixels; first += LANES) {
        struct pen_ray *ray[LANES];
        for (int i = 0; i < LANES; i++)
            ray[i] = &b->pool[first + i].path.ray;
        const unsigned made = lane_mask_bits(camera_rays(&input->pinhole, lanes_load(at->x + first),
                                                         lanes_load(at->y + first), ray));
        for (int i = first; i < first + LANES && i < pixels; i++) {
            const int32_t record = block_record_new(b, i); /* number i */
            if (made >> (i - first) & 1)
                block_begin_path(b, &b->pool[i], i, record);
            else
                b->left |= UINT64_C(1) << i;
        }
    }
}

/* One sample of every pixel: its radiance in c. Those that are left are rendered by `alone`. */
static ALWAYS_INLINE void block_samples(const struct pen_kernel_input *input,
                                        struct pen_kernel_scratch *scratch,
                                        const struct block_points *at, int pixels,
                                        struct pen_vec3 *c, struct pen_ray_counts *counts,
                                        pen_kernel_sample_fn *alone, const unsigned fx)
{
    struct pen_block_scratch *b = scratch->block;
    const struct pen_ray_counts none = {0, 0, 0, 0, 0, 0};
    b->left = 0;
    for (int i = 0; i < pixels; i++) {
        b->counts[i] = none;
        b->surfaces[i] = 0;
    }
    block_camera_rays(input, b, at, pixels);
    block_wave(input, scratch, b, fx);
    while (b->transmitted.count > 0 || b->reflected.count > 0) {
        block_take(b, b->transmitted.count > 0 ? &b->transmitted : &b->reflected);
        block_wave(input, scratch, b, fx);
    }
    for (int i = 0; i < pixels; i++) {
        if (b->left >> i & 1) {
            scratch->key.x = (uint32_t)b->x[i];
            scratch->key.y = (uint32_t)b->y[i];
            c[i] = alone(input, scratch, (struct pen_point2){at->x[i], at->y[i]}, counts);
            continue;
        }
        const struct pen_vec3 zero = {0, 0, 0};
        c[i] = block_sum(b, i, zero);
        pen_ray_counts_add(counts, &b->counts[i]);
    }
}

/* Numbers the pixels along a Z-order curve (Morton, 1966), so that 4 or 16 in sequence are near one
 * another, and so are their rays. */
static ALWAYS_INLINE int block_order(struct pen_block_scratch *b, struct pen_rect rect)
{
    int pixels = 0;
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const int x = (i & 1) | (i >> 1 & 2) | (i >> 2 & 4);
        const int y = (i >> 1 & 1) | (i >> 2 & 2) | (i >> 3 & 4);
        if (x >= rect.width || y >= rect.height)
            continue;
        b->x[pixels] = rect.x + x;
        b->y[pixels++] = rect.y + y;
    }
    return pixels;
}

/* The pixels of a block, as kernel_pixel; `alone` is the pixel kernel of the same effects. */
static ALWAYS_INLINE void kernel_block(const struct pen_kernel_input *input,
                                       struct pen_kernel_scratch *scratch, struct pen_rect rect,
                                       double (*rgb)[3], struct pen_ray_counts *counts,
                                       pen_kernel_sample_fn *alone, const unsigned fx)
{
    const int samples = fx & PEN_FX_ANTI_ALIASING ? input->settings->samples_per_pixel : 1;
    struct pen_block_scratch *b = scratch->block;
    const int pixels = block_order(b, rect);
    struct pen_vec3 sum[BLOCK_PIXELS], c[BLOCK_PIXELS];
    struct block_points at = {{0}, {0}};
    int kept[BLOCK_PIXELS];
    uint64_t hash[BLOCK_PIXELS];
    struct pen_sample_key key = {.seed = input->settings->seed, .purpose = PEN_PURPOSE_PIXEL};
    for (int i = 0; i < pixels; i++) {
        key.x = (uint32_t)b->x[i];
        key.y = (uint32_t)b->y[i];
        hash[i] = samples > 1 ? pen_sample_hash(&key) : 0;
        sum[i] = pen_vec3(0, 0, 0);
        kept[i] = 0;
    }
    if (fx & PEN_FX_SOFT_SHADOWS) {
        scratch->key = key;
        scratch->key.purpose = PEN_PURPOSE_LIGHT;
    }
    for (int k = 0; k < samples; k++) {
        for (int i = 0; i < pixels; i++) {
            const struct pen_point2 point = pixel_point(hash[i], k, samples);
            at.x[i] = point.x + b->x[i];
            at.y[i] = point.y + b->y[i];
        }
        counts->primary += (uint64_t)pixels;
        if (fx & PEN_FX_SOFT_SHADOWS)
            scratch->key.pixel_sample = (uint32_t)k;
        block_samples(input, scratch, &at, pixels, c, counts, alone, fx);
        for (int i = 0; i < pixels; i++) {
            if (!fits_film(c[i])) {
                counts->dropped_samples++;
                continue;
            }
            sum[i] = pen_add(sum[i], c[i]);
            kept[i]++;
        }
    }
    for (int i = 0; i < pixels; i++) {
        double *out = rgb[(b->y[i] - rect.y) * rect.width + b->x[i] - rect.x];
        out[0] = kept[i] ? sum[i].x / kept[i] : 0;
        out[1] = kept[i] ? sum[i].y / kept[i] : 0;
        out[2] = kept[i] ? sum[i].z / kept[i] : 0;
    }
}

#endif
