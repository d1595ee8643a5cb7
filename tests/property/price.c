/* SPDX-License-Identifier: MIT */
/* Times the methods of price_kernel.h, and the traversal's own lists of four primitives at a time.
 */
#include "property/price.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "property/price_methods.h"

enum { ROUNDS = 15 };

static struct price_set *set;
static const struct pen_accel *list[PEN_PRIM_KIND_COUNT];
static enum pen_isa list_isa;

static struct plain3 plain(struct pen_vec3 v)
{
    return (struct plain3){(float)v.x, (float)v.y, (float)v.z};
}

static void make_columns(int i)
{
    for (int k = 0; k < 9; k++) {
        double x = pen_component(set->triangle[i][k / 3], k % 3);
        set->triangle_soa[k][i] = x;
        set->triangle_soa_f[k][i] = (float)x;
    }
    for (int k = 0; k < 4; k++) {
        double x = k < 3 ? pen_component(set->center[i], k) : set->radius[i];
        set->sphere_soa[k][i] = x;
        set->sphere_soa_f[k][i] = (float)x;
    }
}

/* Primitives of about a tenth of the unit cube, so that a ray meets a few of 64. */
static void make_primitive(struct random *r, int i)
{
    struct pen_vec3 c = random_vec(r, 1), a = random_direction(r),
                    b = pen_cross(a, random_direction(r));
    struct pen_vec3 corner[4] = {c, pen_along(c, a, .5),
                                 pen_add(pen_along(c, a, .5), pen_scale(b, .5)),
                                 pen_along(c, b, .5)};
    double radius = random_in(r, .1, .3);
    for (int k = 0; k < 3; k++) {
        set->triangle[i][k] = corner[k];
        set->triangle_f[i][k] = plain(corner[k]);
    }
    set->center[i] = c;
    set->center_f[i] = plain(c);
    set->axis[i] = a;
    set->axis_f[i] = plain(a);
    set->radius[i] = radius;
    set->radius_f[i] = (float)radius;
    make_columns(i);
    world_triangle(&set->world[PEN_PRIM_TRIANGLE], corner[0], corner[1], corner[2]);
    world_polygon(&set->world[PEN_PRIM_POLYGON], corner, 4);
    world_sphere(&set->world[PEN_PRIM_SPHERE], c, radius);
    world_infinite_cylinder(&set->world[PEN_PRIM_INFINITE_CYLINDER], c, a, .2 * radius);
    world_cylinder(&set->world[PEN_PRIM_CYLINDER], c, a, radius, PRICE_HEIGHT, true);
    world_plane(&set->world[PEN_PRIM_PLANE], c, a);
}

static void make_set(void)
{
    struct random r = {12, 12};
    struct pen_status st;
    if (set)
        return;
    set = aligned_alloc(64, (sizeof *set + 63) / 64 * 64);
    struct pen_arena *arena = pen_arena_new(0);
    if (!set || !arena)
        abort();
    for (int k = 0; k < PEN_PRIM_KIND_COUNT; k++)
        world_clear(&set->world[k]);
    for (int i = 0; i < PRICE_PRIMS; i++)
        make_primitive(&r, i);
    for (int i = 0; i < PRICE_RAYS; i++) {
        struct pen_vec3 o = pen_scale(random_direction(&r), 4);
        if (!pen_ray_make(&set->ray[i], o, pen_sub(random_vec(&r, 1), o)))
            abort();
    }
    for (int k = 0; k < PEN_PRIM_KIND_COUNT; k++)
        list[k] = pen_accel_build(&set->world[k].prims, PEN_ACCEL_NONE, arena, &st);
    list_isa = pen_cpu_isa();
}

static double through_list(enum pen_prim_kind kind, const struct pen_ray *ray)
{
    struct pen_t_interval interval = {pen_after_start, INFINITY};
    struct pen_hit hit = {INFINITY, PEN_NO_PRIM, 0};
    pen_trace_ops_get(list_isa)->nearest(list[kind], ray, &pen_origin_none, &interval, &hit);
    return hit.t;
}

static double list_triangle(const struct price_set *unused, const struct pen_ray *ray)
{
    (void)unused;
    return through_list(PEN_PRIM_TRIANGLE, ray);
}

