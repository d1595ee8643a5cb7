/* SPDX-License-Identifier: MIT */
/* Rays per second of single rays against meshes, one thread, by the thread's processor time: this
 * tracer and, if it was there when this program was built, Embree in its default and its robust
 * mode. All trace the same rays. In this tracer, shadow and bounce rays start on the surface; for
 * Embree they start 2^-18 above it: nearly all answers are then the same. Medians of RUNS
 * interleaved runs. bench_trace [JSON [MARKDOWN]] */
#include <string.h>
#include <time.h>

#include "accel/accel.h"
#include "bench/median.h"
#include "bench/trace_meshes.h"
#include "math/scale.h"

#ifdef PEN_EMBREE
#include <embree3/rtcore.h>
#endif

enum { WIDTH = 512, RAYS = WIDTH * WIDTH, RUNS = 5 };
enum { PRIMARY, SHADOW, BOUNCE, FAR, KINDS };
enum { OURS, EMBREE, ROBUST, TRACERS };
static const char *const kind_name[KINDS] = {"primary", "shadow", "bounce", "far"};

/* A ray of this tracer, in the local frame. */
struct own_ray {
    struct pen_vec3 o, d;
    struct pen_origin_surface origin;
};

struct result {
    double rate[KINDS][TRACERS];     /* million rays a second */
    uint64_t differ[KINDS][TRACERS]; /* answers that are not those of this tracer */
    uint64_t count[KINDS];
    double build_s, bytes;
};

struct bench {
    const struct trace_mesh *mesh;
    struct pen_mesh own;
    struct pen_prims prims;
    struct pen_prim_ref ref;
    const struct pen_accel *accel;
    const struct pen_trace_ops *ops;
    struct trace_ray *ray[KINDS];
    struct own_ray *own_ray[KINDS];
    uint32_t *answer[TRACERS];
    uint32_t count[KINDS];
#ifdef PEN_EMBREE
    RTCScene scene[TRACERS];
#endif
};

