/* SPDX-License-Identifier: MIT */
/* Coincident surfaces are layers. The picture of surfaces in contact is that of surfaces with a
 * small gap, where the earlier surface in the document is on the viewer's side. */
#include <math.h>

#include "math/transform.h"
#include "property/gen.h"
#include "property/rows.h"
#include "property/shot.h"

static const double pi = 3.14159265358979323846;

enum { SIDE = 10, PIXELS = SIDE * SIDE };

static struct kit kit;
static float film[3 * SHOT_PIXELS], other[3 * SHOT_PIXELS];

/* Scenes are made in a frame in which the layers lie in the plane z = 0, about the origin, and
 * their size is about 1. The map puts them anywhere; in a group, the renderer applies it. */
struct pose {
    struct pen_transform map;
    double scale;
    bool group;
};

static vec3 posed(const struct pose *pose, vec3 p)
{
    return pen_transform_point(&pose->map, p);
}

static vec3 posed_direction(const struct pose *pose, vec3 d)
{
    return pen_transform_vector(&pose->map, d);
}

/* A point of an object; a length of one. */
static vec3 of_object(const struct pose *pose, double x, double y, double z)
{
    return pose->group ? pen_vec3(x, y, z) : posed(pose, pen_vec3(x, y, z));
}

static double length_of(const struct pose *pose, double length)
{
    return pose->group ? length : length * pose->scale;
}

/* Any turn and scale; an offset only where the plane z = 0 stays one in doubles. */
static struct pose draw_pose(struct random *r, bool any_offset)
{
    double scale = random_below(r, 2) ? 1 : exp2(random_in(r, -26, 26));
    bool turned = random_below(r, 3) > 0;
    vec3 axis = random_direction(r), at = pen_scale(random_vec(r, 4), scale);
    if ((!turned || any_offset) && random_below(r, 2))
        at = pen_scale(gen_offset3(random_below(r, 2) ? 1e3 : 1e6), scale);
    double degrees = turned ? random_in(r, 0, 360) : 0;
    return (struct pose){pen_transform_make(scale, axis, degrees, at), scale,
                         random_below(r, 2) > 0};
}

/* ---- The members of a stack ---- */

enum member { SQUARE, TURNED, TRIANGLE, PLANE, CAP, TILES, MEMBER_KINDS };

static vec3 object_direction(const struct pose *pose, double z)
{
    vec3 d = pen_vec3(0, 0, z);
    return pose->group ? d : posed_direction(pose, d);
}

/* A sheet of 3 x 3 squares, each of two triangles. */
static void add_tiles(const struct pose *pose, double z, int material)
{
    for (int i = 0; i < 3; i++)
        for (int k = 0; k < 3; k++) {
            double a = 2 * i - 3, b = 2 * k - 3;
            const vec3 t[4] = {of_object(pose, a, b, z), of_object(pose, a + 2, b, z),
                               of_object(pose, a + 2, b + 2, z), of_object(pose, a, b + 2, z)};
            kit_triangle(&kit, t[0], t[1], t[2], material);
            kit_triangle(&kit, t[0], t[2], t[3], material);
        }
}

/* Squares and tiles have the same corners in every stack; the others differ, and cover the
 * middle. */
