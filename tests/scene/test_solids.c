/* SPDX-License-Identifier: MIT */
/* Solids of triangles and polygons: which faces form one, whether it is closed, what it contains
 * and its number, for any order of faces and vertices in the document. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene/solid.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

typedef struct pen_vec3 vec3;

static struct kit kit;
static struct random random_state;

static struct pen_material glass(double ior)
{
    struct pen_material m = kit_matte(0);
    m.kt = pen_vec3(1, 1, 1);
    m.ior = ior;
    return m;
}

static void begin(uint64_t seed)
{
    kit_init(&kit);
    random_state = random_begin(seed);
}

/* How a mesh is put into the document. */
enum turn { AS_IT_IS, REVERSED, ANY_TURN };

/* Adds a face that begins at any vertex. */
static void add_face(const vec3 *v, const int *corner, uint32_t count, int material, enum turn turn)
{
    vec3 face[8];
    const uint32_t first = random_below(&random_state, count);
    const bool back = turn == REVERSED || (turn == ANY_TURN && random_bits(&random_state) & 1);
    for (uint32_t i = 0; i < count; i++)
        face[i] = v[corner[(first + (back ? count - i : i)) % count]];
    kit_polygon(&kit, face, count, material);
}

/* The faces of a box, counter-clockwise from outside; corner i is at the signs of its bits. */
static const int box_faces[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                    {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

static void box_corners(vec3 lo, vec3 hi, vec3 v[8])
{
    for (int i = 0; i < 8; i++)
        v[i] = pen_vec3(i & 1 ? hi.x : lo.x, i & 2 ? hi.y : lo.y, i & 4 ? hi.z : lo.z);
}

/* Adds some faces of a box, those with bits in `faces`; of two triangles each if `cut`. */
static void add_faces(vec3 lo, vec3 hi, unsigned faces, bool cut, int material, enum turn turn)
{
    vec3 v[8];
    box_corners(lo, hi, v);
    for (int i = 0; i < 6; i++) {
        const int *c = box_faces[i], half[2][3] = {{c[0], c[1], c[2]}, {c[2], c[3], c[0]}};
        if (!(faces >> i & 1))
            continue;
        if (!cut)
            add_face(v, c, 4, material, turn);
        for (int k = 0; k < 2 && cut; k++)
            add_face(v, half[k], 3, material, turn);
    }
}

static void add_box(double x, double y, double z, double half, int material, enum turn turn)
{
    add_faces(pen_vec3(x - half, y - half, z - half), pen_vec3(x + half, y + half, z + half), 63,
              false, material, turn);
}

/* Shuffles the objects of the top level. */
static void shuffle(void)
{
    for (uint32_t i = kit.desc.object_count; i > 1; i--) {
        const uint32_t k = random_below(&random_state, i);
        const struct pen_object_desc o = kit.objects[i - 1];
        kit.objects[i - 1] = kit.objects[k];
        kit.objects[k] = o;
    }
}

static vec3 to_local(const struct pen_scene *scene, vec3 p)
{
    return pen_scale(pen_sub(p, scene->center), exp2(-scene->exponent));
}

static bool contains(const struct pen_scene *scene, uint32_t solid, vec3 p)
{
    return pen_solid_contains(&scene->prims, &scene->solids, solid, to_local(scene, p));
}

/* Freezes the scene; it has so many solids, so many of them closed. */
static struct pen_scene *freeze(uint32_t solids, uint32_t closed)
{
    struct pen_scene *scene = kit_freeze(&kit);
    uint32_t found = 0;
    for (uint32_t i = 0; i < scene->solids.count; i++)
        found += scene->solids.at[i].closed;
    ck_assert_uint_eq(scene->solids.count, solids);
    ck_assert_uint_eq(found, closed);
    return scene;
}

static void check(uint32_t solids, uint32_t closed)
{
    pen_scene_free(freeze(solids, closed));
}

/* All faces of a closed convex solid look outward, once those that are turned are turned. */
static void assert_outward(const struct pen_scene *scene, uint32_t solid)
{
    struct pen_triangle room;
    const struct pen_solid *s = &scene->solids.at[solid];
    const vec3 middle = pen_box_center(s->box);
    for (uint32_t i = 0; i < s->count; i++) {
        const uint32_t prim = scene->solids.prim[s->first + i];
        const vec3 v = pen_prim_outline(&scene->prims, prim, &room).v[0];
        const vec3 n = pen_prim_normal(&scene->prims, (struct pen_hit){0, prim, 0}, v);
        ck_assert_uint_eq(scene->solids.of_prim[prim], solid);
        ck_assert((pen_dot(n, pen_sub(v, middle)) > 0) != (scene->solids.turned[prim] != 0));
    }
}

static void add_others(void)
{
    const int matte = kit_material(&kit, kit_matte(0.5)), other = kit_material(&kit, glass(1.25));
    kit_sphere(&kit, random_vec(&random_state, 3), 0.5, matte);
    kit_sheet(&kit, 0, 1, matte);
    kit_sphere(&kit, random_vec(&random_state, 3), 1e-3, other);
    kit_triangle(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0.01, 0), pen_vec3(0.01, 0, 0), other);
}

/* Any box, its faces and vertices in any order, in any group. */
START_TEST(test_solids__boxes_in_any_order)
{
    for (int i = 0; i < random_cases(200); i++) {
        begin(531 + (uint64_t)i);
        const vec3 half = pen_vec3(1, 0.5, random_in(&random_state, 0.1, 2));
        struct pen_transform f =
            pen_transform_make(random_in(&random_state, 0.5, 2), random_direction(&random_state),
                               100. * i, random_vec(&random_state, i & 2 ? 1e3 : 1));
        if (i & 4)
            f.m[0][1] += 0.5; /* a sheared box */
        add_faces(pen_neg(half), half, 63, i & 1, kit_material(&kit, glass(1.5)), ANY_TURN);
        shuffle();
        kit_group(&kit, 0, &f);
        add_others();
        shuffle();
        struct pen_scene *scene = freeze(3, 2);
        assert_outward(scene, 0);
        ck_assert_uint_eq(scene->solids.at[0].count, i & 1 ? 12 : 6);
        for (int k = 0; k < 100; k++) {
            const vec3 p = random_vec(&random_state, 1.5), at = pen_mul(p, half);
            const double most = fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z)));
            if (fabs(most - 1) > 1e-9)
                ck_assert_int_eq(contains(scene, 0, pen_transform_point(&f, at)), most < 1);
        }
        pen_scene_free(scene);
    }
}
END_TEST

