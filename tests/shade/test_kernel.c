/* SPDX-License-Identifier: MIT */
/* Kernels: every kernel that covers a scene gives the same picture; and how samples make a pixel.
 */
#include <float.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "math/sample.h"
#include "support/isa.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

static int kernels(void)
{
    int n = 0;
    while (pen_kernel_at(n, PEN_ISA_BASE))
        n++;
    return n;
}

static struct pen_kernel_input input_of(const struct pen_scene *scene, enum pen_isa isa)
{
    const struct pen_settings *s = &kit.settings;
    struct pen_kernel_input input = {
        .scene = scene,
        .view = &scene->views[0],
        .settings = s,
        .pinhole = pen_scene_pinhole(scene, 0, s->width, s->height),
        .effects = pen_scene_effects(scene, 0, s),
        .trace = pen_trace_ops_get(isa),
    };
    input.lens = pen_scene_lens(scene, 0, &input.pinhole);
    return input;
}

static const struct pen_pattern tiles = {true, {1, 0.5, 0.25}, {0, 0.25, 0.5},
                                         0.75, {0, 0, 0},      {0, 0, 0}};
static const struct pen_patterns tiled = {
    .of = {[PEN_COLOUR_KD] = &tiles, [PEN_COLOUR_KR] = &tiles}};
static const struct pen_patterns blind = {.of = {[PEN_COLOUR_KT] = &tiles}};

/* A sphere of glass around one of water, and a pyramid of glass that the first sphere enters. */
static void solids(void)
{
    static const struct pen_vec3 v[4] = {{-2, 1, 2}, {-1, 1, 2.5}, {-1.5, 2, 2}, {-1.5, 1.5, 1}};
    struct pen_material m = kit_matte(0.1);
    m.kt = pen_vec3(0.9, 0.8, 0.9);
    m.ks = pen_vec3(0.5, 0.5, 0.5);
    m.ior = 1.5;
    const int glass = kit_material(&kit, m);
    m.ior = 1.33;
    m.reflection_blur = 10;
    m.transmission_blur = 5;
    kit.settings.blur_samples = 3;
    kit_sphere(&kit, pen_vec3(-1, 2, 1), 0.75, glass);
    kit_sphere(&kit, pen_vec3(-1, 2, 1), 0.5, kit_material(&kit, m));
    for (int i = 0; i < 4; i++)
        kit_triangle(&kit, v[i], v[(i + 1) % 4], v[(i + 2) % 4], glass);
}

/* The medley with every effect but anti-aliasing. */
static void medley(void)
{
    kit_medley(&kit);
    solids();
    kit_smooth(&kit, pen_vec3(1.5, -0.25, 3), 1);
    kit.desc.has_sky = true;
    kit.desc.sky = (struct pen_sky){{0.1, 0.2, 0.6}, {0.05, 0.04, 0.03}, {0.125, 1, 0}};
    kit.view.camera.aperture_radius = 0.125;
    kit.view.camera.focus_distance = 8;
    kit.settings.lens_samples = 1;
    kit.materials[0].patterns = kit.materials[3].patterns = &tiled;
    kit.materials[2].patterns = &blind;
}

/* The whole image by one kernel: 3 doubles per pixel. */
static double *image_by(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                        struct pen_ray_counts *rays)
{
    struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(input);
    ck_assert(scratch != NULL);
    int width = kit.settings.width, height = kit.settings.height;
    double *out = calloc((size_t)(3 * width * height), sizeof *out);
    *rays = (struct pen_ray_counts){0};
    for (int i = 0; i < width * height; i++)
        kernel->pixel(input, scratch, i % width, i / width, &out[3 * i], rays);
    pen_kernel_scratch_free(scratch);
    return out;
}

/* Renders the kit's scene by every kernel that covers it, for both instruction sets, and
 * compares bits and counts. Returns how many were compared. */
