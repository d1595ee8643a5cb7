/* SPDX-License-Identifier: MIT */
/* Effects that a scene does not call for cost no ray: neither by the kernels' counters nor by the
 * queries that they make. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/ray_packet.h"
#include "support/isa.h"
#include "support/scene_files.h"
#include "support/suite.h"

/* The queries of a frame, as the accelerator is asked. */
static struct {
    const struct pen_trace_ops *real;
    uint64_t nearest, shadow; /* rays, or packets to a disk */
} asked;

static bool ask_nearest(const struct pen_accel *accel, const struct pen_ray *ray,
                        const struct pen_origin_surface *origin,
                        const struct pen_t_interval *interval, struct pen_hit *hit)
{
    asked.nearest++;
    return asked.real->nearest(accel, ray, origin, interval, hit);
}

static bool ask_shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                       const struct pen_origin_surface *origin, struct pen_shadow *query)
{
    asked.shadow++;
    return asked.real->shadow(accel, ray, origin, query);
}

static uint64_t ask_nearest_packet(const struct pen_accel *accel, struct pen_ray_packet *packet)
{
    asked.nearest += (uint64_t)__builtin_popcountll(packet->live);
    return asked.real->nearest_packet(accel, packet);
}

static uint64_t ask_shadow_packet(const struct pen_accel *accel, struct pen_ray_packet *packet)
{
    asked.shadow += (uint64_t)__builtin_popcountll(packet->live);
    return asked.real->shadow_packet(accel, packet);
}

static enum pen_disk_visibility ask_disk_begin(const struct pen_accel *accel,
                                               struct pen_disk_packet *packet)
{
    asked.shadow++;
    return asked.real->disk_begin(accel, packet);
}

static struct pen_trace_ops asking_ops(enum pen_isa isa)
{
    asked.real = pen_trace_ops_get(isa);
    asked.nearest = asked.shadow = 0;
    struct pen_trace_ops ops = *asked.real;
    ops.nearest = ask_nearest;
    ops.shadow = ask_shadow;
    ops.nearest_packet = ask_nearest_packet;
    ops.shadow_packet = ask_shadow_packet;
    ops.disk_begin = ops.disk_begin ? ask_disk_begin : NULL;
    return ops;
}

/* A frame of which the rays have been counted. */
struct frame {
    const char *path;
    struct pen_ray_counts rays;
    unsigned effects;
    uint64_t pixels;
    bool
        layers; /* the scene may have coincident surfaces, among which one ray asks several times */
};

/* Counters that are 0 without some of these effects. */
struct counter {
    const char *name;
    unsigned effects;
    size_t offset; /* in struct pen_ray_counts */
};

#define SHADOWS (PEN_FX_HARD_SHADOWS | PEN_FX_SOFT_SHADOWS)
#define REFLECTS (PEN_FX_MIRROR | PEN_FX_REFRACTION)
static const struct counter counters[] = {
    {"shadow", SHADOWS, offsetof(struct pen_ray_counts, shadow)},
    {"reflection", REFLECTS, offsetof(struct pen_ray_counts, reflection)},
    {"transmission", PEN_FX_TRANSMISSION, offsetof(struct pen_ray_counts, transmission)},
    {"unmatched_exits", PEN_FX_REFRACTION, offsetof(struct pen_ray_counts, unmatched_exits)},
    {"truncated_paths", REFLECTS, offsetof(struct pen_ray_counts, truncated_paths)},
};
enum { COUNTERS = sizeof counters / sizeof *counters };

/* Sums over all frames, to see that the checks had something to check. */
struct tally {
    int width, frames, bare;
    uint64_t absent[COUNTERS];  /* frames without the effects of the counter */
    uint64_t present[COUNTERS]; /* what the counter counted in the others */
    uint64_t one_sample;
};

static void check_rays(struct tally *tally, const struct frame *f)
{
    const struct pen_ray_counts *rays = &f->rays;
    for (int i = 0; i < COUNTERS; i++) {
        const uint64_t n = *(const uint64_t *)((const char *)rays + counters[i].offset);
        if (f->effects & counters[i].effects) {
            tally->present[i] += n;
            continue;
        }
        tally->absent[i]++;
        ck_assert_msg(n == 0, "%s: %s: %llu with effects %x", f->path, counters[i].name,
                      (unsigned long long)n, f->effects);
    }
    if (!(f->effects & SHADOWS))
        ck_assert_msg(asked.shadow == 0, "%s: %llu shadow queries", f->path,
                      (unsigned long long)asked.shadow);
    if (!(f->effects & PEN_FX_ANTI_ALIASING)) {
        tally->one_sample++;
        ck_assert_msg(rays->primary == f->pixels, "%s: %llu camera rays", f->path,
                      (unsigned long long)rays->primary);
    }
    const uint64_t paths = rays->primary + rays->reflection + rays->transmission;
    if (!f->layers && !(f->effects & (REFLECTS | PEN_FX_TRANSMISSION)))
        ck_assert_msg(asked.nearest == paths, "%s: %llu queries for %llu rays", f->path,
                      (unsigned long long)asked.nearest, (unsigned long long)paths);
}

