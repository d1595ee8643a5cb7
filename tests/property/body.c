/* SPDX-License-Identifier: MIT */
#include "property/body.h"

#include <math.h>

#include "property/gen.h"

static const double pi = 3.14159265358979323846;

/* ---- Flat bodies ---- */

static int add_vertex(struct body *b, vec3 v)
{
    b->v[b->vertices] = v;
    return b->vertices++;
}

static void add_face(struct body *b, int count, const int *corner)
{
    for (int i = 0; i < count; i++)
        b->corner[b->faces][i] = corner[i];
    b->corners[b->faces++] = count;
}

static void add_triangle(struct body *b, int i, int j, int k)
{
    add_face(b, 3, (const int[]){i, j, k});
}

/* A prism, or a frustum or pyramid: the outline at the top is `top` times the one at the base. */
static void make_prism(struct body *b, struct random *r, int walls, double top)
{
    double start = random_in(r, 0, 2 * pi);
    bool even = random_below(r, 2);
    int high[BODY_CORNERS],
        low[BODY_CORNERS]; /* the outline at the top; at the base, turned round */
    for (int i = 0; i < walls; i++) {
        double part = i + (even ? 0 : random_in(r, -.2, .2)), a = start + 2 * pi * part / walls;
        low[walls - 1 - i] = add_vertex(b, pen_vec3(cos(a), sin(a), -b->h));
    }
    for (int i = 0; i < walls && top > 0; i++) {
        vec3 v = b->v[low[walls - 1 - i]];
        high[i] = add_vertex(b, pen_vec3(top * v.x, top * v.y, b->h));
    }
    int apex = top > 0 ? 0 : add_vertex(b, pen_vec3(0, 0, b->h));
    add_face(b, walls, low);
    if (top > 0)
        add_face(b, walls, high);
    for (int i = 0; i < walls; i++) {
        int p = low[walls - 1 - i], q = low[walls - 1 - (i + 1) % walls];
        if (top > 0)
            add_face(b, 4, (const int[]){p, q, high[(i + 1) % walls], high[i]});
        else
            add_triangle(b, p, q, apex);
    }
}