static double seconds(clockid_t clock)
{
    struct timespec t;
    clock_gettime(clock, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static struct pen_vec3 local(const struct bench *b, const float f[3])
{
    return pen_scale(pen_vec3((double)f[0], (double)f[1], (double)f[2]), b->own.unit);
}

static void add_ray(struct bench *b, int kind, const float o[3], const float d[3], float tmax)
{
    const uint32_t i = b->count[kind]++;
    b->ray[kind][i] = (struct trace_ray){{o[0], o[1], o[2]}, {d[0], d[1], d[2]}, tmax};
    b->own_ray[kind][i] = (struct own_ray){local(b, o), local(b, d), pen_origin_none};
}

/* Rays through the pixels of a picture, in tiles of eight by eight. `away`: how many times farther
 * than the mesh's view. */
static void add_camera(struct bench *b, int kind, float away)
{
    float f[3], eye[3], l = 0;
    for (int k = 0; k < 3; k++) {
        f[k] = b->mesh->at[k] - b->mesh->eye[k];
        eye[k] = b->mesh->at[k] - away * f[k];
        l += f[k] * f[k];
    }
    for (int k = 0; k < 3; k++)
        f[k] /= sqrtf(l);
    const float side = sqrtf(f[2] * f[2] + f[0] * f[0]);
    const float r[3] = {f[2] / side, 0, -f[0] / side};
    const float u[3] = {f[1] * r[2] - f[2] * r[1], f[2] * r[0] - f[0] * r[2],
                        f[0] * r[1] - f[1] * r[0]};
    for (uint32_t i = 0; i < RAYS; i++) {
        const uint32_t tile = i / 64;
        const uint32_t px = tile % (WIDTH / 8) * 8 + i % 8,
                       py = tile / (WIDTH / 8) * 8 + i % 64 / 8;
        const float x = (((float)px + .5f) / WIDTH - .5f) * .8f / away,
                    y = (((float)py + .5f) / WIDTH - .5f) * .8f / away;
        float d[3];
        for (int k = 0; k < 3; k++)
            d[k] = f[k] + x * r[k] + y * u[k];
        add_ray(b, kind, eye, d, INFINITY);
    }
}

/* Adds a shadow ray and a bounce ray at a hit of a camera ray. */
static void add_secondary(struct bench *b, const struct own_ray *from, const struct pen_ray *ray,
                          struct pen_hit hit)
{
    const struct pen_vec3 p = pen_prim_point(&b->prims, hit, ray);
    struct pen_vec3 n = pen_prim_normal(&b->prims, hit, p);
    n = pen_dot(n, ray->d) > 0 ? pen_neg(n) : n;
    const struct pen_vec3 at = pen_scale(pen_along(p, n, 0x1p-18), 1 / b->own.unit);
    const float o[3] = {(float)at.x, (float)at.y, (float)at.z};
    const float light[3] = {8 + 2 * trace_random(), 12 + 2 * trace_random(),
                            8 + 2 * trace_random()};
    float q[3], d[3], to[3], qq;
    do {
        qq = 0;
        for (int k = 0; k < 3; k++) {
            q[k] = 2 * trace_random() - 1;
            qq += q[k] * q[k];
        }
    } while (qq > 1 || qq < 1e-4f);
    const float normal[3] = {(float)n.x, (float)n.y, (float)n.z};
    for (int k = 0; k < 3; k++) {
        d[k] = normal[k] + 0.99f * q[k] / sqrtf(qq);
        to[k] = light[k] - o[k];
    }
    add_ray(b, SHADOW, o, to, 1);
    add_ray(b, BOUNCE, o, d, INFINITY);
    const struct pen_origin_surface origin = pen_origin_at(&b->prims, ray, &from->origin, hit, p);
    struct own_ray *own = &b->own_ray[SHADOW][b->count[SHADOW] - 1];
    *own = (struct own_ray){p, pen_sub(local(b, light), p), origin};
    own = &b->own_ray[BOUNCE][b->count[BOUNCE] - 1];
    own->o = p;
    own->origin = origin;
}

static bool trace_own(const struct bench *b, const struct own_ray *from, struct pen_ray *ray,
                      struct pen_hit *hit)
{
    const struct pen_t_interval all = {pen_after_start, INFINITY};
    return pen_ray_make(ray, from->o, from->d) &&
           b->ops->nearest(b->accel, ray, &from->origin, &all, hit);
}

static void run_own(const struct bench *b, int kind)
{
    struct pen_shadow query = {.tmax = 1, .to_point = true};
    for (uint32_t i = 0; i < b->count[kind]; i++) {
        const struct own_ray *from = &b->own_ray[kind][i];
        struct pen_ray ray;
        struct pen_hit hit;
        if (kind == SHADOW) {
            query.last_occluder = PEN_NO_PRIM;
            b->answer[OURS][i] = pen_ray_make(&ray, from->o, from->d) &&
                                 b->ops->shadow(b->accel, &ray, &from->origin, &query);
        } else {
            b->answer[OURS][i] = trace_own(b, from, &ray, &hit) ? hit.prim : PEN_NO_PRIM;
        }
    }
}

#ifdef PEN_EMBREE

static void run_embree(const struct bench *b, int kind, int tracer)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    for (uint32_t i = 0; i < b->count[kind]; i++) {
        const struct trace_ray *r = &b->ray[kind][i];
        struct RTCRayHit h = {.ray = {.org_x = r->o[0],
                                      .org_y = r->o[1],
                                      .org_z = r->o[2],
                                      .dir_x = r->d[0],
                                      .dir_y = r->d[1],
                                      .dir_z = r->d[2],
                                      .tfar = r->tmax,
                                      .mask = ~0u},
                              .hit = {.geomID = RTC_INVALID_GEOMETRY_ID, .primID = PEN_NO_PRIM}};
        if (kind == SHADOW) {
            rtcOccluded1(b->scene[tracer], &context, &h.ray);
            b->answer[tracer][i] = h.ray.tfar < 0;
        } else {
            rtcIntersect1(b->scene[tracer], &context, &h);
            b->answer[tracer][i] = h.hit.primID;
        }
    }
}

static RTCScene embree_scene(RTCDevice device, const struct trace_mesh *m, enum RTCSceneFlags flags)
{
    RTCScene scene = rtcNewScene(device);
    RTCGeometry g = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSceneFlags(scene, flags);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, m->vertex, 0, 12,
                               m->vertices);
    rtcSetSharedGeometryBuffer(g, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, m->corner, 0, 12,
                               m->triangles);
    rtcCommitGeometry(g);
    rtcAttachGeometry(scene, g);
    rtcReleaseGeometry(g);
    rtcCommitScene(scene);
    return scene;
}

#endif

