/* SPDX-License-Identifier: MIT */
/* The speed of traversal: millions of rays per second and thread, by scene, kind of ray and
 * instruction set. Prints one line for each scene and instruction set. Compare numbers within one
 * run only: between runs the machine's speed changes.
 *
 * usage: bench_accel [all|room|bumpy|soup] [rays] [base|avx2|avx512] [accelerator] */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "accel/accel.h"
#include "base/clock.h"
#include "support/random.h"

/* A scene's primitives and its view. The arrays have a fixed capacity and are never freed. */
struct bench_scene {
    struct pen_prims prims;
    struct pen_prim_ref *ref;
    struct pen_sphere *sphere;
    struct pen_plane *plane;
    struct pen_triangle *triangle;
    struct pen_polygon *polygon;
    struct pen_cylinder *cylinder;
    struct pen_arena *arena;
    struct pen_vec3 eye, forward, light;
    double spread;
};

static void *need(void *p)
{
    if (!p)
        exit(1);
    return p;
}

static struct bench_scene *scene_new(size_t capacity)
{
    struct bench_scene *b = need(calloc(1, sizeof *b));
    b->arena = need(pen_arena_new(0));
    b->ref = need(calloc(capacity, sizeof *b->ref));
    b->sphere = need(calloc(capacity, sizeof *b->sphere));
    b->plane = need(calloc(capacity, sizeof *b->plane));
    b->triangle = need(calloc(capacity, sizeof *b->triangle));
    b->polygon = need(calloc(capacity, sizeof *b->polygon));
    b->cylinder = need(calloc(capacity, sizeof *b->cylinder));
    b->prims = (struct pen_prims){.ref = b->ref,
                                  .sphere = b->sphere,
                                  .plane = b->plane,
                                  .triangle = b->triangle,
                                  .polygon = b->polygon,
                                  .cylinder = b->cylinder};
    return b;
}

static uint32_t add(struct bench_scene *b, uint32_t kind)
{
    uint32_t index = b->prims.kind_count[kind]++;
    b->ref[b->prims.count].kind = kind & 15u;
    b->ref[b->prims.count++].index = index & 0x0fffffffu;
    return index;
}

static void add_box(struct bench_scene *b, struct pen_vec3 lo, struct pen_vec3 hi)
{
    static const int face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
    for (int f = 0; f < 6; f++) {
        struct pen_vec3 *v = need(pen_arena_alloc(b->arena, 4, sizeof *v));
        for (int i = 0; i < 4; i++) {
            int c = face[f][i];
            v[i] = pen_vec3(c & 1 ? hi.x : lo.x, c & 2 ? hi.y : lo.y, c & 4 ? hi.z : lo.z);
        }
        pen_polygon_make(&b->polygon[add(b, PEN_PRIM_POLYGON)], v, 4);
    }
}

/* 48 faces of boxes, 40 cylinders and 30 spheres between five planes: floor, ceiling and walls. */
static struct bench_scene *room(void)
{
    struct bench_scene *b = scene_new(4096);
    struct random r = random_begin(7);
    double wall[5][6] = {{0, -0.5, 0, 0, 1, 0},
                         {0, 0.5, 0, 0, -1, 0},
                         {-0.5, 0, 0, 1, 0, 0},
                         {0.5, 0, 0, -1, 0, 0},
                         {0, 0, -0.5, 0, 0, 1}};
    for (int i = 0; i < 5; i++)
        pen_plane_make(&b->plane[add(b, PEN_PRIM_PLANE)],
                       pen_vec3(wall[i][0], wall[i][1], wall[i][2]),
                       pen_vec3(wall[i][3], wall[i][4], wall[i][5]));
    for (int i = 0; i < 8; i++) {
        struct pen_vec3 c = pen_add(random_vec(&r, 0.35), pen_vec3(0, -0.1, -0.1));
        add_box(b, c, pen_add(c, pen_vec3(0.15, 0.03 + 0.1 * random_unit(&r), 0.1)));
    }
    for (int i = 0; i < 40; i++) {
        struct pen_vec3 c = random_vec(&r, 0.4);
        pen_cylinder_make(&b->cylinder[add(b, PEN_PRIM_CYLINDER)], c,
                          i & 1 ? pen_vec3(0, 1, 0) : random_direction(&r), 0.015,
                          random_in(&r, 0.05, 0.3), true);
    }
    for (int i = 0; i < 30; i++)
        pen_sphere_make(&b->sphere[add(b, PEN_PRIM_SPHERE)], random_vec(&r, 0.4),
                        random_in(&r, 0.01, 0.06));
    b->eye = pen_vec3(0, 0.05, 1.2);
    b->forward = pen_vec3(0, -0.05, -1);
    b->light = pen_vec3(0.1, 0.45, 0.2);
    b->spread = 0.35;
    return b;
}