static void add_member(const struct pose *pose, struct random *r, enum member kind, double z,
                       int material)
{
    static const double corner[4][2] = {{-3, -3}, {3, -3}, {3, 3}, {-3, 3}};
    vec3 v[4];
    double turn = kind == TURNED ? random_in(r, 0, pi) : 0, wide = random_in(r, 1, 2);
    double x = random_in(r, -.3, .3), y = random_in(r, -.3, .3), up = random_below(r, 2) ? 1 : -1;
    bool back = random_below(r, 2);
    if (kind == SQUARE)
        wide = 1, x = y = 0;
    for (int i = 0; i < 4; i++) {
        const double *c = corner[back ? 3 - i : i];
        v[i] = of_object(pose, x + wide * (cos(turn) * c[0] - sin(turn) * c[1]),
                         y + wide * (sin(turn) * c[0] + cos(turn) * c[1]), z);
    }
    if (kind == SQUARE || kind == TURNED)
        kit_polygon(&kit, v, 4, material);
    else if (kind == TRIANGLE)
        kit_triangle(&kit, v[0], v[1], of_object(pose, x, back ? y - 9 : y + 9, z), material);
    else if (kind == PLANE)
        kit_plane(&kit, of_object(pose, x, y, z), object_direction(pose, up), material);
    else if (kind == CAP)
        kit_cylinder(&kit, of_object(pose, x, y, z), object_direction(pose, up),
                     length_of(pose, 1.5 * wide), length_of(pose, random_in(r, .2, 2)), material);
    else
        add_tiles(pose, z, material);
}

static vec3 toward(double azimuth, double height)
{
    return pen_vec3(cos(azimuth) * cos(height), sin(azimuth) * cos(height), sin(height));
}

static void look(const struct pose *pose, vec3 eye, vec3 at, double wide)
{
    shot_look(&kit, posed(pose, eye), posed(pose, at), wide * pose->scale);
    kit.view.camera.up = posed_direction(pose, pen_vec3(.1, 1, .2));
    kit.settings.width = kit.settings.height = SIDE;
}

/* ---- Contact is the limit of a gap ---- */

static void draw_seed(struct row_draw *d, struct row_case *c)
{
    row_fixed(c, (double)(random_bits(&d->random) >> 40));
}

static struct pen_material draw_material(struct random *r, bool mirror)
{
    struct pen_material m = kit_matte(random_below(r, 3) ? random_in(r, .1, 1) : 0);
    if (random_below(r, 3))
        m.kt = pen_vec3(random_in(r, .2, 1), random_in(r, .2, 1), random_in(r, .2, 1));
    if (mirror && random_below(r, 2))
        m.kr = pen_vec3(random_in(r, .2, .9), random_in(r, .2, .9), random_in(r, .2, .9));
    return m;
}

/* On either side, hard or soft, some with a disk that passes through the layers' plane. */
static void draw_lights(const struct pose *pose, struct random *r)
{
    for (int i = 1 + (int)random_below(r, 3); i > 0; i--) {
        bool cut = random_below(r, 4) == 0;
        double height = (random_below(r, 2) ? 1 : -1) * random_in(r, .2, 1.3);
        vec3 l = toward(random_in(r, 0, 2 * pi), cut ? .1 * height : height);
        struct pen_light_desc *light;
        if (random_below(r, 2)) {
            light = kit_directional(&kit, pen_neg(posed_direction(pose, l)), pen_vec3(1, 1, 1));
            light->angular_radius = cut ? 20 : random_below(r, 2) ? random_in(r, 1, 8) : 0;
        } else {
            light = kit_point(&kit, posed(pose, pen_scale(l, 4)), pen_vec3(1, 1, 1));
            light->radius = pose->scale * (cut ? 1 : random_below(r, 2) ? random_in(r, .1, .5) : 0);
        }
    }
}

static void make_stack(uint64_t seed, double gap)
{
    struct random r = {seed + 10, 0};
    int count = 2 + (int)random_below(&r, 3);
    double side = random_below(&r, 2) ? 1 : -1;
    enum member kinds[4];
    bool squares = random_below(&r, 4) == 0;
    for (int i = 0; i < count; i++)
        kinds[i] = squares ? SQUARE : (enum member)random_below(&r, MEMBER_KINDS);
    struct pose pose = draw_pose(&r, squares);
    shot_begin(&kit);
    for (int i = 0; i < count; i++) {
        int material = kit_material(&kit, draw_material(&r, kinds[i] != CAP));
        add_member(&pose, &r, kinds[i], side * gap * (count - 1 - i), material);
    }
    if (pose.group)
        kit_group(&kit, 0, &pose.map);
    draw_lights(&pose, &r);
    kit.desc.background = pen_vec3(.1, .2, .3);
    kit.settings.light_samples = 6;
    kit.settings.max_depth = 6;
    vec3 eye = pen_scale(toward(random_in(&r, 0, 2 * pi), side * random_in(&r, .2, 1.5)), 5);
    look(&pose, eye, random_vec(&r, .5), random_in(&r, .5, 8));
}

