/* SPDX-License-Identifier: MIT */
/* Whole pictures before and after a change of the scene. The change must not matter, or at most by
 * the rounding of the scene's numbers. The scenes have every kind of primitive and light, glass and
 * mirrors. Their coordinates are dyadic, so that scaling and moving them is exact. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "property/gen.h"
#include "property/oracle.h"
#include "property/rows.h"
#include "support/kit.h"

static struct kit kit;

enum { WIDTH = 24, HEIGHT = 18 };

static vec3 dyadic(struct random *r, int half)
{
    return gen_dyadic3(r, half);
}

static vec3 colour(struct random *r)
{
    return pen_vec3(random_unit(r), random_unit(r), random_unit(r));
}

static int draw_material(struct random *r)
{
    struct pen_material m = pen_material_default();
    m.kd = colour(r);
    m.ks = pen_scale(colour(r), .5);
    m.shininess = random_in(r, 1, 60);
    if (random_below(r, 3) == 0)
        m.kt = pen_scale(colour(r), .8);
    if (random_below(r, 3) == 0)
        m.kr = pen_scale(colour(r), .5);
    return kit_material(&kit, m);
}

static void draw_primitive(struct random *r)
{
    int m = draw_material(r);
    vec3 c = dyadic(r, 3), a = dyadic(r, 1);
    double size = (1 + random_below(r, 16)) / 16.;
    a = pen_norm1(a) > 0 ? a : pen_vec3(0, 1, 0);
    switch (random_below(r, 6)) {
    case 0:
    case 1:
        kit_sphere(&kit, c, size, m);
        break;
    case 2:
        kit_tube(&kit, c, a, .25 * size, m);
        break;
    case 3:
        kit_cylinder(&kit, c, a, .5 * size, 2 * size, m);
        break;
    case 4:
        kit_sheet(&kit, c.z, 1 + size, m);
        break;
    default:
        kit_triangle(&kit, c, pen_add(c, pen_vec3(size, 0, .25)),
                     pen_add(c, pen_vec3(.125, size, 0)), m);
    }
}

static void make_scene(uint64_t seed)
{
    struct random r = {seed * 0x9e3779b97f4a7c15u + 74, 0};
    kit_init(&kit);
    kit.settings.width = WIDTH;
    kit.settings.height = HEIGHT;
    kit.settings.light_samples = 4;
    kit.desc.background = colour(&r);
    kit.desc.ambient = pen_scale(colour(&r), .1);
    kit.view.camera.position = pen_add(pen_vec3(0, 1, 12), dyadic(&r, 1));
    kit.view.camera.direction = pen_vec3(0, -.0625, -1);
    kit_plane(&kit, pen_vec3(0, -3, 0), pen_vec3(0, 1, 0), draw_material(&r));
    for (int i = 0; i < 8; i++)
        draw_primitive(&r);
    kit_point(&kit, pen_add(pen_vec3(3, 6, 6), dyadic(&r, 1)), colour(&r));
    kit_directional(&kit, pen_vec3(1, -2, -1.5), colour(&r));
    kit_spot(&kit, pen_vec3(-4, 5, 4), pen_vec3(4, -5, -5), colour(&r))->radius = .25;
}

static float *picture(void)
{
    struct pen_scene *scene = kit_freeze(&kit);
    float *film = kit_film(scene, &kit.settings, 1);
    pen_scene_free(scene);
    return film;
}

static size_t pixels(void)
{
    return (size_t)kit.settings.width * (size_t)kit.settings.height;
}

/* How many pixels differ by more than `most` in some channel. */
static int differing(const float *a, const float *b, double most)
{
    int count = 0;
    for (size_t i = 0; i < pixels(); i++) {
        double worst = 0;
        for (size_t k = 3 * i; k < 3 * i + 3; k++)
            worst = fmax(worst, fabs((double)a[k] - (double)b[k]));
        count += !(worst <= most);
    }
    return count;
}

/* Root mean square of the differences that are at most `most`. */
static double rmse(const float *a, const float *b, double most)
{
    double sum = 0;
    size_t count = 0;
    for (size_t i = 0; i < 3 * pixels(); i++) {
        double off = (double)a[i] - (double)b[i];
        if (fabs(off) > most)
            continue;
        sum += off * off;
        count++;
    }
    return count ? sqrt(sum / (double)count) : 0;
}