/* A line from the point to be tested that meets an edge or a corner leaves the solid once. The
 * direction is that of pen_solid_contains. */
START_TEST(test_solids__contains_along_edges)
{
    static const int ends[][2] = {{0, 3}, {3, 7}, {7, 1}, {6, 7}, {7, 5}, {1, 5}, {7, 7}, {5, 7}};
    static const vec3 way = {0.5377, 0.7193, 0.4397};
    begin(532);
    add_faces(pen_vec3(-1, -1, -1), pen_vec3(1, 1, 1), 63, true, kit_material(&kit, glass(1.5)),
              ANY_TURN);
    struct pen_scene *scene = freeze(1, 1);
    vec3 v[8];
    box_corners(pen_vec3(-1, -1, -1), pen_vec3(1, 1, 1), v);
    for (int i = 0; i < random_cases(100000); i++) {
        const int *end = ends[i % 8];
        const double share = i / 8 % 16 == 0 ? 0 : random_unit(&random_state);
        const vec3 at = pen_along(v[end[0]], pen_sub(v[end[1]], v[end[0]]), share);
        const vec3 p = pen_along(at, way, random_in(&random_state, -2.5, 0));
        const double most = fmax(fabs(p.x), fmax(fabs(p.y), fabs(p.z)));
        if (fabs(most - 1) > 1e-9)
            ck_assert_msg(contains(scene, 0, p) == (most < 1), "case %d: (%a %a %a)", i, p.x, p.y,
                          p.z);
    }
    pen_scene_free(scene);
}
END_TEST