static int different(double most)
{
    int count = 0;
    for (int i = 0; i < PIXELS; i++) {
        double off = 0;
        for (int k = 0; k < 3; k++)
            off = fmax(off, fabs((double)film[3 * i + k] - (double)other[3 * i + k]));
        count += !(off <= most);
    }
    return count;
}

/* A pixel that looks at a border within the gap may differ. */
static void judge_gap(const struct row_case *c, struct row_verdict *v)
{
    uint64_t seed = (uint64_t)c->arg[0];
    make_stack(seed, 0);
    shot_take(&kit, film);
    make_stack(seed, 1e-7);
    shot_take(&kit, other);
    row_measure(v, "pixels that a gap of 1e-7 changes", different(1e-5), 1);
}

void rows_layers_gap(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_gap);
}

/* ---- What light pays through layers on an opaque one, in closed form ---- */

/* Looks at the middle, at a corner of tiles or anywhere between, through a window of any size. */
static double make_paid(uint64_t seed)
{
    struct random r = {seed + 20, 0};
    int count = 2 + (int)random_below(&r, 3), solid = (int)random_below(&r, (uint32_t)count);
    double side = random_below(&r, 2) ? 1 : -1, paid = 1;
    struct pose pose = draw_pose(&r, false);
    shot_begin(&kit);
    for (int i = 0; i < count; i++) {
        double kt = i == solid ? 0 : random_in(&r, .3, 1);
        struct pen_material m = kit_matte(i == solid ? 1 : 0);
        m.kt = pen_vec3(kt, kt, kt);
        paid *= i < solid ? kt * kt : 1;
        enum member kind = (enum member)random_below(&r, MEMBER_KINDS);
        add_member(&pose, &r, kind == CAP ? TILES : kind, 0, kit_material(&kit, m));
    }
    if (pose.group)
        kit_group(&kit, 0, &pose.map);
    vec3 sun = toward(random_in(&r, 0, 2 * pi), side * random_in(&r, .3, 1.5));
    struct pen_light_desc *light =
        kit_directional(&kit, pen_neg(posed_direction(&pose, sun)), pen_vec3(1, 1, 1));
    light->angular_radius = random_below(&r, 2) ? 4 : 0;
    kit.settings.light_samples = 8;
    double x = random_below(&r, 2) ? 1 : random_in(&r, -.5, .5);
    vec3 at = pen_vec3(x, random_below(&r, 2) ? x : 0, 0);
    look(&pose, pen_add(at, pen_scale(toward(random_in(&r, 0, 2 * pi), side), 5)), at,
         gen_power(&r, -12, -.5));
    return paid * fabs(sun.z);
}

static void judge_paid(const struct row_case *c, struct row_verdict *v)
{
    double want = make_paid((uint64_t)c->arg[0]);
    int wrong = 0;
    shot_take(&kit, film);
    for (int i = 0; i < PIXELS; i++)
        wrong += !(fabs((double)film[3 * i] - want) <= 0x1p-20 * want);
    row_measure(v, "pixels whose light did not pay each layer on both ways", wrong, 0);
}

void rows_layers_paid(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_paid);
}

/* ---- The part of a light's disk below an opaque layer stays dark ---- */

enum { SAMPLES = 4096 };