static int compare_kernels(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_kernel_input input = input_of(scene, PEN_ISA_BASE);
    struct pen_ray_counts want_rays, rays;
    double *want = image_by(pen_kernel_select(input.effects, PEN_ISA_BASE), &input, &want_rays);
    size_t bytes = (size_t)(3 * kit.settings.width * kit.settings.height) * sizeof *want;
    int compared = 0;
    for (int isa = PEN_ISA_BASE; isa < isa_count(); isa++) {
        input.trace = pen_trace_ops_get((enum pen_isa)isa);
        for (int i = 0; i < kernels(); i++) {
            const struct pen_kernel *kernel = pen_kernel_at(i, (enum pen_isa)isa);
            if (input.effects & ~kernel->effects)
                continue;
            double *got = image_by(kernel, &input, &rays);
            ck_assert_msg(memcmp(got, want, bytes) == 0, "%s differs", kernel->name);
            ck_assert_msg(memcmp(&rays, &want_rays, sizeof rays) == 0, "%s: rays", kernel->name);
            free(got);
            compared++;
        }
    }
    free(want);
    pen_scene_free(scene);
    return compared;
}

/* Takes effects out of the medley, as the API's `effects` defines it. */
static void leave_out(unsigned effects)
{
    if (effects & PEN_FX_AMBIENT)
        kit.desc.ambient = pen_vec3(0, 0, 0);
    if (effects & PEN_FX_SKY)
        kit.desc.has_sky = false;
    if (effects & PEN_FX_DEPTH_OF_FIELD)
        kit.view.camera.aperture_radius = 0;
    if (effects & PEN_FX_SMOOTH_NORMALS)
        kit.meshes[0].normal = NULL;
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        if ((effects & PEN_FX_HARD_SHADOWS) && !pen_light_desc_soft(&kit.lights[i]))
            kit.lights[i].shadows = false;
    for (uint32_t i = 0; i < kit.desc.light_count; i++)
        if (effects & PEN_FX_SOFT_SHADOWS) {
            kit.lights[i].shadows = kit.lights[i].shadows && !(effects & PEN_FX_HARD_SHADOWS);
            kit.lights[i].radius = kit.lights[i].angular_radius = 0;
        }
    for (uint32_t i = 0; i < kit.desc.material_count; i++) {
        if (effects & (PEN_FX_PATTERNS |
                       (kit.materials[i].patterns == &tiled ? PEN_FX_MIRROR : PEN_FX_TRANSMISSION)))
            kit.materials[i].patterns = NULL;
        if (effects & PEN_FX_MIRROR)
            kit.materials[i].kr = pen_vec3(0, 0, 0);
        if (effects & PEN_FX_TRANSMISSION)
            kit.materials[i].kt = pen_vec3(0, 0, 0);
        if (effects & PEN_FX_SPECULAR)
            kit.materials[i].ks = pen_vec3(0, 0, 0);
        if (effects & PEN_FX_REFRACTION)
            kit.materials[i].ior = 1;
        if (effects & PEN_FX_GLOSSY)
            kit.materials[i].reflection_blur = 0;
        if (effects & PEN_FX_FROSTED)
            kit.materials[i].transmission_blur = 0;
    }
}

/* Sets of at most two effects that can be left out, and of all but at most two; or of one, unless
 * all cases are asked for, since tests/effects/test_masks.c leaves out effects as well. */
static bool few_or_nearly_all(unsigned effects)
{
    const int count = __builtin_popcount(effects);
    return random_all() ? count <= 2 || count >= PEN_FX_COUNT - 4
                        : count <= 1 || count >= PEN_FX_COUNT - 3;
}

START_TEST(test_kernel__every_kernel_gives_the_same_bits)
{
    int compared = 0;
    for (unsigned out = 0; out < 1u << PEN_FX_COUNT; out++) {
        if (out & (PEN_FX_SHADOW_TRANSMITTANCE | PEN_FX_ANTI_ALIASING))
            continue;
        if (!few_or_nearly_all(out))
            continue;
        for (int samples = 1; samples <= 3; samples += 2) {
            medley();
            leave_out(out);
            kit.settings.samples_per_pixel = samples;
            if (!random_all()) { /* the same picture, with larger pixels */
                kit.settings.width = 24;
                kit.settings.height = 18;
            }
            kit.settings.height = random_cases(kit.settings.height);
            compared += compare_kernels();
        }
    }
    ck_assert_int_gt(compared, 100);
}
END_TEST

/* Trees of paths that are cut, with and without lights, and next to them a long path that is not.
 */