/* Two boxes that share a corner or an edge are two solids, in any order. */
START_TEST(test_solids__boxes_that_touch)
{
    for (int i = 0; i < 100; i++) {
        begin(533 + (uint64_t)i);
        const int m = kit_material(&kit, glass(1.5));
        add_box(0, 0, 0, 1, m, ANY_TURN);
        add_box(2, 2, i & 1 ? 2 : 0, 1, m, ANY_TURN);
        shuffle();
        struct pen_scene *scene = freeze(2, 2);
        assert_outward(scene, 0);
        assert_outward(scene, 1);
        const uint32_t first = contains(scene, 0, pen_vec3(0.1, 0.2, 0.3)) ? 0 : 1;
        ck_assert(contains(scene, first, pen_vec3(-0.5, 0.9, 0.9)));
        ck_assert(contains(scene, 1 - first, pen_vec3(2.5, 1.5, i & 1 ? 2 : 0)));
        ck_assert(!contains(scene, 1 - first, pen_vec3(0, 0, 0)));
        pen_scene_free(scene);
    }
}
END_TEST

/* Two boxes that are stacked, with a wall each between them, are one solid, closed. */
static void check_stacked(enum turn turn)
{
    const int m = kit_material(&kit, glass(1.5));
    add_box(0, 0, 0, 1, m, turn);
    add_box(2, 0, 0, 1, m, turn);
    shuffle();
    struct pen_scene *scene = kit_freeze(&kit);
    ck_assert_uint_ge(scene->solids.count, 1);
    for (int k = 0; k < 200; k++) {
        const vec3 p = pen_vec3(random_in(&random_state, -2, 4), random_in(&random_state, -2, 2),
                                random_in(&random_state, -2, 2));
        const bool in = p.x > -1 && p.x < 3 && fabs(p.y) < 1 && fabs(p.z) < 1;
        bool found = false;
        for (uint32_t i = 0; i < scene->solids.count; i++)
            found = found || contains(scene, i, p);
        ck_assert_int_eq(found, in);
    }
    pen_scene_free(scene);
}

START_TEST(test_solids__stacked_boxes)
{
    for (int i = 0; i < 100; i++) {
        begin(534 + (uint64_t)i);
        check_stacked(i & 1 ? REVERSED : AS_IT_IS);
    }
}
END_TEST

/* The same in whatever order the vertices run, as the document format promises. */
START_TEST(test_solids__stacked_boxes_in_any_order)
{
    for (int i = 0; i < 100; i++) {
        begin(535 + (uint64_t)i);
        check_stacked(ANY_TURN);
    }
}
END_TEST

/* What lacks a face, or has one with a corner elsewhere, is open, and keeps its sides. It contains
 * what its faces surround but for gaps of rounding, if they all are counter-clockwise. */
START_TEST(test_solids__open_boxes)
{
    for (int i = 0; i < 60; i++) {
        begin(536 + (uint64_t)i);
        const int m = kit_material(&kit, glass(1.5));
        const vec3 lo = {-1, -1, -1}, hi = {1, 1, 1};
        add_faces(lo, hi, i % 3 == 0 ? 63 & ~(1u << i % 6) : 63, i & 1, m,
                  i & 2 ? ANY_TURN : AS_IT_IS);
        struct pen_object_desc *o =
            &kit.objects[random_below(&random_state, kit.desc.object_count)];
        double *x = &o->u.polygon.vertices[random_below(&random_state, 3)].x;
        if (i % 3 == 1)
            *x = nextafter(*x, 0);
        if (i % 3 == 2) { /* a T-junction */
            kit.desc.object_count--;
            kit.desc.primitive_count--;
            const struct pen_object_desc last = kit.objects[kit.desc.object_count];
            const vec3 *v = last.u.polygon.vertices, mid = pen_scale(pen_add(v[0], v[1]), 0.5);
            kit_triangle(&kit, v[0], mid, v[2], m);
            kit_triangle(&kit, mid, v[1], v[2], m);
            if (last.u.polygon.count == 4)
                kit_triangle(&kit, v[2], v[3], v[0], m);
        }
        shuffle();
        struct pen_scene *scene = freeze(1, 0);
        for (uint32_t k = 0; k < scene->prims.count; k++)
            ck_assert_uint_eq(scene->solids.turned[k], 0);
        ck_assert_int_eq(contains(scene, 0, pen_vec3(0.1, 0.2, 0.3)), i % 3 > 0 && !(i & 2));
        pen_scene_free(scene);
    }
}
END_TEST