static void judge_below(const struct row_case *c, struct row_verdict *v)
{
    struct random r = {(uint64_t)c->arg[0] + 30, 0};
    struct pen_ray_counts rays;
    double h = random_in(&r, 0, .9), side = random_below(&r, 2) ? 1 : -1;
    struct pose pose = draw_pose(&r, true);
    bool clear_first = random_below(&r, 2);
    shot_begin(&kit);
    for (int i = 0; i < 2; i++) { /* the light that the first one sends is judged */
        struct pen_material m = kit_matte(i == 0);
        m.kt = clear_first == (i == 0) ? pen_vec3(1, 1, 1) : m.kt;
        add_member(&pose, &r, SQUARE, 0, kit_material(&kit, m));
    }
    if (pose.group)
        kit_group(&kit, 0, &pose.map);
    /* Seen from the origin, the plane cuts the disk at h of its radius below its centre. */
    double radius = 1, high = h * radius, far = 3;
    double sine = high / far, down = asin(sine);
    vec3 to = pen_scale(toward(0, side * down), far);
    struct pen_light_desc *light = kit_point(&kit, posed(&pose, to), pen_vec3(1, 1, 1));
    light->radius = radius * pose.scale;
    kit.settings.light_samples = SAMPLES;
    look(&pose, pen_vec3(0, -1, 2 * side), pen_vec3(0, 0, 0), 1e-9);
    kit.settings.width = kit.settings.height = 1;
    vec3 got = kit_pixel(&kit, 0, 0, &rays);
    /* The disk is across the direction to it: the cut is at tan(down) * far. */
    double cut = tan(down) * far / radius, share = 1 - (acos(cut) - cut * sqrt(1 - cut * cut)) / pi;
    double sigma = sqrt(share * (1 - share) / SAMPLES);
    row_measure(v, "share of the disk above an opaque layer [sigma of plain sampling]",
                fabs(got.x / sine - share) / sigma, 5);
}

void rows_layers_below(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_below);
}

/* ---- Opaque layers in one plane: the first in the document is seen, never a mixture ---- */

/* Bodies of cylinders are behind the layers. */
static void turn_away(const struct pose *pose, double side)
{
    for (int i = 0; i < KIT_OBJECTS; i++)
        if (kit.objects[i].kind == PEN_OBJECT_CYLINDER)
            kit.objects[i].u.cylinder.axis = object_direction(pose, -side);
}

/* Within .1 of the middle all members are there. */
static void judge_first(const struct row_case *c, struct row_verdict *v)
{
    struct random r = {(uint64_t)c->arg[0] + 40, 0};
    int count = 2 + (int)random_below(&r, 3), wrong = 0;
    double side = random_below(&r, 2) ? 1 : -1;
    struct pose pose = draw_pose(&r, false);
    shot_begin(&kit);
    for (int i = 0; i < count; i++)
        add_member(&pose, &r, (enum member)random_below(&r, MEMBER_KINDS - (i > 0 ? 0 : 2)), 0,
                   kit_material(&kit, kit_glow(i + 1, 0, 0)));
    turn_away(&pose, side);
    if (pose.group)
        kit_group(&kit, 0, &pose.map);
    look(&pose, pen_scale(toward(random_in(&r, 0, 2 * pi), side * random_in(&r, .05, 1.5)), 5),
         pen_vec3(0, 0, 0), gen_power(&r, -10, -1));
    shot_take(&kit, film);
    for (int i = 0; i < PIXELS; i++)
        wrong += film[3 * i] != 1;
    row_measure(v, "pixels that see a later surface", wrong, 0);
}

void rows_layers_first(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_first);
}

/* ---- Coincident quadrics: each way through is paid in document order ---- */

enum { TWINS_MAX = 3 };

/* Equal primitives that differ in what they let through, and what they send; member i glows i +
 * 1. */
struct twins {
    int kind, count; /* 0 sphere, 1 tube, 2 cylinder, 3 cone */
    double radius, high;
    double kt[TWINS_MAX], kd[TWINS_MAX];
    double nl;     /* of a sun in the plane of the middle: of a cone's side, which slants */
    bool opposite; /* the sun is opposite to the eye */
};