static const int box_face[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                   {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};

static void make_box(struct body *b, struct random *r)
{
    vec3 s = random_below(r, 3)
                 ? pen_vec3(random_in(r, .5, 2), random_in(r, .5, 2), random_in(r, .5, 2))
                 : pen_vec3(1, 1, 1);
    for (int i = 0; i < 8; i++)
        add_vertex(b, pen_vec3(i & 1 ? s.x : -s.x, i & 2 ? s.y : -s.y, i & 4 ? s.z : -s.z));
    for (int f = 0; f < 6; f++)
        add_face(b, 4, box_face[f]);
}

/* Each face about its middle, as triangles. */
static void dent(struct body *b, struct random *r)
{
    int faces = b->faces;
    b->faces = 0;
    double how = random_below(r, 2) ? gen_power(r, -9, -.5) : random_in(r, -.4, .4);
    for (int f = 0; f < faces; f++) {
        const int *c = box_face[f];
        vec3 middle = pen_scale(pen_add(b->v[c[0]], b->v[c[2]]), .5 * (1 - how));
        int m = add_vertex(b, middle);
        for (int i = 0; i < 4; i++)
            add_triangle(b, c[i], c[(i + 1) % 4], m);
    }
}

static int between(struct body *b, int i, int j)
{
    vec3 v = pen_normalize(pen_add(b->v[i], b->v[j]));
    for (int k = 0; k < b->vertices; k++)
        if (pen_norm1(pen_sub(b->v[k], v)) < 1e-9)
            return k;
    return add_vertex(b, v);
}

/* An octahedron whose faces are four triangles each, the 18 vertices at any distance. */
static void make_star(struct body *b, struct random *r)
{
    static const vec3 axis[6] = {{1, 0, 0},  {0, 1, 0},  {-1, 0, 0},
                                 {0, -1, 0}, {0, 0, -1}, {0, 0, 1}};
    for (int i = 0; i < 6; i++)
        add_vertex(b, axis[i]);
    for (int f = 0; f < 8; f++) {
        int i = f % 4, j = (i + 1) % 4, k = f < 4 ? 5 : 4;
        if (f >= 4) {
            int other = i;
            i = j;
            j = other;
        }
        int ij = between(b, i, j), jk = between(b, j, k), ki = between(b, k, i);
        add_triangle(b, i, ij, ki);
        add_triangle(b, ij, j, jk);
        add_triangle(b, ki, jk, k);
        add_triangle(b, ij, jk, ki);
    }
    double least = random_below(r, 2) ? .5 : .9;
    for (int i = 0; i < b->vertices; i++)
        b->v[i] = pen_scale(b->v[i], random_in(r, least, 1.2));
}

static void split(struct body *b)
{
    int faces = b->faces;
    for (int f = 0; f < faces; f++) {
        int n = b->corners[f];
        b->corners[f] = 3;
        for (int i = 2; i + 1 < n; i++)
            add_triangle(b, b->corner[f][0], b->corner[f][i], b->corner[f][i + 1]);
    }
}

static void make_tetrahedron(struct body *b, struct random *r)
{
    static const vec3 corner[4] = {{1, 1, 1}, {1, -1, -1}, {-1, 1, -1}, {-1, -1, 1}};
    for (int i = 0; i < 4; i++)
        add_vertex(b, pen_scale(pen_add(corner[i], random_vec(r, .3)), .7));
    add_triangle(b, 0, 1, 2);
    add_triangle(b, 0, 2, 3);
    add_triangle(b, 0, 3, 1);
    add_triangle(b, 1, 3, 2);
}

static void make_flat(struct body *b, struct random *r)
{
    static const int walls[] = {3, 4, 5, 6, 8, 12, 24};
    int n = walls[random_below(r, 7)];
    b->h = random_below(r, 3) ? random_in(r, .4, 1.5) : 1;
    switch ((int)b->kind) {
    case BODY_PRISM:
    case BODY_SPLIT_PRISM:
        make_prism(b, r, b->kind == BODY_SPLIT_PRISM && n > 12 ? 12 : n, 1);
        break;
    case BODY_FRUSTUM:
        make_prism(b, r, n, random_in(r, .3, .95));
        break;
    case BODY_PYRAMID:
        make_prism(b, r, n, 0);
        break;
    case BODY_TETRAHEDRON:
        make_tetrahedron(b, r);
        break;
    case BODY_STAR:
        make_star(b, r);
        break;
    default:
        make_box(b, r);
    }
    if (b->kind == BODY_SPLIT_BOX || b->kind == BODY_SPLIT_PRISM)
        split(b);
    if (b->kind == BODY_DENTED)
        dent(b, r);
}

static bool is_flat(const struct body *b)
{
    return b->kind <= BODY_LAST_CROSSING;
}

static void make_round(struct body *b, struct random *r)
{
    b->r = b->top = random_in(r, .5, 1.2);
    b->h = random_in(r, .5, 1.2);
    b->over = random_below(r, 2) ? random_in(r, 0, .5) : 0;
    if (b->kind == BODY_CONE || (b->kind == BODY_OPEN_CONE && random_below(r, 2)))
        b->top = 0;
    else if (b->kind == BODY_CUT_CONE || b->kind == BODY_OPEN_CONE)
        b->top *= random_below(r, 2) ? random_in(r, .1, .9) : random_in(r, 1.1, 1.6);
    if (b->kind == BODY_SPHERE)
        b->h = b->r;
    double wide = fmax(b->r, b->top);
    b->half = pen_vec3(wide, wide, b->h);
    b->thin = fmin(.4 * b->r, .4 * b->h);
}

void body_make(struct body *b, enum body_kind kind, struct random *r, double thin)
{
    b->kind = kind;
    b->vertices = b->faces = 0;
    b->poke = 0;
    if (!is_flat(b)) {
        make_round(b, r);
        return;
    }
    make_flat(b, r);
    b->over = random_in(r, .1, .5);
    if (kind == BODY_THICK)
        b->over = random_below(r, 2) ? gen_power(r, -6, -1) : random_in(r, .1, .5);
    b->half = pen_vec3(0, 0, 0);
    for (int i = 0; i < b->vertices; i++) {
        b->v[i].z *= thin;
        b->half = pen_vec3(fmax(b->half.x, fabs(b->v[i].x)), fmax(b->half.y, fabs(b->v[i].y)),
                           fmax(b->half.z, fabs(b->v[i].z)));
    }
    b->thin = .2 * fmin(b->half.z, fmin(b->half.x, b->half.y));
}

void body_overlap(struct body *b)
{
    b->poke = b->kind > BODY_LAST_ROUND ? .05 * b->h : 0;
    b->over = fmax(b->over, .2);
}

/* ---- Poses ---- */

struct body_pose body_pose(struct random *r, double size, double offset)
{
    struct body_pose pose = {.size = size, .o = gen_offset3(offset * size)};
    vec3 n = random_direction(r);
    uint32_t how = random_below(r, 4);
    double a = random_below(r, 2) ? 32 * pi / 180 : random_in(r, -pi, pi);
    pose.x = pen_vec3(1, 0, 0);
    pose.y = pen_vec3(0, 1, 0);
    pose.z = pen_vec3(0, 0, 1);
    if (how == 1) {
        pose.x = pen_vec3(cos(a), sin(a), 0);
        pose.y = pen_vec3(-sin(a), cos(a), 0);
    } else if (how > 1) {
        pose.z = n;
        gen_frame(r, n, &pose.x, &pose.y);
    }
    pose.group = random_below(r, 2);
    return pose;
}

vec3 body_turn(const struct body_pose *pose, vec3 d)
{
    return pen_along(pen_along(pen_scale(pose->x, d.x), pose->y, d.y), pose->z, d.z);
}

vec3 body_place(const struct body_pose *pose, vec3 p)
{
    return pen_along(pose->o, body_turn(pose, p), pose->size);
}

double body_rounding(const struct body_pose *pose)
{
    return 64 * 0x1p-53 * (4 * pen_norm1(pose->o) / pose->size + 8);
}

struct pen_transform body_transform(const struct body_pose *pose)
{
    double s = pose->size;
    vec3 x = pose->x, y = pose->y, z = pose->z, o = pose->o;
    return (struct pen_transform){{{s * x.x, s * y.x, s * z.x, o.x},
                                   {s * x.y, s * y.y, s * z.y, o.y},
                                   {s * x.z, s * y.z, s * z.z, o.z}}};
}

vec3 body_vertex(const struct body *b, const struct body_pose *pose, int i)
{
    struct pen_transform transform = body_transform(pose);
    return pose->group ? pen_transform_point(&transform, b->v[i]) : body_place(pose, b->v[i]);
}

/* ---- Into the scene ---- */

static const struct body_pose as_is = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}, 1, false};