/* A point of a strip around a circle that turns by `halves` of a half turn. */
static vec3 strip_point(double turn, double side, int halves)
{
    const double tilt = halves * turn / 2, r = 2 + side * cos(tilt);
    return pen_vec3(r * cos(turn), r * sin(turn), side * sin(tilt));
}

/* A strip with one side is open, and so is one with two. */
START_TEST(test_solids__strips)
{
    enum { STEPS = 24 };
    for (int halves = 0; halves <= 1; halves++) {
        begin(537);
        const int m = kit_material(&kit, glass(1.5));
        vec3 v[2 * STEPS];
        for (int i = 0; i < 2 * STEPS; i++)
            v[i] = strip_point(2 * acos(-1) * (i / 2) / STEPS, i & 1 ? 0.5 : -0.5, halves);
        for (int i = 0; i < STEPS; i++) {
            const int a = 2 * i, next = i + 1 < STEPS ? a + 2 : 0, swap = !next && halves;
            const int half[2][3] = {{a, a + 1, next + swap}, {a + 1, next + !swap, next + swap}};
            for (int k = 0; k < 2; k++)
                add_face(v, half[k], 3, m, ANY_TURN);
        }
        shuffle();
        check(1, 0);
    }
}
END_TEST

/* Materials of equal values are one, wherever they are listed; any other value makes another. */
START_TEST(test_solids__materials)
{
    static const struct pen_pattern one = {
        .checker = true, .a = {1, 1, 1}, .b = {0, 0, 0}, .size = 1};
    struct pen_pattern other = one;
    struct pen_patterns first = {{&one}}, second = {{&other}};
    for (int i = 0; i < 8; i++) {
        begin(538);
        struct pen_material a = glass(1.5);
        a.patterns = i < 3 ? NULL : &first;
        struct pen_material b = a;
        other = one;
        if (i >= 4)
            b.patterns = &second; /* an equal pattern in another place */
        b.shininess += i == 1;
        b.kd.y = i == 2 ? nextafter(b.kd.y, 1) : b.kd.y;
        other.size += i == 5;
        other.b.z += i == 6;
        if (i == 7)
            second = (struct pen_patterns){{NULL, &one}};
        const bool same = i == 0 || i == 3 || i == 4;
        const int m = kit_material(&kit, a), n = kit_material(&kit, b);
        add_faces(pen_vec3(0, 0, 0), pen_vec3(1, 2, 3), 21, false, m, ANY_TURN);
        add_faces(pen_vec3(0, 0, 0), pen_vec3(1, 2, 3), 63 - 21, false, n, ANY_TURN);
        shuffle();
        struct pen_scene *scene = kit_freeze(&kit);
        ck_assert_msg((scene->solids.at[0].closed && scene->solids.count == 1) == same, "case %d",
                      i);
        pen_scene_free(scene);
    }
}
END_TEST

/* Larger boxes first; of equal ones the first in the document. */
START_TEST(test_solids__numbers)
{
    for (int i = 0; i < 50; i++) {
        begin(539 + (uint64_t)i);
        int m[9];
        for (int k = 0; k < 9; k++)
            m[k] = kit_material(&kit, glass(1.1 + 0.1 * k));
        for (int k = 0; k < 9; k++) {
            const int x = k / 3 * 8; /* two are at the same place */
            if (k % 3 == 0)
                add_box(x, 0, 0, k / 3 + 1, m[k], ANY_TURN);
            else
                kit_sphere(&kit, pen_vec3(x, 0, 0), k / 3 + 1, m[k]);
        }
        shuffle();
        struct pen_scene *scene = freeze(9, 9);
        for (uint32_t k = 0; k + 1 < 9; k++) {
            const struct pen_solid *s = &scene->solids.at[k];
            const vec3 p = pen_sub(s[0].box.hi, s[0].box.lo), q = pen_sub(s[1].box.hi, s[1].box.lo);
            const double more = p.x * p.y * p.z, less = q.x * q.y * q.z;
            const uint32_t *prim = scene->solids.prim;
            ck_assert(more > less || (more == less && prim[s[0].first] < prim[s[1].first]));
        }
        pen_scene_free(scene);
    }
}
END_TEST