START_TEST(test_kernel__every_kernel_cuts_the_same_paths)
{
    for (int i = 0; i < 4; i++) {
        struct pen_material m = kit_matte(i & 1 ? 0.5 : 0);
        struct pen_ray_counts rays;
        kit_init(&kit);
        kit.settings.width = kit.settings.height = 3;
        kit.settings.min_contribution = 0;
        kit.settings.max_depth = i & 2 ? 3000 : 40;
        kit.desc.background = pen_vec3(0.1, 0.2, 0.3);
        kit_plane(&kit, pen_vec3(0, 0, -3), pen_vec3(0, 0, 1), kit_material(&kit, m));
        m.kr = pen_vec3(1, 1, 1);
        kit_plane(&kit, pen_vec3(0, 0, -2), pen_vec3(0.1, 0, 1), kit_material(&kit, m));
        kit_plane(&kit, pen_vec3(0, 0, 20), pen_vec3(0, 0.1, 1), kit_material(&kit, m));
        m.kt = pen_vec3(1, 1, 1);
        kit_sphere(&kit, pen_vec3(0, 0, 0), 0.5, kit_material(&kit, m));
        kit_point(&kit, pen_vec3(3, 4, 20), pen_vec3(1, 1, 1))->shadows = i & 1;
        ck_assert_int_gt(compare_kernels(), 1);
        kit_pixel(&kit, 1, 1, &rays);
        ck_assert_uint_gt(rays.truncated_paths, 0);
    }
}
END_TEST

START_TEST(test_kernel__select_takes_the_smallest)
{
    for (int isa = PEN_ISA_BASE; isa < PEN_ISA_COUNT; isa++)
        for (unsigned fx = 0; fx < 1u << PEN_FX_COUNT; fx++) {
            const struct pen_kernel *kernel = pen_kernel_select(fx, (enum pen_isa)isa);
            ck_assert_uint_eq(fx & ~kernel->effects, 0);
            for (int i = 0; i < kernels(); i++) {
                const struct pen_kernel *other = pen_kernel_at(i, (enum pen_isa)isa);
                if ((fx & ~other->effects) == 0)
                    ck_assert_int_le(__builtin_popcount(kernel->effects),
                                     __builtin_popcount(other->effects));
            }
            ck_assert(strstr(kernel->name, pen_isa_name((enum pen_isa)isa)) != NULL);
        }
    ck_assert(pen_kernel_at(-1, PEN_ISA_BASE) == NULL);
    ck_assert(pen_kernel_at(kernels(), PEN_ISA_AVX2) == NULL);
}
END_TEST

/* Statistics show the names, so that reports compare with those of earlier versions. */
START_TEST(test_kernel__names_stay_as_statistics_show_them)
{
    static const char *const name[] = {"lit",
                                       "hard",
                                       "hard+mirror",
                                       "hard+glass",
                                       "hard+glass+mirror",
                                       "hard+smooth",
                                       "hard+all",
                                       "hard+sky",
                                       "hard+patterns",
                                       "hard+patterns+lens+sky",
                                       "hard+lens+sky",
                                       "hard+glass+mirror+sky",
                                       "hard+glass+mirror+lens",
                                       "hard+glass+mirror+patterns+sky",
                                       "hard+refraction+sky",
                                       "hard+refraction",
                                       "hard+mirror+lens+sky",
                                       "hard+refraction+blur",
                                       "hard+smooth+normals",
                                       "soft",
                                       "soft+mirror",
                                       "soft+glass",
                                       "soft+glass+mirror",
                                       "soft+smooth",
                                       "soft+all",
                                       "soft+sky",
                                       "soft+patterns",
                                       "soft+patterns+lens+sky",
                                       "soft+lens+sky",
                                       "soft+glass+mirror+patterns",
                                       "soft+glass+mirror+lens",
                                       "all"};
    for (int isa = 0; isa < PEN_ISA_COUNT; isa++)
        for (size_t i = 0; i < sizeof name / sizeof *name; i++) {
            char want[64];
            snprintf(want, sizeof want, "%s/%s", name[i], pen_isa_name((enum pen_isa)isa));
            ck_assert_str_eq(pen_kernel_at((int)i, (enum pen_isa)isa)->name, want);
        }
    ck_assert_str_eq(pen_kernel_select(0, PEN_ISA_BASE)->name, "lit/base");
    ck_assert_str_eq(pen_kernel_select((1u << PEN_FX_COUNT) - 1, PEN_ISA_AVX2)->name, "all/avx2");
}
END_TEST

static unsigned effects_of_medley(unsigned out)
{
    medley();
    leave_out(out);
    struct pen_scene *scene = kit_freeze(&kit);
    unsigned effects = pen_scene_effects(scene, 0, &kit.settings);
    pen_scene_free(scene);
    return effects;
}

