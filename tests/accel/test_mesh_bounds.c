/* SPDX-License-Identifier: MIT */
/* What the test of a mesh's blocks claims in binary32 (accel/internal/mesh_ray.h), against the
 * exact test of the stored triangles: a lane that is out is not met, one that is sure is met
 * between its bounds. Rays pass borders and planes at distances about as large as the rounding.
 * Without a bound of src/accel/MESHES.md, this test fails. */
#include "accel/internal/mesh_ray.h"
#include "accel/internal/test_doors.h"
#include "geom/triangle.h"
#include "support/suite.h"
#include "support/twin.h"

static struct world stored;
static struct twin twin;

/* A mesh of four small triangles near one place, and mostly a large one, in a frame that may be far
 * away. */
static void make_mesh(struct random *r)
{
    const double unit = exp2(-(double)random_below(r, 50)), small = exp2(random_in(r, -24, 0));
    twin_clear(&twin, &stored);
    twin_mesh_begin(&twin, random_below(r, 3) ? random_vec(r, 1) : pen_vec3(0, 0, 0), unit);
    const struct pen_vec3 at = random_vec(r, random_below(r, 2) ? .9 : 4 * small);
    uint32_t v[3];
    for (int i = 0; i < 4; i++) {
        for (int k = 0; k < 3; k++)
            v[k] = twin_vertex(&twin, pen_along(at, random_vec(r, small), 1));
        twin_triangle(&twin, v[0], v[1], v[2]);
    }
    for (int k = 0; k < 3; k++)
        v[k] = twin_vertex(&twin, random_vec(r, 1));
    if (random_below(r, 3))
        twin_triangle(&twin, v[0], v[1], v[2]);
    twin_mesh_end(&twin);
    twin_take(&twin);
}

/* A point of a triangle: on its border, or inside. */
static struct pen_vec3 point_of(struct random *r, const struct pen_triangle *tri)
{
    struct pen_vec3 p = tri->v[random_below(r, 3)];
    for (int i = random_below(r, 2) ? 1 : 2; i > 0; i--)
        p = pen_along(p, pen_sub(tri->v[random_below(r, 3)], p), random_in(r, 0, 1));
    return p;
}

/* About as large as what rounding does: of floats near the mesh, of doubles at a distance of `far`
 * units, or of vertices. */
static double some_error(struct random *r, const struct pen_mesh *mesh, double far)
{
    const double size[3] = {0x1p-22 * mesh->unit, 0x1p-52 * mesh->unit * far,
                            0x1p-53 * pen_norm1(mesh->shift)};
    return size[random_below(r, 3)] * exp2(random_in(r, -4, 3));
}

/* A ray that passes near a border of the triangle or through its inside, from anywhere, along its
 * plane, or from beside its plane. Returns false if there is none. */
static bool make_ray(struct random *r, const struct pen_triangle *tri, struct pen_ray *ray)
{
    const struct pen_mesh *mesh = &twin.prims.mesh[0];
    const double far = exp2(random_below(r, 2) ? random_in(r, -24, 2) : random_in(r, 0, 40));
    struct pen_vec3 p = point_of(r, tri), d = random_direction(r), o;
    const uint32_t how = random_below(r, 4);
    if (how == 0) {
        d = pen_along(
            pen_scale(pen_sub(tri->v[1], tri->v[0]), 1 / pen_norm1(pen_sub(tri->v[1], tri->v[0]))),
            tri->facet.n, exp2(random_in(r, -30, -2)));
        d = random_below(r, 2) ? d : pen_neg(d);
    }
    p = random_below(r, 4) ? pen_along(p, random_direction(r), some_error(r, mesh, far)) : p;
    o = how == 1 ? pen_along(p, tri->facet.n, some_error(r, mesh, 1))
                 : pen_along(p, d, -mesh->unit * far);
    if (how > 1)
        d = pen_sub(p, o);
    return pen_ray_make(ray, o, pen_scale(d, exp2(random_in(r, -2, 2))));
}

/* Whether the line of a ray from o + by enters the triangle, and where. */
static bool met(const struct pen_triangle *tri, const struct pen_ray *ray, struct pen_vec3 by,
                double *t)
{
    struct pen_ray moved;
    return pen_ray_make(&moved, pen_along(ray->o, by, 1), ray->d) &&
           pen_triangle_root(tri, &moved, t);
}

struct query {
    struct mesh_box box;
    struct mesh_ray mesh;
    double off, limit; /* limit: a t */
};