static void draw_one(struct row_draw *d, struct row_case *c, double by)
{
    row_fixed(c, (double)(random_bits(&d->random) >> 40));
    row_fixed(c, by);
}

/* H074, H084: the picture of a scene times 2^k is the same picture. */
static void draw_scaled(struct row_draw *d, struct row_case *c)
{
    static const int often[] = {-200, -40, -20, 20, 40, 200};
    struct random *r = &d->random;
    draw_one(d, c,
             random_below(r, 2) ? often[random_below(r, 6)] : (double)random_below(r, 401) - 200);
}

static void judge_scaled(const struct row_case *c, struct row_verdict *v)
{
    make_scene((uint64_t)c->arg[0]);
    float *want = picture();
    kit_map_points(&kit, kit_times, ldexp(1, (int)c->arg[1]));
    kit_scale_lengths(&kit, ldexp(1, (int)c->arg[1]));
    float *got = picture();
    int count = differing(want, got, 0);
    if (count)
        row_fail(v, "%d pixels differ when scaled by 2^%g", count, c->arg[1]);
    free(want);
    free(got);
}

void rows_picture_scaled(struct pen_row_run *run)
{
    row_each(run, draw_scaled, judge_scaled);
}

/* H076: moved by 2^20 and 2^30. */
static void draw_moved(struct row_draw *d, struct row_case *c)
{
    draw_one(d, c, random_below(&d->random, 2) ? 20 : 30);
}

static void judge_moved(const struct row_case *c, struct row_verdict *v)
{
    make_scene((uint64_t)c->arg[0]);
    float *want = picture();
    kit_map_points(&kit, kit_moved, ldexp(1, (int)c->arg[1]));
    float *got = picture();
    int count = differing(want, got, 0);
    if (count)
        row_fail(v, "%d pixels differ when moved by 2^%g", count, c->arg[1]);
    free(want);
    free(got);
}

void rows_picture_moved(struct pen_row_run *run)
{
    row_each(run, draw_moved, judge_moved);
}

/* H078: the mirrored scene's picture is the mirrored picture, but for rays that meet a border
 * exactly: at most two pixels. Soft lights draw other samples there: they are hard here. */
static void draw_mirrored(struct row_draw *d, struct row_case *c)
{
    draw_one(d, c, -1);
}

static void judge_mirrored(const struct row_case *c, struct row_verdict *v)
{
    make_scene((uint64_t)c->arg[0]);
    kit.lights[2].radius = 0;
    float *want = picture();
    kit_map_points(&kit, kit_mirrored, -1);
    kit_mirror_directions(&kit);
    float *got = picture();
    int count = 0;
    for (int y = 0; y < HEIGHT; y++)
        for (int x = 0; x < WIDTH; x++)
            count += memcmp(&got[3 * (y * WIDTH + x)], &want[3 * (y * WIDTH + WIDTH - 1 - x)],
                            3 * sizeof *got) != 0;
    row_measure(v, "pixels that differ in the mirror, of 432", count, 2);
    free(want);
    free(got);
}

void rows_picture_mirrored(struct pen_row_run *run)
{
    row_each(run, draw_mirrored, judge_mirrored);
}

/* H075: decimal scales, whose rounding moves every number by half an ulp: at most one pixel in a
 * thousand differs, and those are on silhouettes, which is why they are few. */
static void draw_decimal(struct row_draw *d, struct row_case *c)
{
    static const double scale[] = {1e-6, 1e-3, 1e3, 1e9};
    draw_one(d, c, scale[random_below(&d->random, 4)]);
}

static void judge_decimal(const struct row_case *c, struct row_verdict *v)
{
    make_scene((uint64_t)c->arg[0]);
    kit.settings.width = 96;
    kit.settings.height = 72;
    float *want = picture();
    kit_map_points(&kit, kit_times, c->arg[1]);
    kit_scale_lengths(&kit, c->arg[1]);
    float *got = picture();
    row_measure(v, "pixels that differ by 1e-3, of a thousand",
                1000. * differing(want, got, 1e-3) / (double)pixels(), 1);
    free(want);
    free(got);
}

void rows_picture_decimal(struct pen_row_run *run)
{
    row_each(run, draw_decimal, judge_decimal);
}