START_TEST(test_kernel__effects_follow_the_scene)
{
    const unsigned all = (1u << PEN_FX_COUNT) - 1 - PEN_FX_ANTI_ALIASING;
    ck_assert_uint_eq(effects_of_medley(0), all);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_AMBIENT), all & ~(unsigned)PEN_FX_AMBIENT);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_MIRROR), all & ~(unsigned)PEN_FX_MIRROR);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_SPECULAR), all & ~(unsigned)PEN_FX_SPECULAR);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_SKY), all & ~(unsigned)PEN_FX_SKY);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_DEPTH_OF_FIELD),
                      all & ~(unsigned)PEN_FX_DEPTH_OF_FIELD);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_PATTERNS), all & ~(unsigned)PEN_FX_PATTERNS);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_REFRACTION),
                      all & ~(unsigned)(PEN_FX_REFRACTION | PEN_FX_GLOSSY));
    ck_assert_uint_eq(effects_of_medley(PEN_FX_GLOSSY), all & ~(unsigned)PEN_FX_GLOSSY);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_FROSTED), all & ~(unsigned)PEN_FX_FROSTED);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_SMOOTH_NORMALS),
                      all & ~(unsigned)PEN_FX_SMOOTH_NORMALS);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_TRANSMISSION),
                      all & ~(unsigned)(PEN_FX_TRANSMISSION | PEN_FX_SHADOW_TRANSMITTANCE |
                                        PEN_FX_REFRACTION | PEN_FX_GLOSSY | PEN_FX_FROSTED));
    ck_assert_uint_eq(effects_of_medley(PEN_FX_HARD_SHADOWS), all & ~(unsigned)PEN_FX_HARD_SHADOWS);
    ck_assert_uint_eq(effects_of_medley(PEN_FX_SOFT_SHADOWS), all & ~(unsigned)PEN_FX_SOFT_SHADOWS);
    ck_assert_uint_eq(
        effects_of_medley(PEN_FX_HARD_SHADOWS | PEN_FX_SOFT_SHADOWS),
        all & ~(unsigned)(PEN_FX_HARD_SHADOWS | PEN_FX_SOFT_SHADOWS | PEN_FX_SHADOW_TRANSMITTANCE));
}
END_TEST

START_TEST(test_kernel__effects_need_a_primitive_that_shows_them)
{
    kit_init(&kit);
    struct pen_material m = kit_matte(0.5);
    m.kr = pen_vec3(0, 1e-9, 0);
    kit_material(&kit, m); /* no primitive has it */
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, -1);
    kit_point(&kit, pen_vec3(0, 5, 5), pen_vec3(1, 1, 1));
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings), 0);
    pen_scene_free(scene);
    kit.objects[0].material = 0;
    scene = kit_freeze(&kit);
    ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings), PEN_FX_HARD_SHADOWS);
    kit.settings.min_contribution = 0;
    ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings),
                      PEN_FX_MIRROR | PEN_FX_HARD_SHADOWS);
    kit.settings.max_depth = 1;
    kit.settings.samples_per_pixel = 2;
    ck_assert_uint_eq(pen_scene_effects(scene, 0, &kit.settings),
                      PEN_FX_ANTI_ALIASING | PEN_FX_HARD_SHADOWS);
    pen_scene_free(scene);
}
END_TEST

/* The name of the kernel that renders a grey matte sphere that reflects kr. */
static const char *kernel_of_kr(double kr, double min_contribution)
{
    kit_init(&kit);
    struct pen_material m = kit_matte(0.5);
    m.kr = pen_vec3(kr, kr, kr);
    kit_sphere(&kit, pen_vec3(0, 0, 0), 1, kit_material(&kit, m));
    kit_point(&kit, pen_vec3(0, 5, 5), pen_vec3(1, 1, 1));
    kit.settings.min_contribution = min_contribution;
    struct pen_scene *scene = kit_freeze(&kit);
    const unsigned effects = pen_scene_effects(scene, 0, &kit.settings);
    pen_scene_free(scene);
    return pen_kernel_select(effects, PEN_ISA_BASE)->name;
}

START_TEST(test_kernel__a_weak_mirror_is_none_unless_its_rays_are_traced)
{
    const double least = pen_settings_default().min_contribution;
    ck_assert_str_eq(kernel_of_kr(0, 0), "hard/base");
    ck_assert_str_eq(kernel_of_kr(1e-9, 0), "hard+mirror/base");
    ck_assert_str_eq(kernel_of_kr(1e-9, least), "hard/base");
    ck_assert_str_eq(kernel_of_kr(least, least), "hard+mirror/base");
}
END_TEST