static vec3 face_normal(const struct body *b, int f)
{
    const int *c = b->corner[f];
    vec3 e = pen_sub(b->v[c[1]], b->v[c[0]]), g = pen_sub(b->v[c[2]], b->v[c[0]]);
    return pen_normalize(pen_cross(e, g));
}

static void add_polygon(struct kit *kit, const struct body_pose *pose, const vec3 *v, int count,
                        int material)
{
    vec3 w[BODY_CORNERS];
    for (int i = 0; i < count; i++)
        w[i] = body_place(pose, v[i]);
    kit_polygon(kit, w, (uint32_t)count, material);
}

static void add_faces(const struct body *b, const struct body_pose *pose, struct kit *kit,
                      int material)
{
    for (int f = 0; f < b->faces; f++) {
        vec3 v[BODY_CORNERS], n = face_normal(b, f);
        int count = b->corners[f];
        for (int i = 0; i < count; i++)
            v[i] = b->v[b->corner[f][i]];
        if (b->kind == BODY_CROSSING)
            for (int i = 0; i < count; i++) {
                vec3 middle = pen_scale(n, pen_dot(n, v[i]));
                v[i] = pen_along(v[i], pen_sub(v[i], middle), b->over);
            }
        if (b->kind == BODY_PLANES)
            kit_plane(kit, body_place(pose, v[0]), body_turn(pose, n), material);
        else
            add_polygon(kit, pose, v, count, material);
    }
}

/* The six walls as boxes that stand on each other. */
static void add_thick(const struct body *b, const struct body_pose *pose, struct kit *kit,
                      int material)
{
    double t = b->over;
    vec3 h = b->half;
    for (int w = 0; w < 6; w++) {
        vec3 lo = pen_neg(h), hi = h, v[4];
        double out = w % 2 ? t : -t;
        if (w / 2 == 2) { /* base and lid reach under the others */
            lo = pen_sub(lo, pen_vec3(t, t, 0));
            hi = pen_add(hi, pen_vec3(t, t, 0));
            *(w % 2 ? &lo : &hi) =
                pen_vec3(w % 2 ? lo.x : hi.x, w % 2 ? lo.y : hi.y, w % 2 ? h.z : -h.z);
            *(w % 2 ? &hi.z : &lo.z) += out;
        } else if (w / 2 == 1) {
            lo.x -= t;
            hi.x += t;
            *(w % 2 ? &lo.y : &hi.y) = w % 2 ? h.y : -h.y;
            *(w % 2 ? &hi.y : &lo.y) += out;
        } else {
            *(w % 2 ? &lo.x : &hi.x) = w % 2 ? h.x : -h.x;
            *(w % 2 ? &hi.x : &lo.x) += out;
        }
        for (int f = 0; f < 6; f++) {
            for (int i = 0; i < 4; i++) {
                int k = box_face[f][i];
                v[i] = pen_vec3(k & 1 ? hi.x : lo.x, k & 2 ? hi.y : lo.y, k & 4 ? hi.z : lo.z);
            }
            add_polygon(kit, pose, v, 4, material);
        }
    }
}

