/* SPDX-License-Identifier: MIT */
/* Building the closed rooms of rooms.h. */
#include "support/rooms.h"

typedef struct pen_vec3 vec3;

/* The world to which a room is added, and the room's frame, which is rotated and moved far away. */
struct builder {
    struct world *w;
    struct random *r;
    vec3 x, y, z, at;
};

static struct builder begin(struct world *w, struct random *r, double far)
{
    struct builder b = {w, r, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {far, -.5 * far, .25 * far}};
    if (random_below(r, 2)) {
        b.x = random_direction(r);
        b.y = pen_normalize(pen_cross(b.x, random_direction(r)));
        b.z = pen_cross(b.x, b.y);
    }
    world_clear(w);
    return b;
}

static vec3 put(const struct builder *b, double x, double y, double z)
{
    return pen_add(b->at, pen_along(pen_along(pen_scale(b->x, x), b->y, y), b->z, z));
}

static void add_face(struct builder *b, const vec3 *v, int count)
{
    vec3 back[8];
    for (int i = 0; i < count; i++)
        back[i] = v[count - 1 - i];
    world_polygon(b->w, random_below(b->r, 2) ? v : back, (uint32_t)count);
}

static void add_triangle(struct builder *b, vec3 p, vec3 q, vec3 s)
{
    if (random_below(b->r, 2))
        world_triangle(b->w, p, q, s);
    else
        world_triangle(b->w, p, s, q);
}

/* A prism over an outline of n corners, from z = -1 to 1. */
static void add_prism(struct builder *b, const double (*xy)[2], int n)
{
    vec3 low[8], high[8];
    for (int i = 0; i < n; i++) {
        low[i] = put(b, xy[i][0], xy[i][1], -1);
        high[i] = put(b, xy[i][0], xy[i][1], 1);
    }
    for (int i = 0; i < n; i++) {
        int k = (i + 1) % n;
        const vec3 wall[4] = {low[i], low[k], high[k], high[i]};
        add_face(b, wall, 4);
    }
    add_face(b, low, n);
    add_face(b, high, n);
}

/* Corner c of a face of the cube, or its middle, c = 4, at `depth`. */
static vec3 cube_corner(const struct builder *b, int face, int c, double depth)
{
    double p[3];
    p[face / 2] = (face & 1 ? 1 : -1) * (c < 4 ? 1 : depth);
    p[(face / 2 + 1) % 3] = c == 4 ? 0 : c == 1 || c == 2 ? 1 : -1;
    p[(face / 2 + 2) % 3] = c == 4 ? 0 : c >= 2 ? 1 : -1;
    return put(b, p[0], p[1], p[2]);
}

static void add_cube(struct builder *b, bool folded)
{
    for (int face = 0; face < 6; face++) {
        vec3 v[5];
        double depth = random_in(b->r, .7, 1.3);
        for (int c = 0; c < 5; c++)
            v[c] = cube_corner(b, face, c, depth);
        if (!folded) {
            add_triangle(b, v[0], v[1], v[2]);
            add_triangle(b, v[0], v[2], v[3]);
            continue;
        }
        for (int c = 0; c < 4; c++)
            add_triangle(b, v[c], v[(c + 1) % 4], v[4]);
    }
}

/* A ball of 6 x 8 patches whose corners are at 1 to 1.3 from its middle. */
static void add_ball(struct builder *b)
{
    enum { STACKS = 6, SLICES = 8 };
    vec3 grid[STACKS + 1][SLICES];
    for (int i = 0; i <= STACKS; i++) {
        for (int j = 0; j < SLICES; j++) {
            double theta = 3.14159265358979 * i / STACKS, phi = 6.28318530717959 * j / SLICES;
            double size = random_in(b->r, 1, 1.3), s = i % STACKS ? size * sin(theta) : 0;
            grid[i][j] = put(b, s * cos(phi), s * sin(phi), size * cos(theta));
            if (i % STACKS == 0) /* a pole */
                grid[i][j] = grid[i][0];
        }
    }
    for (int i = 0; i < STACKS; i++) {
        for (int j = 0; j < SLICES; j++) {
            int k = (j + 1) % SLICES;
            if (i < STACKS - 1)
                add_triangle(b, grid[i][j], grid[i + 1][j], grid[i + 1][k]);
            if (i > 0)
                add_triangle(b, grid[i][j], grid[i + 1][k], grid[i][k]);
        }
    }
}

vec3 world_room(struct world *w, struct random *r, enum world_room room, double far)
{
    static const double square[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    static const double el[6][2] = {{-1, -1}, {1, -1}, {1, .25}, {.5, .25}, {.5, 1}, {-1, 1}};
    struct builder b = begin(w, r, far);
    if (room == ROOM_L)
        add_prism(&b, el, 6);
    else if (room == ROOM_FOLDED || room == ROOM_TRIANGLES)
        add_cube(&b, room == ROOM_FOLDED);
    else if (room == ROOM_BUMPY)
        add_ball(&b);
    else
        add_prism(&b, square, 4);
    if (room == ROOM_PANE) {
        double z = random_in(r, .5, .8);
        const vec3 pane[4] = {put(&b, -1, -1, z), put(&b, 1, -1, z), put(&b, 1, 1, z),
                              put(&b, -1, 1, z)};
        add_face(&b, pane, 4);
    }
    double x = random_in(r, -.4, .2), y = random_in(r, -.4, .2);
    return put(&b, x, y, random_in(r, -.4, .4));
}

vec3 world_aim(const struct world *w, struct random *r)
{
    uint32_t flats = w->prims.kind_count[PEN_PRIM_TRIANGLE] + w->prims.kind_count[PEN_PRIM_POLYGON];
    uint32_t prim = random_below(r, flats), index = w->ref[prim].index;
    bool three = w->ref[prim].kind == PEN_PRIM_TRIANGLE;
    const vec3 *v = three ? w->triangle[index].v : w->polygon[index].v;
    uint32_t count = three ? 3 : w->polygon[index].count, i = random_below(r, count);
    vec3 e = pen_sub(v[(i + 1) % count], v[i]);
    switch (random_below(r, 3)) {
    case 0:
        return v[i];
    case 1:
        return pen_along(v[i], e, random_unit(r));
    default:
        return pen_along(v[i], e, random_below(r, 9) / 8.);
    }
}

struct stand world_stand(const struct world *w, const struct pen_ray *ray,
                         const struct pen_origin_surface *origin, struct pen_hit hit)
{
    struct stand s = {.hit = hit, .p = pen_prim_point(&w->prims, hit, ray)};
    s.n = pen_prim_normal(&w->prims, hit, s.p);
    double sine = pen_dot(s.n, ray->d) / pen_length(ray->d);
    if (fabs(sine) < PEN_POINT_STEEP)
        s.p = pen_prim_point_in_outline(&w->prims, hit, ray->o, s.p, sine);
    if (sine > 0)
        s.n = pen_neg(s.n);
    s.origin = pen_origin_at(&w->prims, ray, origin, hit, s.p);
    return s;
}

vec3 stand_turn(const struct stand *s, struct random *r, bool through,
                struct pen_origin_surface *origin)
{
    vec3 d = random_direction(r);
    *origin = s->origin;
    origin->through = through;
    return (pen_dot(d, s->n) < 0) != through ? pen_neg(d) : d;
}