static double list_polygon(const struct price_set *unused, const struct pen_ray *ray)
{
    (void)unused;
    return through_list(PEN_PRIM_POLYGON, ray);
}

static double list_sphere(const struct price_set *unused, const struct pen_ray *ray)
{
    (void)unused;
    return through_list(PEN_PRIM_SPHERE, ray);
}

static double list_cylinder(const struct price_set *unused, const struct pen_ray *ray)
{
    (void)unused;
    return through_list(PEN_PRIM_CYLINDER, ray);
}

static double list_plane(const struct price_set *unused, const struct pen_ray *ray)
{
    (void)unused;
    return through_list(PEN_PRIM_PLANE, ray);
}

static const struct price_method lists[] = {
    {"triangle", "robust, as rendered: lists of 4 at a time", list_triangle},
    {"polygon of 4", "robust, as rendered: lists of 4 at a time", list_polygon},
    {"sphere", "robust, as rendered: lists of 4 at a time", list_sphere},
    {"cylinder", "robust, as rendered: lists of 4 at a time", list_cylinder},
    {"plane", "robust, as rendered: lists of 4 at a time", list_plane},
};

/* Method i of all; the variant with FMA only where the processor has it. */
static const struct price_method *method_at(int i)
{
    int own = (int)(sizeof lists / sizeof lists[0]);
    if (i < own)
        return &lists[i];
    return pen_cpu_isa() >= PEN_ISA_AVX2 ? price_method_avx2(i - own) : price_method_base(i - own);
}

static double run_calls(const struct price_method *m, long calls)
{
    double sum = 0;
    for (long i = 0; i < calls; i++) {
        double t = m->run(set, &set->ray[i % PRICE_RAYS]);
        sum += t < 1e9 ? t : 1;
    }
    return sum;
}

static int by_value(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

int price_measure(struct price out[PRICE_MAX])
{
    static double ns[PRICE_MAX][ROUNDS];
    static volatile double sink;
    const long calls = 20 * PRICE_RAYS;
    const struct price_method *m;
    int count = 0;
    make_set();
    for (int round = -1; round < ROUNDS; round++) { /* the first warms up */
        for (count = 0; count < PRICE_MAX && (m = method_at(count)); count++) {
            int64_t begun = pen_clock_ns();
            sink = run_calls(m, calls);
            if (round >= 0)
                ns[count][round] = (double)(pen_clock_ns() - begun) / (double)(calls * PRICE_PRIMS);
        }
    }
    (void)sink;
    for (int i = 0; i < count; i++) {
        m = method_at(i);
        qsort(ns[i], ROUNDS, sizeof ns[i][0], by_value);
        out[i] = (struct price){m->primitive, m->name, ns[i][ROUNDS / 2], 0};
    }
    return count;
}

bool price_run(int i, long calls)
{
    static volatile double sink;
    make_set();
    const struct price_method *m = i >= 0 && i < PRICE_MAX ? method_at(i) : NULL;
    if (m)
        sink = run_calls(m, calls);
    (void)sink;
    return m != NULL;
}

/* Instructions of a whole run by callgrind; 0 if that can not be had. */
static double instructions(const char *program, int i, long calls)
{
    char command[1024], line[256];
    double found = 0;
    snprintf(command, sizeof command,
             "valgrind --tool=callgrind --callgrind-out-file=/dev/null '%s' --price-of %d %ld 2>&1",
             program, i, calls);
    FILE *f = popen(command, "r");
    if (!f)
        return 0;
    while (fgets(line, sizeof line, f)) {
        char *at = strstr(line, "Collected : ");
        if (at)
            found = strtod(at + 12, NULL);
    }
    pclose(f);
    return found;
}

void price_count(const char *program, struct price out[PRICE_MAX], int count)
{
    const long few = PRICE_RAYS, many = 11 * PRICE_RAYS;
    if (system("command -v valgrind >/dev/null 2>&1") != 0)
        return;
    for (int i = 0; i < count; i++) {
        double a = instructions(program, i, few), b = instructions(program, i, many);
        if (a > 0 && b > a)
            out[i].instructions = (b - a) / (double)((many - few) * PRICE_PRIMS);
    }
}