static void add_cone(const struct body *b, const struct body_pose *pose, struct kit *kit, bool caps,
                     int material)
{
    double s = pose->size, slope = (b->top - b->r) / (2 * b->h), low = -b->h - b->poke;
    double high = b->top > 0 ? b->h + b->poke : b->h, r = b->r - slope * b->poke;
    double top = b->top > 0 ? b->top + slope * b->poke : 0;
    vec3 base = body_place(pose, pen_vec3(0, 0, low)), axis = body_turn(pose, pen_vec3(0, 0, 1));
    struct pen_object_desc *o = kit_cylinder(kit, base, axis, s * r, s * (high - low), material);
    o->u.cylinder.caps = caps;
    if (b->r == b->top)
        return;
    o->kind = PEN_OBJECT_CONE;
    o->u.cone.base = base;
    o->u.cone.axis = axis;
    o->u.cone.radius = s * r;
    o->u.cone.top_radius = s * top;
    o->u.cone.height = s * (high - low);
    o->u.cone.caps = caps;
}

static void add_sheet(const struct body *b, const struct body_pose *pose, struct kit *kit, double z,
                      int material)
{
    double w = fmax(b->r, b->top) * 1.5, side = z < 0 ? -w : w;
    const vec3 v[4] = {{-w, -side, z}, {w, -side, z}, {w, side, z}, {-w, side, z}};
    add_polygon(kit, pose, v, 4, material);
}

static void add_lid(const struct body *b, const struct body_pose *pose, struct kit *kit, bool top,
                    int material)
{
    double thick = .3 * b->h, s = pose->size;
    vec3 axis = body_turn(pose, pen_vec3(0, 0, 1));
    vec3 base = body_place(pose, pen_vec3(0, 0, top ? b->h : -b->h - thick));
    kit_cylinder(kit, base, axis, s * b->r * (1 + b->over), s * thick, material);
}

static void add_round(const struct body *b, const struct body_pose *pose, struct kit *kit,
                      int material)
{
    vec3 z = body_turn(pose, pen_vec3(0, 0, 1)), top = body_place(pose, pen_vec3(0, 0, b->h));
    switch ((int)b->kind) {
    case BODY_SPHERE:
        kit_sphere(kit, pose->o, pose->size * b->r, material);
        return;
    case BODY_TUBE:
        kit_tube(kit, pose->o, z, pose->size * b->r, material);
        kit_plane(kit, body_place(pose, pen_vec3(0, 0, -b->h)), pen_neg(z), material);
        kit_plane(kit, top, z, material);
        return;
    case BODY_CYLINDER:
    case BODY_CONE:
    case BODY_CUT_CONE:
        add_cone(b, pose, kit, true, material);
        return;
    case BODY_LIDS:
        add_cone(b, pose, kit, false, material);
        add_lid(b, pose, kit, false, material);
        add_lid(b, pose, kit, true, material);
        return;
    default:
        add_cone(b, pose, kit, false, material);
        add_sheet(b, pose, kit, -b->h, material);
        if (b->top > 0)
            add_sheet(b, pose, kit, b->h, material);
    }
}

void body_add(const struct body *b, const struct body_pose *pose, struct kit *kit, int material)
{
    const struct body_pose *in = pose->group ? &as_is : pose;
    uint32_t first = kit->desc.object_count;
    if (b->kind == BODY_THICK)
        add_thick(b, in, kit, material);
    else if (is_flat(b))
        add_faces(b, in, kit, material);
    else
        add_round(b, in, kit, material);
    struct pen_transform transform = body_transform(pose);
    if (pose->group)
        kit_group(kit, first, &transform);
}

/* ---- Where its surface is ---- */

static bool is_mesh(const struct body *b)
{
    return b->kind == BODY_STAR || b->kind == BODY_DENTED;
}

/* Whether the direction passes through a face that the origin sees, a triangle. */
static bool through(const struct body *b, int f, vec3 dir)
{
    for (int i = 0; i < 3; i++) {
        vec3 p = b->v[b->corner[f][i]], q = b->v[b->corner[f][(i + 1) % 3]];
        if (pen_dot(dir, pen_cross(p, q)) < -1e-12)
            return false;
    }
    return true;
}