/* A point of a bumpy sphere, for a vertex of an n x n grid. */
static struct pen_vec3 bumpy_point(int i, int j, int n)
{
    double u = 2.0 * i / n - 1, v = 2.0 * j / n - 1, s = 1 - fabs(u) - fabs(v);
    struct pen_vec3 p = pen_vec3(u, v, s); /* the octahedral map of the square to the sphere */
    if (s < 0)
        p = pen_vec3((1 - fabs(v)) * (u < 0 ? -1 : 1), (1 - fabs(u)) * (v < 0 ? -1 : 1), s);
    p = pen_normalize(p);
    double x = 20 * p.x, y = 20 * p.y, z = 20 * p.z;
    double bump = (x - floor(x)) * (ceil(x) - x) + (y - floor(y)) * (ceil(y) - y) +
                  (z - floor(z)) * (ceil(z) - z);
    return pen_scale(p, 0.45 + 0.03 * bump);
}

/* A closed surface of 980 000 triangles. */
static struct bench_scene *bumpy(void)
{
    int n = 700;
    struct bench_scene *b = scene_new((size_t)n * (size_t)n * 2);
    for (int i = 0; i < n; i++) {
        for (int j = 0; j < n; j++) {
            struct pen_vec3 p = bumpy_point(i, j, n), q = bumpy_point(i + 1, j, n);
            struct pen_vec3 s = bumpy_point(i + 1, j + 1, n), t = bumpy_point(i, j + 1, n);
            pen_triangle_make(&b->triangle[add(b, PEN_PRIM_TRIANGLE)], p, q, s);
            pen_triangle_make(&b->triangle[add(b, PEN_PRIM_TRIANGLE)], p, s, t);
        }
    }
    b->eye = pen_vec3(0.2, 0.3, 1.5);
    b->forward = pen_vec3(-0.2, -0.3, -1.5);
    b->light = pen_vec3(1, 1, 1);
    b->spread = 0.35;
    return b;
}

/* 500 000 small triangles at random places. */
static struct bench_scene *soup(void)
{
    uint32_t n = 500000;
    struct bench_scene *b = scene_new(n);
    struct random r = random_begin(3);
    for (uint32_t i = 0; i < n; i++) {
        struct pen_vec3 c = random_vec(&r, 0.5);
        pen_triangle_make(&b->triangle[add(b, PEN_PRIM_TRIANGLE)], c,
                          pen_add(c, random_vec(&r, 0.01)), pen_add(c, random_vec(&r, 0.01)));
    }
    b->eye = pen_vec3(0.2, 0.3, 1.5);
    b->forward = pen_vec3(-0.2, -0.3, -1.5);
    b->light = pen_vec3(1, 1, 1);
    b->spread = 0.35;
    return b;
}

struct query {
    struct pen_vec3 o, d;
    struct pen_origin_surface origin;
};

/* Traces rays of one kind; returns millions of rays per second. The results are added to *sum, so
 * that the compiler cannot leave the work out. */
static double trace_rays(const struct pen_accel *accel, const struct pen_trace_ops *ops,
                         const struct query *query, size_t count, bool shadow, uint64_t *sum)
{
    uint32_t last = PEN_NO_PRIM;
    int64_t start = pen_clock_cpu_ns();
    for (size_t i = 0; i < count; i++) {
        struct pen_ray ray;
        pen_ray_make(&ray, query[i].o, query[i].d);
        if (shadow) {
            struct pen_shadow light;
            light.tmax = 1;
            light.to_point = true;
            light.see_through = NULL;
            light.last_occluder = last;
            *sum += ops->shadow(accel, &ray, &query[i].origin, &light);
            last = light.last_occluder;
        } else {
            struct pen_t_interval interval = {pen_after_start, INFINITY};
            struct pen_hit hit;
            *sum += ops->nearest(accel, &ray, &query[i].origin, &interval, &hit) ? hit.prim : 0;
        }
    }
    return (double)count / (double)(pen_clock_cpu_ns() - start) * 1e3;
}