/* A torus of around x across x 2 triangles, with radii 2 and 1. If it is twisted, the tube is
 * turned inside out where it meets its beginning: a surface without border, and with one side. */
static struct pen_object_desc *make_torus(int around, int across, bool twisted, int material)
{
    const int count = 2 * around * across;
    struct pen_object_desc *o = calloc((size_t)count, sizeof *o);
    vec3 *v = calloc((size_t)count * 3, sizeof *v);
    ck_assert(o != NULL && v != NULL);
    for (int i = 0; i < count * 3; i++) {
        static const int at[2][3][2] = {{{0, 0}, {1, 0}, {1, 1}}, {{0, 0}, {1, 1}, {0, 1}}};
        const int face = i / 3, half = face & 1;
        const bool back = face % 7 < 3;
        const int *c = at[half][back ? 2 - i % 3 : i % 3];
        const int along = face / 2 / across + c[0], beside = (face / 2 % across + c[1]) % across;
        const bool back_to = twisted && along == around;
        const double a = 2 * acos(-1) * (along % around) / around;
        const double b = 2 * acos(-1) * ((back_to ? across - beside : beside) % across) / across;
        v[i] = pen_vec3((2 + cos(b)) * cos(a), (2 + cos(b)) * sin(a), sin(b));
        o[face] = (struct pen_object_desc){.kind = PEN_OBJECT_TRIANGLE, .material = material};
        o[face].u.polygon.count = 3;
        o[face].u.polygon.vertices = &v[face * 3];
    }
    kit.desc.objects = o;
    kit.desc.object_count = (uint32_t)count;
    kit.desc.primitive_count = (uint32_t)count;
    return o;
}

static struct pen_scene *freeze_torus(int around, int across, bool twisted)
{
    struct pen_object_desc *o = make_torus(around, across, twisted, kit_material(&kit, glass(1.5)));
    struct pen_scene *scene = freeze(1, !twisted);
    free(o[0].u.polygon.vertices);
    free(o);
    return scene;
}

START_TEST(test_solids__torus)
{
    begin(540);
    struct pen_scene *scene = freeze_torus(40, 30, false);
    int in = 0;
    for (int i = 0; i < random_cases(10000); i++) {
        const vec3 p = random_vec(&random_state, 3.2);
        const double r = hypot(hypot(p.x, p.y) - 2, p.z);
        if (r > 0.98 && r < 1.001)
            continue; /* between the torus and its faces */
        ck_assert_int_eq(contains(scene, 0, p), r < 1);
        in += r < 1;
    }
    ck_assert_int_gt(in, random_cases(1000));
    pen_scene_free(scene);
}
END_TEST

START_TEST(test_solids__one_side_and_no_border)
{
    begin(542);
    pen_scene_free(freeze_torus(20, 15, true));
}
END_TEST

/* Joining takes time in proportion to n log n: seconds, where squares of n would take hours. */
START_TEST(test_solids__many_faces)
{
    begin(541);
    struct pen_scene *scene = freeze_torus(250, random_cases(200), false);
    ck_assert(scene->solids.at[0].closed);
    ck_assert_uint_eq(scene->solids.at[0].count, (uint32_t)(500 * random_cases(200)));
    ck_assert_timed(scene->freeze_ms < 20000);
    pen_scene_free(scene);
}
END_TEST

/* A solid with a written index of 1 is one where its box meets that of a solid with another index,
 * and no solid elsewhere; nor is what has no inside. */