/* The medley with factors of secondary rays about `least`. */
static void weak_medley(struct random *random, double least)
{
    medley();
    if (random_below(random, 2))
        leave_out(1u << random_below(random, PEN_FX_COUNT));
    for (uint32_t i = 0; i < kit.desc.material_count; i++) {
        struct pen_material *m = &kit.materials[i];
        if (m->patterns && random_below(random, 4))
            m->patterns = NULL;
        if (random_below(random, 8))
            m->kr = pen_scale(m->kr, 0.5 * least * (1 + random_below(random, 4)));
        if (random_below(random, 8))
            m->kt = pen_scale(m->kt, 0.5 * least * (1 + random_below(random, 4)));
    }
    kit.settings.width = 20;
    kit.settings.height = 10;
    kit.settings.min_contribution = least;
}

/* The scene's picture is that with all effects that its materials have, however weak. */
static bool same_with_weak_effects(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    struct pen_kernel_input input = input_of(scene, PEN_ISA_BASE);
    const unsigned called_for = input.effects;
    struct pen_settings all = kit.settings;
    struct pen_ray_counts rays;
    all.min_contribution = 0;
    double *got = image_by(pen_kernel_select(called_for, PEN_ISA_BASE), &input, &rays);
    input.effects = pen_scene_effects(scene, 0, &all);
    double *want = image_by(pen_kernel_select(input.effects, PEN_ISA_BASE), &input, &rays);
    const size_t bytes = (size_t)(3 * kit.settings.width * kit.settings.height) * sizeof *want;
    ck_assert_msg(memcmp(got, want, bytes) == 0, "%x instead of %x", called_for, input.effects);
    free(got);
    free(want);
    pen_scene_free(scene);
    return called_for != input.effects;
}

START_TEST(test_kernel__leaving_out_weak_effects_changes_no_bit)
{
    static const double least[] = {0.001, 0.1, 0.5};
    struct random random = random_begin(33);
    int fewer = 0;
    for (int i = 0; i < random_cases(120); i++) {
        weak_medley(&random, least[i % 3]);
        fewer += same_with_weak_effects();
    }
    ck_assert_int_gt(fewer, random_cases(120) / 10);
}
END_TEST

/* A half-plane x >= 0.25 of light fills part of pixel (1, 0) of a 4 x 2 image whose plane is at
 * the screen: the mean counts the points of the set that fall on it. */
static void half_lit(double emission)
{
    kit_init(&kit);
    kit.settings.width = 4;
    kit.settings.height = 2;
    kit.view.camera.has_view_plane = true;
    kit.view.camera.plane_distance = 10;
    kit.view.camera.plane_width = 4;
    kit.view.camera.plane_height = 2;
    const struct pen_vec3 v[] = {{-0.625, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-0.625, 9, 0}};
    kit_polygon(&kit, v, 4, kit_material(&kit, kit_glow(emission, emission, emission)));
    kit.desc.background = pen_vec3(1, 1, 1);
}

static int points_on_light(int samples)
{
    struct pen_sample_key key = {
        .seed = kit.settings.seed, .x = 1, .y = 0, .purpose = PEN_PURPOSE_PIXEL};
    uint64_t hash = pen_sample_hash(&key);
    int n = 0;
    for (int i = 0; i < samples; i++)
        n += pen_sobol2(hash, (uint32_t)i).x >= 0.375;
    return n;
}

START_TEST(test_kernel__samples_are_the_sets_of_the_pixel)
{
    int different = 0;
    for (int samples = 2; samples <= 40; samples += 3)
        for (uint64_t seed = 0; seed < 3; seed++) {
            half_lit(3);
            kit.settings.samples_per_pixel = samples;
            kit.settings.seed = seed;
            int lit = points_on_light(samples);
            struct pen_ray_counts rays;
            struct pen_vec3 got = kit_pixel(&kit, 1, 0, &rays);
            ck_assert(got.x == (3.0 * lit + (samples - lit)) / samples);
            ck_assert_uint_eq(rays.primary, (uint64_t)samples);
            kit.settings.seed = 77;
            different += kit_pixel(&kit, 1, 0, NULL).x != got.x;
        }
    ck_assert_int_gt(different, 0);
}
END_TEST