static size_t make_queries(const struct bench_scene *b, const struct pen_accel *accel, size_t side,
                           struct query *primary, struct query *shadow, struct query *bounce)
{
    struct pen_vec3 f = pen_normalize(b->forward);
    struct pen_vec3 right = pen_normalize(pen_cross(f, pen_vec3(0, 1, 0))),
                    up = pen_cross(right, f);
    const struct pen_trace_ops *ops = pen_trace_ops_get(pen_cpu_isa());
    struct random r = random_begin(11);
    size_t hits = 0;
    for (size_t i = 0; i < side * side; i++) {
        double x = (2.0 * (double)(i % side) + 1) / (double)side - 1;
        double y = (2.0 * (double)(i / side) + 1) / (double)side - 1;
        struct pen_vec3 d = pen_along(pen_along(f, right, b->spread * x), up, -b->spread * y);
        primary[i] = (struct query){.o = b->eye, .d = d, .origin = pen_origin_none};
        struct pen_ray ray;
        struct pen_t_interval interval = {pen_after_start, INFINITY};
        struct pen_hit hit;
        pen_ray_make(&ray, b->eye, d);
        if (!ops->nearest(accel, &ray, &pen_origin_none, &interval, &hit))
            continue;
        struct pen_vec3 p = pen_prim_point(&b->prims, hit, &ray);
        struct pen_vec3 n = pen_prim_normal(&b->prims, hit, p), any = random_direction(&r);
        struct pen_origin_surface origin = pen_origin_at(&b->prims, &ray, &pen_origin_none, hit, p);
        if (pen_dot(n, d) > 0)
            n = pen_neg(n);
        shadow[hits] = (struct query){.o = p, .d = pen_sub(b->light, p), .origin = origin};
        bounce[hits++] =
            (struct query){.o = p, .d = pen_dot(any, n) > 0 ? any : pen_neg(any), .origin = origin};
    }
    return hits;
}

static void run(const char *name, const struct bench_scene *b, enum pen_accelerator kind,
                size_t side, const char *only)
{
    static const char *const names[PEN_ACCEL_COUNT] = {[PEN_ACCEL_AUTO] = "auto",
                                                       [PEN_ACCEL_NONE] = "none",
                                                       [PEN_ACCEL_CBR] = "cbr",
                                                       [PEN_ACCEL_MANUAL] = "manual",
                                                       [PEN_ACCEL_MEDIAN] = "median"};
    struct pen_status st;
    int64_t start = pen_clock_cpu_ns();
    struct pen_accel *accel = need(pen_accel_build(&b->prims, kind, b->arena, &st));
    double cpu_ms = (double)(pen_clock_cpu_ns() - start) * 1e-6;
    const struct pen_accel_stats *stats = pen_accel_get_stats(accel);
    printf("%s %s: %u primitives, %u nodes, %u leaves, depth %u, %.1f MiB, cost %.2f, %.0f ms, cpu "
           "%.0f ms\n",
           name, names[kind], b->prims.count, stats->nodes, stats->leaves, stats->depth,
           (double)stats->bytes / 0x1p20, stats->sah_cost, stats->build_ms, cpu_ms);
    size_t n = side * side;
    struct query *primary = need(calloc(n, sizeof *primary));
    struct query *shadow = need(calloc(n, sizeof *shadow));
    struct query *bounce = need(calloc(n, sizeof *bounce));
    size_t hits = make_queries(b, accel, side, primary, shadow, bounce);
    for (int isa = 0; isa < PEN_ISA_COUNT && pen_cpu_runs((enum pen_isa)isa); isa++) {
        const struct pen_trace_ops *ops = pen_trace_ops_get((enum pen_isa)isa);
        if (only && strcmp(only, ops->name) != 0)
            continue;
        uint64_t sum = 0;
        double best[3] = {0};
        for (int k = 0; k < 5; k++) {
            double rate[3] = {trace_rays(accel, ops, primary, n, false, &sum),
                              trace_rays(accel, ops, shadow, hits, true, &sum),
                              trace_rays(accel, ops, bounce, hits, false, &sum)};
            for (int i = 0; i < 3; i++)
                best[i] = rate[i] > best[i] ? rate[i] : best[i];
        }
        printf("  %-6s Mray/s: primary %6.2f  shadow %6.2f  bounce %6.2f   (%016llx)\n", ops->name,
               best[0], best[1], best[2], (unsigned long long)sum);
    }
    free(primary);
    free(shadow);
    free(bounce);
}

static enum pen_accelerator kind_of(const char *name)
{
    switch (name[0]) {
    case 'n':
        return PEN_ACCEL_NONE;
    case 'c':
        return PEN_ACCEL_CBR;
    case 'm':
        return name[1] == 'a' ? PEN_ACCEL_MANUAL : PEN_ACCEL_MEDIAN;
    default:
        return PEN_ACCEL_AUTO;
    }
}

int main(int argc, char **argv)
{
    const char *which = argc > 1 ? argv[1] : "all";
    const char *only = argc > 3 && argv[3][0] ? argv[3] : NULL;
    size_t side = argc > 2 ? (size_t)sqrt(atof(argv[2])) : 512;
    enum pen_accelerator kind = kind_of(argc > 4 ? argv[4] : "auto");
    if (!strcmp(which, "all") || !strcmp(which, "room"))
        run("room", room(), kind, side, only);
    if (!strcmp(which, "all") || !strcmp(which, "bumpy"))
        run("bumpy", bumpy(), kind, side, only);
    if (!strcmp(which, "all") || !strcmp(which, "soup"))
        run("soup", soup(), kind, side, only);
    return 0;
}