/* Renders a view by the kernel that is chosen for it, and checks what it traced. */
static void check_view(struct tally *tally, const char *path, const struct pen_scene *scene,
                       int view, const struct pen_settings *settings, enum pen_isa isa)
{
    struct pen_kernel_input input = frame_input(scene, view, settings, isa);
    const struct pen_kernel *kernel = pen_kernel_select(input.effects, isa);
    struct frame f = {.path = path,
                      .effects = input.effects,
                      .pixels = (uint64_t)(settings->width * settings->height),
                      .layers = scene->layer_first != NULL};
    for (int blocks = 0; blocks < 2; blocks++) {
        struct pen_trace_ops ops = asking_ops(isa);
        input.trace = &ops;
        free(blocks ? frame_by_blocks(kernel, &input, &f.rays)
                    : frame_by_pixels(kernel, &input, &f.rays));
        check_rays(tally, &f);
        tally->frames++;
    }
}

static void check_views(struct tally *tally, const char *path, const struct pen_scene_desc *desc,
                        const struct pen_settings *settings)
{
    struct pen_scene *scene = scene_file_freeze(path, desc);
    for (uint32_t view = 0; view < desc->view_count; view++)
        for (int isa = 0; isa < isa_count(); isa++)
            check_view(tally, path, scene, (int)view, settings, (enum pen_isa)isa);
    pen_scene_free(scene);
}

static void check_scene(const char *path, struct pen_scene_desc *desc, void *user)
{
    struct tally *tally = user;
    struct pen_settings settings = desc->settings;
    scene_file_shrink(&settings, tally->width);
    check_views(tally, path, desc, &settings);
    settings.max_depth = 1;
    check_views(tally, path, desc, &settings);
    for (uint32_t i = 0; i < desc->light_count; i++)
        desc->lights[i].shadows = false;
    check_views(tally, path, desc, &settings);
}

/* Checks that every counter was 0 in some frames, and counted in others. */
static void check_tally(const struct tally *tally)
{
    for (int i = 0; i < COUNTERS; i++) {
        ck_assert_msg(tally->absent[i] > 0, "%s: no frame is without", counters[i].name);
        /* No scene here has solids that do not close, or trees that are cut. */
        if (counters[i].offset <= offsetof(struct pen_ray_counts, transmission))
            ck_assert_msg(tally->present[i] > 0, "%s: counts nothing", counters[i].name);
    }
    ck_assert_uint_gt(tally->one_sample, 0);
}

START_TEST(test_rays__absent_effects_trace_none)
{
    const bool full = proof_in_full();
    struct tally tally = {.width = full ? 96 : 16};
    const int scenes = scene_files_each(full, check_scene, &tally);
    check_tally(&tally);
    if (full)
        printf("%d frames of %d scenes: no ray for an absent effect\n", tally.frames, scenes);
}
END_TEST

/* Leaves of a scene its primitives, emission and ambient light. */
static void make_bare(struct pen_scene_desc *desc, struct pen_settings *settings)
{
    desc->light_count = 0;
    desc->has_sky = false;
    for (uint32_t i = 0; i < desc->material_count; i++)
        desc->materials[i].kr = desc->materials[i].kt = pen_vec3(0, 0, 0);
    for (uint32_t i = 0; i < desc->material_count; i++)
        desc->materials[i].patterns = NULL;
    for (uint32_t i = 0; i < desc->view_count; i++)
        desc->views[i].camera.aperture_radius = 0;
    settings->samples_per_pixel = settings->lens_samples = 1;
}

/* Rays in all, by the counters and, but for layers, by the queries: one for each pixel. */
static void check_bare(const char *path, struct pen_scene_desc *desc, void *user)
{
    struct tally *tally = user;
    struct pen_settings settings = desc->settings;
    scene_file_shrink(&settings, tally->width);
    make_bare(desc, &settings);
    struct pen_scene *scene = scene_file_freeze(path, desc);
    const uint64_t pixels = (uint64_t)(settings.width * settings.height);
    for (int isa = 0; isa < isa_count(); isa++) {
        struct pen_kernel_input input = frame_input(scene, 0, &settings, (enum pen_isa)isa);
        const struct pen_kernel *kernel = pen_kernel_select(input.effects, (enum pen_isa)isa);
        struct pen_trace_ops ops = asking_ops((enum pen_isa)isa);
        struct pen_ray_counts rays;
        input.trace = &ops;
        ck_assert_msg((input.effects & ~(unsigned)PEN_FX_AMBIENT) == 0, "%s: effects %x", path,
                      input.effects);
        ck_assert_ptr_eq(kernel, pen_kernel_at(0, (enum pen_isa)isa));
        free(frame_by_blocks(kernel, &input, &rays));
        ck_assert_msg(rays.primary == pixels &&
                          rays.shadow + rays.reflection + rays.transmission == 0,
                      "%s: more rays than pixels", path);
        ck_assert_uint_eq(asked.shadow, 0);
        if (!scene->layer_first) {
            ck_assert_msg(asked.nearest == pixels, "%s: %llu queries for %llu pixels", path,
                          (unsigned long long)asked.nearest, (unsigned long long)pixels);
            tally->bare++;
        }
    }
    pen_scene_free(scene);
}

START_TEST(test_rays__a_bare_scene_traces_one_for_each_pixel)
{
    const bool full = proof_in_full();
    struct tally tally = {.width = full ? 96 : 16};
    const int scenes = scene_files_each(full, check_bare, &tally);
    ck_assert_int_gt(tally.bare, scenes / 2);
    if (full)
        printf("%d scenes made bare: width x height rays\n", scenes);
}
END_TEST

PEN_SUITE("rays", test_rays__absent_effects_trace_none,
          test_rays__a_bare_scene_traces_one_for_each_pixel)