START_TEST(test_kernel__one_sample_is_the_centre)
{
    half_lit(3);
    ck_assert(kit_pixel(&kit, 1, 0, NULL).x == 3); /* -0.5 is lit, -0.625 the border */
    const struct pen_vec3 v[] = {{-0.4375, -9, 0}, {9, -9, 0}, {9, 9, 0}, {-0.4375, 9, 0}};
    memcpy(kit.vertices, v, sizeof v);
    ck_assert(kit_pixel(&kit, 1, 0, NULL).x == 1);
}
END_TEST

START_TEST(test_kernel__samples_beyond_the_film_are_left_out)
{
    const int samples = 16;
    half_lit(1e39);
    kit.settings.samples_per_pixel = samples;
    uint64_t lit = (uint64_t)points_on_light(samples);
    ck_assert_uint_gt(lit, 0);
    struct pen_ray_counts rays;
    ck_assert(kit_pixel(&kit, 1, 0, &rays).x == 1);
    ck_assert_uint_eq(rays.dropped_samples, lit);
    ck_assert(kit_pixel(&kit, 3, 0, &rays).x == 0); /* none is left */
    ck_assert_uint_eq(rays.dropped_samples, (uint64_t)samples);
    half_lit(FLT_MAX);
    kit.settings.samples_per_pixel = samples;
    ck_assert(kit_pixel(&kit, 3, 0, &rays).x == (double)FLT_MAX);
    ck_assert_uint_eq(rays.dropped_samples, 0);
}
END_TEST

/* Counts the queries of kernels, and answers those of `nearest` with a fault. */
struct fault {
    const struct pen_trace_ops *real;
    uint64_t nearest, shadow; /* numbers of queries */
    bool strike;
    double t; /* the t that the fault gives an intersection */
};

static struct fault fault;

static bool faulty_nearest(const struct pen_accel *accel, const struct pen_ray *ray,
                           const struct pen_origin_surface *origin,
                           const struct pen_t_interval *interval, struct pen_hit *hit)
{
    fault.nearest++;
    bool found = fault.real->nearest(accel, ray, origin, interval, hit);
    if (found && fault.strike)
        hit->t = fault.t;
    return found;
}

static bool faulty_shadow(const struct pen_accel *accel, const struct pen_ray *ray,
                          const struct pen_origin_surface *origin, struct pen_shadow *query)
{
    fault.shadow++;
    return fault.real->shadow(accel, ray, origin, query);
}

static enum pen_disk_visibility faulty_disk_begin(const struct pen_accel *accel,
                                                  struct pen_disk_packet *packet)
{
    fault.shadow++;
    return fault.real->disk_begin(accel, packet);
}

static struct pen_trace_ops faulty_ops(enum pen_isa isa)
{
    fault = (struct fault){.real = pen_trace_ops_get(isa)};
    struct pen_trace_ops ops = *fault.real;
    ops.nearest = faulty_nearest;
    ops.shadow = faulty_shadow;
    ops.disk_begin = ops.disk_begin ? faulty_disk_begin : NULL;
    return ops;
}

/* Renders the frame by every kernel that covers it. All samples must be black and counted, with
 * `queries` calls of `nearest` for each of them and none of `shadow`. */
static void check_dropped(struct pen_kernel_input *input, enum pen_isa isa, uint64_t queries)
{
    const struct pen_settings *s = &kit.settings;
    uint64_t samples = (uint64_t)(s->width * s->height * s->samples_per_pixel);
    for (int k = 0; k < kernels(); k++) {
        const struct pen_kernel *kernel = pen_kernel_at(k, isa);
        struct pen_ray_counts rays;
        if (input->effects & ~kernel->effects)
            continue;
        fault.nearest = fault.shadow = 0;
        double *rgb = image_by(kernel, input, &rays);
        for (int i = 0; i < 3 * s->width * s->height; i++)
            ck_assert_msg(rgb[i] == 0, "%s: %g", kernel->name, rgb[i]);
        free(rgb);
        ck_assert_uint_eq(rays.dropped_samples, samples);
        ck_assert_uint_eq(rays.primary, samples);
        ck_assert_uint_eq(rays.shadow + rays.reflection + rays.transmission, 0);
        ck_assert_uint_eq(fault.nearest, queries * samples);
        ck_assert_uint_eq(fault.shadow, 0);
    }
}