/* H077: a Cornell box of size 1 moved by 1e6 to 1e9, where coordinates are multiples of
 * ulp(offset): the error is about that over a pixel's size. */
static void make_cornell(struct random *r)
{
    static const double wall[5][4][3] = {{{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}},
                                         {{0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 0, 0}},
                                         {{0, 1, 0}, {1, 1, 0}, {1, 1, 1}, {0, 1, 1}},
                                         {{0, 0, 0}, {0, 1, 0}, {0, 1, 1}, {0, 0, 1}},
                                         {{1, 0, 0}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}}};
    kit_init(&kit);
    kit.settings.width = kit.settings.height = 64;
    kit.view.camera.position = pen_vec3(.5, .5, 2.2);
    kit.view.camera.direction = pen_vec3(random_in(r, -.05, .05), random_in(r, -.05, .05), -1);
    for (int w = 0; w < 5; w++) {
        vec3 p[4];
        struct pen_material m = pen_material_default();
        m.kd = colour(r);
        for (int i = 0; i < 4; i++)
            p[i] = pen_vec3(wall[w][i][0], wall[w][i][1], wall[w][i][2]);
        kit_polygon(&kit, p, 4, kit_material(&kit, m));
    }
    /* Off the floor: of surfaces in one plane rounding chooses. */
    kit_sphere(&kit, pen_vec3(random_in(r, .2, .4), .25, .3), .2, draw_material(r));
    kit_cylinder(&kit, pen_vec3(random_in(r, .6, .8), .05, .5), pen_vec3(0, 1, 0), .15, .5,
                 draw_material(r));
    kit_point(&kit, pen_vec3(.5, .9, random_in(r, .4, .8)), pen_vec3(1, 1, 1));
}

static void draw_cornell(struct row_draw *d, struct row_case *c)
{
    draw_one(d, c, 6 + (double)(d->index % 4));
}

static void judge_cornell(const struct row_case *c, struct row_verdict *v)
{
    static const char *const name[][2] = {
        {"rmse at 1e6 [ulp/pixel]", "other pixels at 1e6, of 4096"},
        {"rmse at 1e7 [ulp/pixel]", "other pixels at 1e7, of 4096"},
        {"rmse at 1e8 [ulp/pixel]", "other pixels at 1e8, of 4096"},
        {"rmse at 1e9 [ulp/pixel]", "other pixels at 1e9, of 4096"}};
    struct random r = {(uint64_t)c->arg[0] + 77, 0};
    int power = (int)c->arg[1] - 6;
    double by = pow(10, c->arg[1]), ulp = nextafter(3 * by, INFINITY) - 3 * by, pixel = 1. / 48;
    make_cornell(&r);
    float *want = picture();
    kit_map_points(&kit, kit_moved, by);
    float *got = picture();
    row_measure(v, name[power][1], differing(want, got, 1e-3), 4);
    row_measure(v, name[power][0], rmse(want, got, 1e-3) / (ulp / pixel), 1);
    free(want);
    free(got);
}

void rows_picture_cornell(struct pen_row_run *run)
{
    row_each(run, draw_cornell, judge_cornell);
}

/* H072: 64 parallel sheets of glass in any document order between a light and the floor: what
 * comes through is the product in the order of distance, with and without a tree. */
enum { SHEETS = 64 };

static void draw_stack(struct row_draw *d, struct row_case *c)
{
    draw_one(d, c, 0);
}

static double make_stack(uint64_t seed)
{
    static const double kt[] = {.9, .8, .7};
    struct random r = {seed + 72, 0};
    double product = 1;
    int order[SHEETS], glass[3], what[SHEETS];
    kit_init(&kit);
    kit.view.camera.position = pen_vec3(6, 0, .5);
    kit.view.camera.direction = pen_vec3(-1, 0, -.0833333333333333333);
    struct pen_material floor = kit_matte(1);
    kit_sheet(&kit, 0, 8, kit_material(&kit, floor));
    for (int i = 0; i < SHEETS; i++) {
        int k = (int)random_below(&r, (uint32_t)i + 1);
        order[i] = order[k];
        order[k] = i;
        what[i] = (int)random_below(&r, 3);
    }
    for (int i = 0; i < 3; i++) {
        struct pen_material m = pen_material_default();
        m.kt = pen_vec3(kt[i], kt[i], kt[i]);
        glass[i] = kit_material(&kit, m);
    }
    for (int i = 0; i < SHEETS; i++)
        kit_sheet(&kit, 1 + order[i] / 16., 4, glass[what[order[i]]]);
    kit_directional(&kit, pen_vec3(0, 0, -1), pen_vec3(1, 1, 1));
    for (int i = 0; i < SHEETS; i++)
        product *= kt[what[i]];
    return product;
}