START_TEST(test_solids__an_index_of_one)
{
    for (int i = 0; i < 200; i++) {
        begin(600 + (uint64_t)i);
        struct pen_material one = glass(1);
        one.ior_written = true;
        const int glassy = kit_material(&kit, glass(1.5)), air = kit_material(&kit, one),
                  plain = kit_material(&kit, glass(1));
        struct pen_box box[40];
        bool is_glass[40];
        uint32_t wanted = 0, boxes = 2 + random_below(&random_state, 39);
        for (uint32_t k = 0; k < boxes; k++) {
            const vec3 c = random_vec(&random_state, 5);
            const double half = random_in(&random_state, 0.1, 1.5);
            is_glass[k] = k == 0 || random_bits(&random_state) & 1;
            box[k].lo = pen_sub(c, pen_vec3(half, half, half));
            box[k].hi = pen_add(c, pen_vec3(half, half, half));
            add_box(c.x, c.y, c.z, half, is_glass[k] ? glassy : air, ANY_TURN);
        }
        for (uint32_t k = 0; k < boxes; k++) {
            bool meets = is_glass[k];
            for (uint32_t n = 0; n < boxes && !meets; n++)
                meets = is_glass[n] && box[n].lo.x <= box[k].hi.x && box[n].hi.x >= box[k].lo.x &&
                        box[n].lo.y <= box[k].hi.y && box[n].hi.y >= box[k].lo.y &&
                        box[n].lo.z <= box[k].hi.z && box[n].hi.z >= box[k].lo.z;
            wanted += meets;
        }
        kit_sphere(&kit, pen_vec3(0, 0, 0), 1, plain);
        kit_plane(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), air);
        kit_cylinder(&kit, pen_vec3(0, 0, 0), pen_vec3(0, 0, 1), 1, 1, air)->u.cylinder.caps =
            false;
        shuffle();
        check(wanted, wanted);
    }
}
END_TEST

/* Triangles without area that fill the seam between an edge and its parts close a box; those that
 * fold back on themselves change nothing. */
START_TEST(test_solids__what_is_left_out_closes)
{
    for (int i = 0; i < 64; i++) {
        begin(700 + (uint64_t)i);
        const int m = kit_material(&kit, glass(1.5)), other = kit_material(&kit, glass(1.4));
        const vec3 a = pen_vec3(0, 0, 0), b = pen_vec3(4, 0, 0), half = pen_vec3(1, 0, 0);
        const vec3 front[5] = {a, half, b, pen_vec3(4, 0, 3), pen_vec3(0, 0, 3)};
        const int five[5] = {0, 1, 2, 3, 4};
        const vec3 seam[3] = {a, half, b}, fold[3] = {a, b, a}, point[3] = {b, b, b};
        const int three[3] = {0, 1, 2};
        const bool fills = i & 1, folds = i & 2, own = !(i & 4);
        add_faces(a, pen_vec3(4, 2, 3), 63 - 4, false, m, ANY_TURN); /* all but y = 0 */
        add_face(front, five, 5, m, ANY_TURN);
        const uint32_t first = kit.desc.object_count;
        if (fills)
            add_face(seam, three, 3, own ? m : other, ANY_TURN);
        if (folds) {
            add_face(fold, three, 3, m, ANY_TURN);
            add_face(point, three, 3, m, ANY_TURN);
        }
        for (uint32_t k = first; k < kit.desc.object_count; k++) {
            kit.objects[k].left_out = true;
            kit.desc.left_out_count++;
            kit.desc.left_out_vertices += 3;
            kit.desc.primitive_count--;
        }
        struct pen_transform turn = pen_transform_identity();
        if (i & 8) {
            turn = pen_transform_make(1.7, pen_vec3(1, 2, 3), 40, pen_vec3(5, 0, 1));
            kit_group(&kit, 0, &turn);
        } else {
            shuffle();
        }
        struct pen_scene *scene = freeze(1, fills && own);
        ck_assert_uint_eq(scene->solids.at[0].count, 6);
        pen_scene_free(scene);
    }
}
END_TEST

PEN_SUITE("solids", test_solids__an_index_of_one, test_solids__what_is_left_out_closes,
          test_solids__boxes_in_any_order, test_solids__contains_along_edges,
          test_solids__boxes_that_touch, test_solids__stacked_boxes,
          test_solids__stacked_boxes_in_any_order, test_solids__open_boxes, test_solids__strips,
          test_solids__materials, test_solids__numbers, test_solids__torus,
          test_solids__one_side_and_no_border, test_solids__many_faces)