static void add_twin(const struct pose *pose, const struct twins *t, int material)
{
    vec3 base = of_object(pose, 0, 0, -.5 * t->high), axis = object_direction(pose, 1);
    double size = length_of(pose, t->radius), high = length_of(pose, t->high);
    if (t->kind == 0) {
        kit_sphere(&kit, of_object(pose, 0, 0, 0), size, material);
    } else if (t->kind == 1) {
        kit_tube(&kit, of_object(pose, 0, 0, 0), axis, size, material);
    } else {
        struct pen_object_desc *o = kit_cylinder(&kit, base, axis, size, high, material);
        if (t->kind == 3) {
            o->kind = PEN_OBJECT_CONE;
            o->u.cone.base = base;
            o->u.cone.axis = axis;
            o->u.cone.radius = size;
            o->u.cone.top_radius = .25 * size;
            o->u.cone.height = high;
            o->u.cone.caps = true;
        }
    }
}

static struct twins make_twins(uint64_t seed)
{
    struct random r = {seed + 50, 0};
    struct twins t = {.kind = (int)random_below(&r, 4), .count = 2 + (int)random_below(&r, 2)};
    struct pose pose = draw_pose(&r, true);
    t.radius = random_in(&r, .5, 1.5);
    t.high = random_in(&r, 1, 3);
    t.nl = t.kind < 3 ? 1 : t.high / sqrt(t.high * t.high + .75 * .75 * t.radius * t.radius);
    shot_begin(&kit);
    for (int i = 0; i < t.count; i++) {
        t.kt[i] = random_in(&r, .3, .9);
        t.kd[i] = random_in(&r, .2, 1);
        struct pen_material m = kit_matte(t.kd[i]);
        m.kt = pen_vec3(t.kt[i], t.kt[i], t.kt[i]);
        m.emission = pen_vec3(i + 1, 0, 0);
        add_twin(&pose, &t, kit_material(&kit, m));
    }
    if (pose.group)
        kit_group(&kit, 0, &pose.map);
    t.opposite = random_below(&r, 2);
    vec3 eye = toward(random_in(&r, 0, 2 * pi), 0), sun = t.opposite ? pen_neg(eye) : eye;
    kit_directional(&kit, pen_neg(posed_direction(&pose, sun)), pen_vec3(1, 1, 1))->angular_radius =
        random_below(&r, 2) ? 1 : 0;
    kit.settings.light_samples = 4;
    kit.settings.max_depth = 8;
    look(&pose, pen_scale(eye, 6), pen_vec3(0, 0, 0), 1e-7);
    return t;
}

/* The path goes in through all at the front and out through all at the back. The viewer's side of
 * each has sunlight if the sun is behind the viewer: what the earlier ones let through, and at the
 * back what all at the front did. */
static void twins_light(const struct twins *t, double *glow, double *sun)
{
    double weight = 1, all = 1;
    *glow = *sun = 0;
    for (int way = 0; way < 2; way++) {
        double light = t->opposite ? 0 : all;
        for (int i = 0; i < t->count; i++) {
            *glow += weight * (i + 1);
            *sun += weight * t->kd[i] * t->nl * light;
            weight *= t->kt[i];
            light *= t->kt[i];
            all *= t->kt[i];
        }
    }
}

static void judge_round(const struct row_case *c, struct row_verdict *v)
{
    struct twins t = make_twins((uint64_t)c->arg[0]);
    double glow, sun;
    int dim = 0, mixed = 0;
    twins_light(&t, &glow, &sun);
    shot_take(&kit, film);
    for (int i = 0; i < PIXELS; i++) {
        dim += !(fabs((double)film[3 * i + 1] - sun) <= 1e-5 * (sun + .01));
        mixed += !(fabs((double)film[3 * i] - (glow + sun)) <= 1e-5 * glow);
    }
    row_measure(v, "pixels with light that is not the closed form's", dim, 0);
    row_measure(v, "pixels with surfaces in another order", mixed, 0);
}

void rows_layers_round(struct pen_row_run *run)
{
    row_each(run, draw_seed, judge_round);
}
