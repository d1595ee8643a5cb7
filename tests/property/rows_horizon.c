/* SPDX-License-Identifier: MIT */
/* Lights at the horizon of a wall: in its plane within rounding, or with a disk that the plane
 * cuts. */
#include <math.h>

#include "property/body.h"
#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

enum { SIDE = 16, SAMPLES = 64 };

static const double pi = 3.14159265358979323846, horizon = 0x1p-22;

static struct kit kit;
static float film[3 * SHOT_PIXELS];

/* ---- A room of six polygons, and a light in the plane of a wall or along it ---- */

enum { ALONG, FAR_IN_PLANE, BEHIND_NEXT_WALL, BESIDE_FLOOR, WAYS };

/* In the plane of a wall, but beside it: rays that pass under the foot of the next wall within
 * rounding meet that plane where the light lies in it.
 *
 * Arguments: where the light is; how far the room is turned about z, in degrees; which wall; the
 * light's distance; its height over the wall's plane (a sine where it is infinitely far); a spot or
 * not, a disk or not; the seed of the view. The first cases are those that were found: a room
 * turned by 32 degrees, the sun along its walls. */
static void draw_walls(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    bool first = d->index < 4;
    int way = first ? ALONG : (int)(d->index % WAYS);
    double tilt = way == BEHIND_NEXT_WALL ? gen_power(r, -14, -9) : gen_power(r, -17, -7);
    if (way == BESIDE_FLOOR)
        tilt = -gen_power(r, -16, -14);
    else if (way != BEHIND_NEXT_WALL)
        tilt = random_below(r, 2) ? 0 : random_below(r, 2) ? tilt : -tilt;
    row_fixed(c, way);
    row_fixed(c, first ? 32 : random_in(r, -180, 180));
    row_fixed(c, first ? (double)d->index : random_below(r, 4));
    row_fixed(c, way == FAR_IN_PLANE   ? gen_power(r, 2, 8)
                 : way == BESIDE_FLOOR ? 1 + gen_power(r, -12, -10)
                                       : random_in(r, 1.5, 4));
    row_fixed(c, first ? 0 : tilt);
    row_fixed(c, first ? 0 : random_below(r, 4));
    row_fixed(c, (double)(random_bits(r) >> 40));
}

static void add_walls(const struct body_pose *pose)
{
    static struct body b;
    struct random r = {0, 0};
    struct pen_material m = kit_matte(.5);
    m.ks = pen_vec3(.5, .5, .5);
    m.shininess = 10;
    body_make(&b, BODY_BOX, &r, 1);
    for (int i = 0; i < b.vertices; i++)
        b.v[i] = pen_vec3(copysign(1, b.v[i].x), copysign(1, b.v[i].y), copysign(1, b.v[i].z));
    body_add(&b, pose, &kit, kit_material(&kit, m));
}

/* The light of a case: `wall` chooses one of the four directions that turn with the room. */
static void add_wall_light(const struct row_case *c, const struct body_pose *pose)
{
    int way = (int)c->arg[0], wall = (int)c->arg[2] & 3, kind = (int)c->arg[5];
    double turn = c->arg[1] * pi / 180 + .5 * pi * wall, tilt = c->arg[4];
    vec3 along = pen_vec3(cos(turn + tilt), sin(turn + tilt), 0), one = pen_vec3(1, 1, 1);
    if (way == ALONG) {
        kit_directional(&kit, along, one)->angular_radius = kind & 2 ? 1e-6 : 0;
        return;
    }
    /* In the plane y = -1 of the room, turned by the wall; beyond the wall x = 1. */
    vec3 flat = pen_vec3(c->arg[3], -1 + tilt, .3), p = flat;
    for (int i = 0; i < wall; i++)
        p = pen_vec3(-p.y, p.x, p.z);
    vec3 at = body_place(pose, p);
    struct pen_light_desc *light =
        kind & 1 ? kit_spot(&kit, at, pen_neg(at), one) : kit_point(&kit, at, one);
    light->radius = kind & 2 && way != BESIDE_FLOOR ? .1 : 0;
}