static void run(const struct bench *b, int kind, int tracer)
{
    if (tracer == OURS)
        run_own(b, kind);
#ifdef PEN_EMBREE
    else
        run_embree(b, kind, tracer);
#endif
}

static int tracers(void)
{
#ifdef PEN_EMBREE
    return TRACERS;
#else
    return 1;
#endif
}

static void race(struct bench *b, int kind, struct result *out)
{
    double rate[TRACERS][RUNS];
    out->count[kind] = b->count[kind];
    for (int k = 0; k < RUNS; k++)
        for (int tracer = 0; tracer < tracers(); tracer++) {
            const double begun = seconds(CLOCK_THREAD_CPUTIME_ID);
            run(b, kind, tracer);
            rate[tracer][k] = b->count[kind] / (seconds(CLOCK_THREAD_CPUTIME_ID) - begun) * 1e-6;
        }
    for (int tracer = 0; tracer < tracers(); tracer++) {
        out->rate[kind][tracer] = bench_median(rate[tracer], RUNS);
        out->differ[kind][tracer] = 0;
        for (uint32_t i = 0; i < b->count[kind]; i++)
            out->differ[kind][tracer] += b->answer[tracer][i] != b->answer[OURS][i];
    }
}

static void build(struct bench *b, struct pen_arena *arena, struct result *out)
{
    struct pen_status st;
    b->own = (struct pen_mesh){.vertex = b->mesh->vertex,
                               .corner = b->mesh->corner,
                               .count = b->mesh->triangles,
                               .slots = 1};
    pen_mesh_measure(&b->own);
    const struct pen_vec3 size = pen_sub(b->own.box.hi, b->own.box.lo);
    b->own.unit = pen_scale2(1, -pen_exponent(size.x > size.y ? size.x : size.y));
    b->prims =
        (struct pen_prims){.count = b->own.count, .mesh_count = 1, .mesh = &b->own, .ref = &b->ref};
    const double begun = seconds(CLOCK_PROCESS_CPUTIME_ID);
    b->accel =
        trace_need((void *)(uintptr_t)pen_accel_build(&b->prims, PEN_ACCEL_AUTO, arena, &st));
    out->build_s = seconds(CLOCK_PROCESS_CPUTIME_ID) - begun;
    out->bytes = (double)pen_accel_get_stats(b->accel)->bytes / b->own.count;
    b->ops = pen_trace_ops_get(pen_cpu_isa());
}

static void measure(const struct trace_mesh *mesh, struct result *out)
{
    struct bench b = {.mesh = mesh};
    struct pen_arena *arena = trace_need(pen_arena_new(0));
    build(&b, arena, out);
    for (int kind = 0; kind < KINDS; kind++) {
        b.ray[kind] = trace_need(malloc(RAYS * sizeof *b.ray[kind]));
        b.own_ray[kind] = trace_need(malloc(RAYS * sizeof *b.own_ray[kind]));
    }
    for (int i = 0; i < TRACERS; i++)
        b.answer[i] = trace_need(calloc(RAYS, sizeof *b.answer[i]));
    add_camera(&b, PRIMARY, 1);
    add_camera(&b, FAR, 1000);
    for (uint32_t i = 0; i < RAYS; i++) {
        struct pen_ray ray;
        struct pen_hit hit;
        if (trace_own(&b, &b.own_ray[PRIMARY][i], &ray, &hit))
            add_secondary(&b, &b.own_ray[PRIMARY][i], &ray, hit);
    }
#ifdef PEN_EMBREE
    RTCDevice device = rtcNewDevice("threads=1");
    b.scene[EMBREE] = embree_scene(device, mesh, RTC_SCENE_FLAG_NONE);
    b.scene[ROBUST] = embree_scene(device, mesh, RTC_SCENE_FLAG_ROBUST);
#endif
    for (int kind = 0; kind < KINDS; kind++)
        race(&b, kind, out);
#ifdef PEN_EMBREE
    rtcReleaseScene(b.scene[EMBREE]);
    rtcReleaseScene(b.scene[ROBUST]);
    rtcReleaseDevice(device);
#endif
    for (int kind = 0; kind < KINDS; kind++) {
        free(b.ray[kind]);
        free(b.own_ray[kind]);
    }
    for (int i = 0; i < TRACERS; i++)
        free(b.answer[i]);
    pen_arena_free(arena);
}

