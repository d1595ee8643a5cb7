/* SPDX-License-Identifier: MIT */
#include "support/twin.h"

#include <check.h>

void twin_clear(struct twin *t, struct world *w)
{
    world_clear(w);
    t->stored = w;
    t->prims = w->prims;
    t->prims.ref = t->ref;
    t->prims.mesh = t->mesh;
    t->vertices = t->corners = 0;
}

/* The kinds of primitives outside meshes are those of the stored world; its triangles in meshes are
 * after the others, in an array of the test's own. */
void twin_take(struct twin *t)
{
    const struct pen_mesh *last = t->prims.mesh_count ? &t->mesh[t->prims.mesh_count - 1] : NULL;
    uint32_t slot = last ? last->slot + last->slots : 0;
    slot += t->prims.count - (last ? last->first + last->count : 0);
    for (uint32_t i = t->prims.count; i < t->stored->prims.count; i++)
        t->ref[slot++] = t->stored->ref[i];
    t->prims.count = t->stored->prims.count;
}

void twin_mesh_begin(struct twin *t, struct pen_vec3 shift, double unit)
{
    ck_assert_uint_lt(t->prims.mesh_count, TWIN_MESHES);
    t->mesh[t->prims.mesh_count] = (struct pen_mesh){.vertex = t->vertex + 3 * (size_t)t->vertices,
                                                     .corner = t->corner + 3 * (size_t)t->corners,
                                                     .shift = shift,
                                                     .unit = unit,
                                                     .first = t->prims.count,
                                                     .slot = pen_prim_slots(&t->prims),
                                                     .slots = 1};
}

uint32_t twin_vertex(struct twin *t, struct pen_vec3 v)
{
    const struct pen_mesh *mesh = &t->mesh[t->prims.mesh_count];
    float *to = t->vertex + 3 * (size_t)t->vertices;
    ck_assert_uint_lt(t->vertices, WORLD_MAX);
    to[0] = (float)v.x;
    to[1] = (float)v.y;
    to[2] = (float)v.z;
    t->vertices++;
    return (uint32_t)(to - mesh->vertex) / 3;
}

void twin_triangle(struct twin *t, uint32_t a, uint32_t b, uint32_t c)
{
    struct pen_mesh *mesh = &t->mesh[t->prims.mesh_count];
    struct pen_vec3 v[3];
    struct pen_triangle made;
    uint32_t *to = t->corner + 3 * (size_t)t->corners;
    ck_assert_uint_lt(t->corners, WORLD_MAX);
    to[0] = a;
    to[1] = b;
    to[2] = c;
    pen_mesh_corners(mesh, mesh->count, v);
    if (!pen_triangle_make(&made, v[0], v[1], v[2]))
        return; /* rounding has put the vertices on one line */
    t->corners++;
    mesh->count++;
    world_triangle(t->stored, v[0], v[1], v[2]);
}

void twin_mesh_end(struct twin *t)
{
    struct pen_mesh *mesh = &t->mesh[t->prims.mesh_count];
    if (mesh->count == 0)
        return;
    /* The indices of meshes come after those of all triangles that any test stores. */
    mesh->index = WORLD_MAX + t->prims.count;
    t->prims.kind_count[PEN_PRIM_TRIANGLE] = WORLD_MAX;
    pen_mesh_measure(mesh);
    t->prims.mesh_count++;
    t->prims.count += mesh->count;
    ck_assert_uint_eq(t->prims.count, t->stored->prims.count);
}

void twin_ball(struct twin *t, struct random *r, uint32_t stacks, uint32_t slices)
{
    uint32_t at[65][64];
    ck_assert(stacks <= 64 && slices <= 64);
    for (uint32_t i = 0; i <= stacks; i++) {
        for (uint32_t j = 0; j < slices; j++) {
            double theta = 3.14159265358979 * i / stacks, phi = 6.28318530717959 * j / slices;
            struct pen_vec3 d = pen_vec3(sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta));
            if ((i == 0 || i == stacks) && j > 0)
                at[i][j] = at[i][0];
            else
                at[i][j] = twin_vertex(t, pen_scale(d, random_in(r, 0.6, 1)));
        }
    }
    for (uint32_t i = 0; i < stacks; i++) {
        for (uint32_t j = 0; j < slices; j++) {
            const uint32_t k = (j + 1) % slices;
            if (i < stacks - 1)
                twin_triangle(t, at[i][j], at[i + 1][j], at[i + 1][k]);
            if (i > 0)
                twin_triangle(t, at[i][j], at[i + 1][k], at[i][k]);
        }
    }
}

void twin_hills(struct twin *t, struct random *r, uint32_t side)
{
    const bool flat = random_below(r, 3) == 0;
    for (uint32_t i = 0; i <= side; i++)
        for (uint32_t j = 0; j <= side; j++)
            twin_vertex(t, pen_vec3(2.0 * i / side - 1, 2.0 * j / side - 1,
                                    flat ? 0 : random_in(r, -.1, .1)));
    const uint32_t base =
        (uint32_t)(t->vertex + 3 * (size_t)t->vertices - t->mesh[t->prims.mesh_count].vertex) / 3 -
        (side + 1) * (side + 1);
    for (uint32_t i = 0; i < side; i++) {
        for (uint32_t j = 0; j < side; j++) {
            const uint32_t a = base + i * (side + 1) + j, b = a + side + 1;
            twin_triangle(t, a, b, a + 1);
            twin_triangle(t, a + 1, b, b + 1);
        }
    }
}

void twin_soup(struct twin *t, struct random *r, uint32_t count, double size)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_vec3 c = random_vec(r, 1);
        uint32_t v[3];
        for (int k = 0; k < 3; k++)
            v[k] = twin_vertex(t, pen_along(c, random_vec(r, 1), size));
        twin_triangle(t, v[0], v[1], v[2]);
    }
}