static void check_lane(struct random *r, const struct pen_triangle *tri, const struct pen_ray *ray,
                       const struct query *q, const struct mesh_lanes *in, int lane, bool any)
{
    double t;
    for (int i = 0; i < 3; i++) {
        const struct pen_vec3 by = i ? random_vec(r, q->off / 2) : pen_vec3(0, 0, 0);
        if (!met(tri, ray, by, &t))
            ck_assert(!(in->sure >> lane & 1));
        else if (t >= 0 && t <= q->limit)
            ck_assert(in->may >> lane & 1);
        else
            ck_assert(!(in->sure >> lane & 1) || (!any && t > 0));
    }
    if (any || !(in->sure >> lane & 1) || !met(tri, ray, pen_vec3(0, 0, 0), &t))
        return;
    const double depth = t * q->box.scale - q->box.moved;
    ck_assert(t > 0 && (double)in->lo[lane] <= depth && depth <= (double)in->hi[lane]);
}

/* A ray enters the box of each triangle that it meets. */
static void check_boxes(struct random *r, const struct pen_ray *ray, const struct query *q)
{
    struct pen_node node;
    float near[PEN_WIDE];
    for (uint32_t i = 0; i < PEN_WIDE; i++) {
        const struct pen_box box = pen_prim_bounds(&stored.prims, i % twin.prims.count);
        const double lo[3] = {box.lo.x, box.lo.y, box.lo.z}, hi[3] = {box.hi.x, box.hi.y, box.hi.z};
        for (int axis = 0; axis < 3; axis++) {
            node.plane[axis][i] = pen_float_down(lo[axis]);
            node.plane[3 + axis][i] = pen_float_up(hi[axis]);
        }
    }
    const unsigned in = mesh_enter_node(&node, &q->box, mesh_box_depth(&q->box, q->limit), near);
    for (uint32_t i = 0; i < 3 * twin.prims.count; i++) {
        double t;
        const struct pen_vec3 by = i % 3 ? random_vec(r, q->off / 2) : pen_vec3(0, 0, 0);
        if (met(&stored.triangle[i / 3], ray, by, &t) && t >= 0 && t <= q->limit)
            ck_assert(in >> i / 3 & 1);
    }
}

static void check_ray(struct random *r, const struct pen_accel *accel, const struct pen_ray *ray,
                      double off, double limit)
{
    const struct pen_mesh *mesh = &twin.prims.mesh[0];
    struct query q = {.off = off, .limit = limit};
    if (!mesh_box_make(&q.box, ray, accel->extent, off, false, 0)) {
        double t;
        for (uint32_t i = 0; i < twin.prims.count; i++)
            ck_assert(!met(&stored.triangle[i], ray, pen_vec3(0, 0, 0), &t) || t < 0);
        return;
    }
    check_boxes(r, ray, &q);
    if (q.box.blind)
        return;
    mesh_ray_make(&q.mesh, mesh, &accel->mesh_frames[0], &q.box, (float)off);
    q.mesh.limit = pen_float_up(
        (limit * q.box.scale - q.box.moved) * accel->mesh_frames[0].inv_unit - q.mesh.moved);
    for (uint32_t block = 0; block < (twin.prims.count + 3) / 4; block++) {
        const struct pen_mesh4 *b = &accel->mesh_blocks[block];
        struct mesh_lanes in[2];
        for (int any = 0; any < 2; any++)
            mesh_ray_test(&q.mesh, b, b, mesh_box_depth(&q.box, limit), any, &in[any]);
        for (int lane = 0; lane < PEN_LANES; lane++)
            for (int any = 0; any < 2 && b->prim[lane] != PEN_NO_PRIM; any++)
                check_lane(r, &stored.triangle[b->prim[lane]], ray, &q, &in[any], lane, any);
    }
}

START_TEST(test_mesh_bounds__hold)
{
    struct random r = random_begin(541);
    for (int scene = 0; scene < random_some(200000, 20000); scene++) {
        struct pen_status st;
        make_mesh(&r);
        struct pen_arena *arena = pen_arena_new(0);
        const struct pen_accel *accel =
            pen_accel_build_choice(&twin.prims, PEN_AUTO_TREE, arena, &st);
        ck_assert_ptr_nonnull(accel);
        for (int i = 0; i < 20 && accel->mesh_frames && twin.prims.count >= 4; i++) {
            const struct pen_triangle *tri = &stored.triangle[random_below(&r, 4)];
            const double off = random_below(&r, 2) ? 0 : exp2(random_in(&r, -40, -4));
            double limit = INFINITY;
            struct pen_ray ray;
            if (!make_ray(&r, tri, &ray))
                continue;
            if (random_below(&r, 2) && met(tri, &ray, pen_vec3(0, 0, 0), &limit))
                limit *= random_below(&r, 2) ? 1 : 1 - exp2(random_in(&r, -30, -2));
            if (limit > 0)
                check_ray(&r, accel, &ray, twin.prims.mesh[0].unit * off, limit);
        }
        pen_arena_free(arena);
    }
}
END_TEST

PEN_SUITE("mesh_bounds", test_mesh_bounds__hold)