static void judge_walls(const struct row_case *c, struct row_verdict *v)
{
    static const char *const lit[] = {"lit, light along a wall", "lit, light far in the plane",
                                      "lit, light behind the next wall",
                                      "lit, light beside the floor"};
    struct random r = {(uint64_t)c->arg[6] * 0x9e3779b97f4a7c15u + 1, 0};
    double a = c->arg[1] * pi / 180;
    struct body_pose pose = {.x = {cos(a), sin(a), 0},
                             .y = {-sin(a), cos(a), 0},
                             .z = {0, 0, 1},
                             .size = 1,
                             .group = true};
    if (!(c->arg[0] >= 0 && c->arg[0] < WAYS) || !(fabs(c->arg[4]) < 1e-3)) {
        row_skip(v);
        return;
    }
    shot_begin(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.settings.light_samples = 8;
    add_walls(&pose);
    add_wall_light(c, &pose);
    vec3 eye = random_vec(&r, .9), at = random_vec(&r, .6);
    bool foot = c->arg[0] == BESIDE_FLOOR; /* of the wall across, low enough to see under it */
    for (int i = 0; foot && i <= ((int)c->arg[2] & 3); i++)
        at = i == 0 ? pen_vec3(-1, -.99, at.z) : pen_vec3(-at.y, at.x, at.z);
    shot_look(&kit, body_place(&pose, eye), body_place(&pose, at), foot ? .03 : 3);
    shot_take(&kit, film);
    int count = shot_lit(film);
    row_measure(v, "lit pixels of a closed room", count, 0);
    if (count)
        row_tally(v, lit[(int)c->arg[0]]);
}

void rows_horizon_walls(struct pen_row_run *run)
{
    row_each(run, draw_walls, judge_walls);
}

/* ---- A disk that the horizon cuts ---- */

/* Arguments: a plane, a polygon or a sphere; a directional light or its distance; the sine of the
 * centre's height, the disk's radius over its distance; kt; pattern; offset; the seed. */
static void draw_disk(struct row_draw *d, struct row_case *c)
{
    struct random *r = &d->random;
    static const double kt[] = {0, .5, 1};
    double radius = random_below(r, 2) ? gen_power(r, -8, -4) : random_in(r, .01, 1);
    double sine = radius < 1e-4 && random_below(r, 2) ? horizon * random_in(r, -1, 4)
                                                      : radius * random_in(r, 0, 1.1);
    row_fixed(c, random_below(r, 3));
    row_fixed(c, random_below(r, 2) ? 0 : gen_power(r, .5, 6));
    row_fixed(c, fmin(sine, .9));
    row_fixed(c, radius);
    row_fixed(c, kt[random_below(r, 3)]);
    row_fixed(c, random_below(r, 3));
    row_fixed(c, random_below(r, 2) ? 0 : 1e3);
    row_fixed(c, (double)(random_bits(r) >> 40));
}

/* The share of a unit disk where its second coordinate is above h. */
static double share_above(double h)
{
    return h >= 1 ? 0 : h <= -1 ? 1 : (acos(h) - h * sqrt(1 - h * h)) / pi;
}

/* The surface, with n at the origin of the pose. */
static void add_floor(int kind, const struct body_pose *pose, double kt)
{
    struct pen_material m = kit_matte(1);
    m.kt = pen_vec3(kt, kt, kt);
    int material = kit_material(&kit, m);
    vec3 v[4];
    for (int i = 0; i < 4; i++)
        v[i] = body_place(pose, pen_vec3(i == 1 || i == 2 ? 3 : -3, i < 2 ? -3 : 3, 0));
    if (kind == 0)
        kit_plane(&kit, pose->o, pose->z, material);
    else if (kind == 1)
        kit_polygon(&kit, v, 4, material);
    else
        kit_sphere(&kit, body_place(pose, pen_vec3(0, 0, -1)), 1, material);
}

static void judge_disk(const struct row_case *c, struct row_verdict *v)
{
    struct random r = {(uint64_t)c->arg[7] * 0x9e3779b97f4a7c15u + 121, 0};
    int kind = (int)c->arg[0];
    double far = c->arg[1], sine = c->arg[2], radius = c->arg[3], kt = c->arg[4];
    double cosine = sqrt(1 - sine * sine), azimuth = random_in(&r, 0, 2 * pi);
    struct body_pose pose = body_pose(&r, 1, c->arg[6]);
    shot_begin(&kit);
    kit.settings.width = kit.settings.height = SIDE;
    kit.settings.light_samples = SAMPLES;
    kit.settings.light_pattern = (int)c->arg[5];
    kit.settings.max_depth = 1;
    add_floor(kind, &pose, kt);
    vec3 to = pen_vec3(cosine * cos(azimuth), cosine * sin(azimuth), sine);
    vec3 one = pen_vec3(1, 1, 1), eye = pen_vec3(cos(azimuth + 2), sin(azimuth + 2), 1);
    if (far > 0)
        kit_point(&kit, body_place(&pose, pen_scale(to, far)), one)->radius = radius * far;
    else
        kit_directional(&kit, pen_neg(body_turn(&pose, to)), one)->angular_radius =
            atan(radius) * 180 / pi;
    shot_look(&kit, body_place(&pose, eye), pose.o, 1e-11);
    double rays = shot_take(&kit, film), sum = 0;
    for (int i = 0; i < SIDE * SIDE; i++)
        sum += film[3 * i];
    double pixels = SIDE * SIDE, mean = sum / pixels / sine;
    double above = share_above((horizon - sine) / (radius * cosine));
    double below = share_above((horizon + sine) / (radius * cosine));
    if (fabs(sine - horizon) < .01 * horizon) {
        row_skip(v);
        return;
    }
    if (sine < horizon) {
        row_measure(v, "lit pixels, the centre below or at the horizon", shot_lit(film), 0);
        return;
    }
    /* A ray into the sphere leaves it again. */
    double want = above + below * (kind == 2 ? kt * kt : kt);
    row_measure(v, "visible share of a disk at the horizon", fabs(mean - want), .02);
    want = above + (kt > 0 ? below : 0);
    if (c->arg[5] != PEN_PATTERN_GRID) /* leaves out points of its square that are off the disk */
        row_measure(v, "shadow rays of a sample", fabs(rays / pixels / SAMPLES - want), .02);
}

void rows_horizon_disk(struct pen_row_run *run)
{
    row_each(run, draw_disk, judge_disk);
}