/* H088: camera rays that are not finite are refused before anything is traced: a frame of them
 * makes no query. */
START_TEST(test_kernel__h088_rays_that_are_none_are_refused_and_counted)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY, 1e200};
    kit_medley(&kit);
    kit.settings.samples_per_pixel = 2;
    kit.settings.width = kit.settings.height = 3;
    struct pen_scene *scene = kit_freeze(&kit);
    for (int isa = PEN_ISA_BASE; isa < isa_count(); isa++) {
        struct pen_trace_ops ops = faulty_ops((enum pen_isa)isa);
        for (int i = 0; i < 4 * 6; i++) {
            struct pen_kernel_input input = input_of(scene, (enum pen_isa)isa);
            struct pen_pinhole *p = &input.pinhole;
            double *all[] = {&p->eye.x,    &p->eye.y,    &p->eye.z,
                             &p->middle.x, &p->middle.y, &p->middle.z};
            if (i % 6 < 3 && bad[i / 6] == 1e200)
                continue; /* far away, but finite */
            input.trace = &ops;
            *all[i % 6] = bad[i / 6];
            check_dropped(&input, (enum pen_isa)isa, 0);
        }
    }
    pen_scene_free(scene);
}
END_TEST

/* A mirror that fills the picture, lit by lights of every kind or by none. Its colour and its light
 * do not show that a hit point is not finite. */
static void mirror_hall(bool sphere, bool lights)
{
    kit_init(&kit);
    struct pen_material mirror = kit_matte(lights ? 0.5 : 0);
    mirror.kr = mirror.kt = pen_vec3(0.5, 0.5, 0.5);
    int m = kit_material(&kit, mirror);
    if (sphere)
        kit_sphere(&kit, pen_vec3(0, 0, -40), 45, m);
    else
        kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), m);
    kit.settings.width = kit.settings.height = 3;
    if (!lights)
        return;
    kit_point(&kit, pen_vec3(3, 4, 20), pen_vec3(1, 1, 1));
    kit_directional(&kit, pen_vec3(0, -1, -2), pen_vec3(1, 1, 1));
    kit_point(&kit, pen_vec3(-3, 4, 20), pen_vec3(1, 1, 1))->radius = 1;
}

/* H088: from a hit point that is not finite no shadow, reflected or transmitted ray starts; the
 * sample is left out and counted. */
START_TEST(test_kernel__h088_nothing_goes_on_from_a_point_that_is_none)
{
    static const double bad[] = {NAN, INFINITY, -INFINITY};
    for (int i = 0; i < 3 * 4; i++) {
        mirror_hall(i & 1, i & 2);
        struct pen_scene *scene = kit_freeze(&kit);
        for (int isa = PEN_ISA_BASE; isa < isa_count(); isa++) {
            struct pen_trace_ops ops = faulty_ops((enum pen_isa)isa);
            struct pen_kernel_input input = input_of(scene, (enum pen_isa)isa);
            struct pen_ray_counts rays;
            input.trace = &ops;
            const struct pen_kernel *kernel = pen_kernel_select(input.effects, (enum pen_isa)isa);
            free(image_by(kernel, &input, &rays)); /* without the fault all is in order */
            ck_assert_uint_eq(rays.dropped_samples, 0);
            ck_assert_uint_ge(rays.reflection, 9);
            ck_assert((fault.shadow > 0) == ((i & 2) != 0));
            fault.strike = true;
            fault.t = bad[i / 4];
            check_dropped(&input, (enum pen_isa)isa, 1);
        }
        pen_scene_free(scene);
    }
}
END_TEST

PEN_SUITE("kernel", test_kernel__every_kernel_gives_the_same_bits,
          test_kernel__every_kernel_cuts_the_same_paths, test_kernel__select_takes_the_smallest,
          test_kernel__names_stay_as_statistics_show_them, test_kernel__effects_follow_the_scene,
          test_kernel__effects_need_a_primitive_that_shows_them,
          test_kernel__a_weak_mirror_is_none_unless_its_rays_are_traced,
          test_kernel__leaving_out_weak_effects_changes_no_bit,
          test_kernel__samples_are_the_sets_of_the_pixel, test_kernel__one_sample_is_the_centre,
          test_kernel__samples_beyond_the_film_are_left_out,
          test_kernel__h088_rays_that_are_none_are_refused_and_counted,
          test_kernel__h088_nothing_goes_on_from_a_point_that_is_none)