/* The mesh of this number; false after the last. */
static bool make_mesh(int number, struct trace_mesh *mesh, const char **name)
{
    static const char *const names[] = {"bumpy-10k", "bumpy-100k", "bumpy-1m", "tori-1m",
                                        "soup-500k"};
    *name = names[number < 5 ? number : 0];
    switch (number) {
    case 0:
        *mesh = trace_grid(71, 70, 0);
        break;
    case 1:
        *mesh = trace_grid(224, 223, 0);
        break;
    case 2:
        *mesh = trace_grid(700, 700, 0);
        break;
    case 3:
        *mesh = trace_grid(100, 80, 1);
        break;
    case 4:
        *mesh = trace_soup(500000);
        break;
    default:
        return false;
    }
    trace_set_view(mesh, number == 3 ? 1 : .3f, number == 3 ? 7 : .8f,
                   number == 3   ? -15
                   : number == 4 ? -8
                                 : -3,
                   number == 3 ? -1 : 0);
    return true;
}

static void put_json(FILE *to, const char *name, const struct trace_mesh *m, const struct result *r)
{
    fprintf(to, "{\"mesh\": \"%s\", \"triangles\": %u, \"build_s\": %.4f, \"tree_bytes\": %.2f",
            name, m->triangles, r->build_s, r->bytes);
    for (int kind = 0; kind < KINDS; kind++) {
        fprintf(to, ", \"%s\": {\"rays\": %llu, \"mrays\": %.3f", kind_name[kind],
                (unsigned long long)r->count[kind], r->rate[kind][OURS]);
        if (tracers() > 1)
            fprintf(to,
                    ", \"embree\": %.3f, \"robust\": %.3f, \"differ\": %llu, \"differ_robust\": "
                    "%llu",
                    r->rate[kind][EMBREE], r->rate[kind][ROBUST],
                    (unsigned long long)r->differ[kind][EMBREE],
                    (unsigned long long)r->differ[kind][ROBUST]);
        fprintf(to, "}");
    }
    fprintf(to, "}");
}

static void put_row(FILE *to, const char *name, const struct trace_mesh *m, const struct result *r)
{
    for (int kind = 0; kind < KINDS; kind++) {
        fprintf(to, "| %s | %s | %.2f |", name, kind_name[kind], r->rate[kind][OURS]);
        if (tracers() > 1)
            fprintf(to, " %.2f | %.2f | %.2f | %.2f | %llu of %llu |", r->rate[kind][EMBREE],
                    r->rate[kind][ROBUST], r->rate[kind][OURS] / r->rate[kind][EMBREE],
                    r->rate[kind][OURS] / r->rate[kind][ROBUST],
                    (unsigned long long)r->differ[kind][ROBUST],
                    (unsigned long long)r->count[kind]);
        fprintf(to, " %.2f | %.1f |\n", r->build_s / m->triangles * 1e6, r->bytes);
    }
    fflush(to);
}

int main(int argc, char **argv)
{
    FILE *json = argc > 1 ? fopen(argv[1], "w") : NULL, *md = argc > 2 ? fopen(argv[2], "w") : NULL;
    FILE *const tables[2] = {stdout, md};
    const char *only = getenv("MESH"), *name;
    struct trace_mesh mesh;
    for (int i = 0; i < 2; i++)
        if (tables[i])
            fprintf(
                tables[i],
                tracers() > 1
                    ? "| mesh | rays | Mray/s | Embree | robust | ratio | ratio to robust | other "
                      "answers | build, s per million | tree, bytes per triangle "
                      "|\n|---|---|--:|--:|--:|--:|--:|--:|--:|--:|\n"
                    : "| mesh | rays | Mray/s | build, s per million | tree, bytes per triangle "
                      "|\n|---|---|--:|--:|--:|\n");
    if (json)
        fprintf(json, "[");
    for (int i = 0, put = 0; make_mesh(i, &mesh, &name); i++) {
        struct result r = {.build_s = 0};
        const bool left_out = only && !strstr(name, only);
        if (!left_out)
            measure(&mesh, &r);
        for (int k = 0; k < 2 && !left_out; k++)
            if (tables[k])
                put_row(tables[k], name, &mesh, &r);
        if (json && !left_out) {
            fprintf(json, put++ ? ",\n " : "");
            put_json(json, name, &mesh, &r);
        }
        free(mesh.vertex);
        free(mesh.corner);
    }
    if (json)
        fprintf(json, "]\n");
    return (json && fclose(json)) || (md && fclose(md));
}