static void judge_stack(const struct row_case *c, struct row_verdict *v)
{
    struct pen_ray_counts rays;
    double product = make_stack((uint64_t)c->arg[0]);
    vec3 by_tree = kit_pixel(&kit, 0, 0, &rays);
    kit.settings.accelerator = PEN_ACCEL_NONE;
    vec3 by_list = kit_pixel(&kit, 0, 0, &rays);
    row_require(v, by_tree.x == by_list.x, "tree and list differ");
    row_measure(v, "transmittance of 64 sheets [float ulp]",
                fabs(by_tree.x - product) / (product * 0x1p-24), 4);
}

void rows_stack(struct pen_row_run *run)
{
    row_each(run, draw_stack, judge_stack);
}

/* H080: a point half in the shadow of a straight edge under a disk light, turned in space at will:
 * the visible share of the disk is (acos h - h sqrt(1 - h^2)) / pi whatever the pose. */
enum { SOFT_SAMPLES = 4096 };

static void draw_pose(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    vec3 n = random_below(r, 2) ? random_direction(r) : gen_axial(r), x, y;
    n = pen_normalize(n);
    if (random_below(r, 3) == 0) /* nearly along z, and along any axis */
        n = gen_near_parallel(r, pen_vec3(0, 0, 1), 10);
    gen_frame(r, n, &x, &y);
    row_fixed(c, (double)(random_bits(r) >> 40));
    row_fixed(c, random_in(r, -.9, .9));
    row_arg3(c, n);
    row_arg3(c, x);
    row_arg3(c, y);
}

static void judge_pose(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    struct pen_ray_counts rays;
    uint64_t seed = (uint64_t)row_next(c, &at);
    double h = row_next(c, &at), radius = .5;
    vec3 n = row_next3(c, &at), x = row_next3(c, &at), y = row_next3(c, &at), p[4];
    if (fabs(pen_dot(n, n) - 1) > 1e-9 || fabs(pen_dot(x, x) - 1) > 1e-9 ||
        fabs(pen_dot(x, n)) > 1e-9 || fabs(pen_dot(x, y)) > 1e-9 || fabs(pen_dot(y, n)) > 1e-9) {
        row_skip(v);
        return;
    }
    kit_init(&kit);
    kit.settings.light_samples = SOFT_SAMPLES;
    kit.settings.seed = seed;
    int matte = kit_material(&kit, kit_matte(1));
    for (int i = 0; i < 4; i++) /* the floor */
        p[i] = pen_along(pen_scale(x, i == 0 || i == 3 ? -9 : 9), y, i < 2 ? -9 : 9);
    kit_polygon(&kit, p, 4, matte);
    /* Half way up, everything on one side of the line whose image on the disk is at h radius. */
    for (int i = 0; i < 4; i++)
        p[i] = pen_along(pen_along(pen_scale(n, 2), x, i == 0 || i == 3 ? -30 : .5 * h * radius), y,
                         i < 2 ? -30 : 30);
    kit_polygon(&kit, p, 4, matte);
    kit_point(&kit, pen_scale(n, 4), pen_vec3(1, 1, 1))->radius = radius;
    kit.view.camera.position = pen_along(pen_scale(x, 3), n, 1);
    kit.view.camera.direction = pen_neg(kit.view.camera.position);
    kit.view.camera.up = y;
    vec3 got = kit_pixel(&kit, 0, 0, &rays);
    double share = (acos(h) - h * sqrt(1 - h * h)) / 3.141592653589793;
    double sigma = sqrt(share * (1 - share) / SOFT_SAMPLES);
    row_measure(v, "penumbra in any pose [sigma of plain sampling]", fabs(got.x - share) / sigma,
                5);
}

void rows_pose(struct pen_row_run *run)
{
    row_each(run, draw_pose, judge_pose);
}