static double flat_reach(const struct body *b, vec3 dir)
{
    double nearest = INFINITY;
    for (int f = 0; f < b->faces; f++) {
        vec3 n = face_normal(b, f);
        double along = pen_dot(n, dir);
        if (along > 0 && (!is_mesh(b) || through(b, f, dir)))
            nearest = fmin(nearest, pen_dot(n, b->v[b->corner[f][0]]) / along);
    }
    return nearest;
}

double body_reach(const struct body *b, vec3 dir)
{
    if (is_flat(b))
        return flat_reach(b, dir);
    if (b->kind == BODY_SPHERE)
        return b->r;
    double slope = (b->top - b->r) / (2 * b->h), across = hypot(dir.x, dir.y) - slope * dir.z;
    double side = across > 0 ? .5 * (b->r + b->top) / across : INFINITY;
    return fmin(side, dir.z != 0 ? b->h / fabs(dir.z) : INFINITY);
}

double body_depth(const struct body *b, vec3 p)
{
    double least = INFINITY, far = pen_length(p);
    if (is_mesh(b))
        return far > 0 ? (body_reach(b, pen_scale(p, 1 / far)) - far) * b->thin : b->thin;
    if (is_flat(b)) {
        for (int f = 0; f < b->faces; f++)
            least = fmin(least, pen_dot(face_normal(b, f), pen_sub(b->v[b->corner[f][0]], p)));
        return least;
    }
    if (b->kind == BODY_SPHERE)
        return b->r - far;
    double slope = (b->top - b->r) / (2 * b->h);
    double side = (.5 * (b->r + b->top) + slope * p.z - hypot(p.x, p.y)) / hypot(1, slope);
    return fmin(side, b->h - fabs(p.z));
}

vec3 body_direction(const struct body *b, struct random *r)
{
    vec3 d = random_direction(r);
    return pen_normalize(pen_mul(d, b->half));
}

static vec3 on_rim(const struct body *b, struct random *r)
{
    bool top = random_below(r, 2);
    double a = random_below(r, 4) ? random_in(r, -pi, pi) : .5 * pi * random_below(r, 4);
    double radius = top ? b->top : b->r;
    return pen_vec3(radius * cos(a), radius * sin(a), top ? b->h : -b->h);
}

vec3 body_seam(const struct body *b, struct random *r)
{
    vec3 n;
    if (b->kind == BODY_SPHERE || random_below(r, 4) == 0)
        return body_surface(b, r, &n);
    if (!is_flat(b))
        return on_rim(b, r);
    int f = (int)random_below(r, (uint32_t)b->faces), n_corners = b->corners[f];
    int i = (int)random_below(r, (uint32_t)n_corners);
    vec3 from = b->v[b->corner[f][i]], to = b->v[b->corner[f][(i + 1) % n_corners]];
    return pen_along(from, pen_sub(to, from), random_below(r, 3) ? random_unit(r) : 0);
}

static vec3 round_surface(const struct body *b, struct random *r, vec3 *n)
{
    double a = random_below(r, 4) ? random_in(r, -pi, pi) : .5 * pi * random_below(r, 4);
    if (b->kind == BODY_SPHERE) {
        *n = random_direction(r);
        return pen_scale(*n, b->r);
    }
    if (random_below(r, 3) == 0) {
        bool top = random_below(r, 2) && b->top > 0;
        double radius = (top ? b->top : b->r) * sqrt(random_unit(r));
        *n = pen_vec3(0, 0, top ? 1 : -1);
        return pen_vec3(radius * cos(a), radius * sin(a), top ? b->h : -b->h);
    }
    double slope = (b->top - b->r) / (2 * b->h), z = random_in(r, -b->h, b->h);
    double radius = .5 * (b->r + b->top) + slope * z;
    *n = pen_scale(pen_vec3(cos(a), sin(a), -slope), 1 / hypot(1, slope));
    return pen_vec3(radius * cos(a), radius * sin(a), z);
}

vec3 body_surface(const struct body *b, struct random *r, vec3 *n)
{
    if (!is_flat(b))
        return round_surface(b, r, n);
    int f = (int)random_below(r, (uint32_t)b->faces);
    int i = 1 + (int)random_below(r, (uint32_t)b->corners[f] - 2);
    const int *c = b->corner[f];
    double s = random_unit(r), t = random_unit(r);
    if (s + t > 1) {
        s = 1 - s;
        t = 1 - t;
    }
    *n = face_normal(b, f);
    vec3 o = b->v[c[0]];
    return pen_along(pen_along(o, pen_sub(b->v[c[i]], o), s), pen_sub(b->v[c[i + 1]], o), t);
}
