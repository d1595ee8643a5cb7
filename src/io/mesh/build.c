/* SPDX-License-Identifier: MIT */
/* Memory, shift, and faces to triangles. */
#include "io/mesh/build.h"

#include <stdlib.h>

#include "geom/polygon.h"
#include "geom/triangulate.h"
#include "math/exact.h"
#include "math/exact_sum.h"
#include "math/scale.h"

/* The cost of an exact decision, in steps. */
enum { EXACT_NORMAL = 1500 };

void *pen_build_alloc(struct pen_build *b, uint64_t count, size_t size)
{
    size_t bytes;
    if (__builtin_mul_overflow(count, size, &bytes) || bytes > b->left) {
        pen_fail(b->scan.st, PEN_TOO_LARGE,
                 "Reading this model takes more memory than 4 times its %zu bytes and 1 MiB; "
                 "it has many faces for its size, so write it as binary PLY",
                 b->file->bytes);
        return NULL;
    }
    void *memory = malloc(bytes > 0 ? bytes : 1);
    if (memory)
        b->left -= bytes;
    else
        pen_fail(b->scan.st, PEN_NO_MEMORY, "No memory for a model of %zu bytes", b->file->bytes);
    return memory;
}

void *pen_build_zeroed(struct pen_build *b, uint64_t count, size_t size)
{
    void *memory = pen_build_alloc(b, count, size);
    return memory ? memset(memory, 0, count * size) : NULL;
}

void pen_build_free(struct pen_build *b, void *memory, uint64_t count, size_t size)
{
    if (memory)
        b->left += count * size;
    free(memory);
}

void pen_build_note(struct pen_build *b, const char *at, const char *format, ...)
{
    struct pen_status note;
    va_list args;
    va_start(args, format);
    pen_text_fail(&note, PEN_OK, b->scan.begin, at ? (size_t)(at - b->scan.begin) : 0, format,
                  args);
    va_end(args);
    if (!at)
        note.line = note.column = 0;
    pen_errors_add(b->notes, &note);
}

bool pen_build_steps(struct pen_build *b, const char *at, int64_t steps)
{
    b->steps -= steps;
    return b->steps >= 0 ||
           pen_scan_fail(&b->scan, PEN_TOO_LARGE, at,
                         "reading takes too long up to here; write triangles, or polygons "
                         "of fewer corners");
}

void pen_build_begin_vertices(struct pen_build *b)
{
    for (int i = 0; i < 3; i++) {
        b->lo[i] = INFINITY;
        b->hi[i] = -INFINITY;
    }
    b->lost = 0;
}

/* What a - b is more than its rounded value d, exactly (Knuth). */
static double rest_of(double a, double b, double d)
{
    double part = d - a;
    return (a - (d - part)) - (b + part);
}

/* x - shift, rounded once to a float. The difference of doubles is rounded to odd, so that its
 * second rounding does no harm. */
static float shifted(double x, double shift)
{
    double d = x - shift, rest = rest_of(x, shift, d);
    uint64_t bits;
    memcpy(&bits, &d, sizeof bits);
    if (rest != 0 && !(bits & 1)) {
        bits += (rest > 0) == (d > 0) ? 1 : UINT64_MAX;
        memcpy(&d, &bits, sizeof d);
    }
    return (float)d;
}

void pen_build_vertex(struct pen_build *b, const struct pen_number x[3], float out[3])
{
    for (int i = 0; i < 3; i++) {
        double d = x[i].d, lost = fabs(d - (double)x[i].f);
        b->lo[i] = d < b->lo[i] ? d : b->lo[i];
        b->hi[i] = d > b->hi[i] ? d : b->hi[i];
        b->lost = lost > b->lost ? lost : b->lost;
        out[i] = b->m->shift[i] == 0 ? x[i].f : shifted(d, b->m->shift[i]);
    }
}

bool pen_build_far(struct pen_build *b)
{
    double half = 0, far = 0, centre[3], *shift = b->m->shift;
    for (int i = 0; i < 3; i++) {
        centre[i] = b->lo[i] / 2 + b->hi[i] / 2;
        far = pen_larger(far, fabs(centre[i]));
        half = pen_larger(half, b->hi[i] / 2 - b->lo[i] / 2);
    }
    if (shift[0] != 0 || shift[1] != 0 || shift[2] != 0 || !(half > 0) ||
        (far <= 16 * half && !(b->doubles && b->lost > 0x1p-23 * half)))
        return false;
    const double unit = pen_scale2(1, pen_exponent(half));
    for (int i = 0; i < 3; i++)
        shift[i] = rint(centre[i] / unit) * unit;
    return shift[0] != 0 || shift[1] != 0 || shift[2] != 0;
}

bool pen_build_faces_far(struct pen_build *b)
{
    struct pen_model *m = b->m;
    pen_build_begin_vertices(b);
    for (uint32_t t = 0; t < m->triangle_count; t++)
        for (int k = 0; k < 3; k++)
            for (int i = 0; i < 3; i++) {
                const double x = (double)m->vertex[m->corner[t][k]][i];
                b->lo[i] = x < b->lo[i] ? x : b->lo[i];
                b->hi[i] = x > b->hi[i] ? x : b->hi[i];
            }
    if (!pen_build_far(b))
        return false;
    m->triangle_count = m->flat = m->repeated = 0;
    return true;
}

bool pen_build_space(struct pen_build *b, uint64_t triangles, bool materials)
{
    struct pen_model *m = b->m;
    if (triangles == 0)
        return pen_fail(b->scan.st, PEN_INVALID,
                        "The model has no faces of three corners or more; point clouds and lines "
                        "are not rendered, so write a mesh with faces");
    if (triangles > b->limit)
        return pen_fail(b->scan.st, PEN_TOO_LARGE,
                        "The model has %llu triangles, and %u are allowed; reduce the mesh or "
                        "raise the limit of triangles",
                        (unsigned long long)triangles, b->limit);
    b->space = (uint32_t)triangles;
    return (m->corner = pen_build_alloc(b, triangles, sizeof *m->corner)) &&
           (!materials || (m->material_of = pen_build_alloc(b, triangles, sizeof(uint16_t))));
}

bool pen_build_grow(struct pen_build *b, void **array, uint32_t *space, uint64_t need, size_t size)
{
    uint64_t to = *space ? *space : 64;
    while (to < need)
        to *= 2;
    void *more = pen_build_alloc(b, to, size);
    if (!more)
        return false;
    if (*array)
        memcpy(more, *array, *space * size);
    pen_build_free(b, *array, *space, size);
    *array = more;
    *space = (uint32_t)to;
    return true;
}

bool pen_build_corners(struct pen_build *b, const char *at, uint32_t count)
{
    uint32_t same = b->face_space;
    if (count > PEN_POLYGON_CUT_MAX)
        return pen_scan_fail(&b->scan, PEN_TOO_LARGE, at,
                             "a face of more than %d corners; cut it into triangles",
                             PEN_POLYGON_CUT_MAX);
    return pen_build_grow(b, (void **)&b->face, &same, count, sizeof *b->face) &&
           pen_build_grow(b, (void **)&b->face_normal, &b->face_space, count, sizeof *b->face);
}

static struct pen_vec3 vertex(const struct pen_build *b, uint32_t i)
{
    const float *v = b->m->vertex[i];
    return pen_vec3(v[0], v[1], v[2]);
}

static bool is_zero(struct pen_vec3 v)
{
    return v.x == 0 && v.y == 0 && v.z == 0;
}

/* Whether q - p is exactly d. */
static bool is_difference(struct pen_vec3 p, struct pen_vec3 q, struct pen_vec3 d)
{
    return rest_of(q.x, p.x, d.x) == 0 && rest_of(q.y, p.y, d.y) == 0 &&
           rest_of(q.z, p.z, d.z) == 0;
}

/* Whether a triangle has an area, exactly. Products that differ by more than their rounding decide,
 * then exact products of exact differences, then exact sums. */
static bool has_area(struct pen_build *b, struct pen_vec3 p, struct pen_vec3 q, struct pen_vec3 r)
{
    struct pen_vec3 d = pen_sub(q, p), e = pen_sub(r, p);
    double yz = d.y * e.z, zy = d.z * e.y, zx = d.z * e.x, xz = d.x * e.z, xy = d.x * e.y,
           yx = d.y * e.x;
    if (fabs(yz - zy) > 0x1p-50 * (fabs(yz) + fabs(zy)) ||
        fabs(zx - xz) > 0x1p-50 * (fabs(zx) + fabs(xz)) ||
        fabs(xy - yx) > 0x1p-50 * (fabs(xy) + fabs(yx)))
        return true;
    if (is_difference(p, q, d) && is_difference(p, r, e))
        return !is_zero(pen_cross(d, e));
    b->steps -= EXACT_NORMAL;
    return !is_zero(pen_exact_normal((const struct pen_vec3[]){p, q, r}, 3));
}

/* Adds the triangle of three corners of the face if it has an area. */
static void add_triangle(struct pen_build *b, uint32_t i, uint32_t j, uint32_t k)
{
    struct pen_model *m = b->m;
    const uint32_t *v = b->face, *n = b->face_normal, t = m->triangle_count;
    if (!has_area(b, vertex(b, v[i]), vertex(b, v[j]), vertex(b, v[k]))) {
        m->flat++;
        return;
    }
    memcpy(m->corner[t], (uint32_t[]){v[i], v[j], v[k]}, sizeof m->corner[t]);
    if (m->corner_normal)
        memcpy(m->corner_normal[t], (uint32_t[]){n[i], n[j], n[k]}, sizeof m->corner[t]);
    if (m->material_of)
        m->material_of[t] = b->material;
    m->triangle_count++;
}

/* Leaves out corners that are the same as the one before. Others may come twice: an outline reaches
 * a hole and returns along the same edge. */
static void drop_repeated(struct pen_build *b)
{
    uint32_t count = 0, before = b->face[b->face_count - 1];
    for (uint32_t i = 0; i < b->face_count; i++) {
        const uint32_t corner = b->face[i];
        b->face[count] = corner;
        b->face_normal[count] = b->face_normal[i];
        count += corner != before;
        before = corner;
    }
    b->m->repeated += count < b->face_count;
    b->face_count = count;
}

static bool is_before(struct pen_vec3 p, struct pen_vec3 q)
{
    return p.x != q.x ? p.x < q.x : p.y != q.y ? p.y < q.y : p.z < q.z;
}

/* Newell's normal of the outline, zero if its area is exactly zero. Sums begin at `first`, the
 * least vertex, so the normal does not depend on where the file begins the outline. */
static struct pen_vec3 newell(struct pen_build *b, uint32_t first)
{
    const uint32_t count = b->face_count;
    struct pen_vec3 n = {0, 0, 0}, size = {0, 0, 0}, origin = b->point[first], d = {0, 0, 0};
    for (uint32_t i = 1; i < count; i++) {
        uint32_t at = first + i < count ? first + i : first + i - count;
        struct pen_vec3 e = pen_sub(b->point[at], origin);
        n = pen_add(n, pen_cross(d, e));
        size = pen_add(size, pen_vec3(fabs(d.y * e.z) + fabs(d.z * e.y),
                                      fabs(d.z * e.x) + fabs(d.x * e.z),
                                      fabs(d.x * e.y) + fabs(d.y * e.x)));
        d = e;
    }
    if (pen_norm1(n) > 0x1p-30 * pen_norm1(size))
        return n;
    b->steps -= EXACT_NORMAL + 64 * (int64_t)count;
    return pen_exact_normal(b->point, count);
}

static bool make_points(struct pen_build *b)
{
    uint32_t same = b->point_space;
    return b->point_space >= b->face_count ||
           (pen_build_grow(b, (void **)&b->point, &same, b->face_count, sizeof *b->point) &&
            pen_build_grow(b, (void **)&b->piece, &b->point_space, b->face_count,
                           sizeof *b->piece));
}

/* Cuts the face as polygons are cut (geom/triangulate.h). */
static bool cut(struct pen_build *b, const char *at)
{
    const uint32_t count = b->face_count;
    uint32_t first = 0;
    if (!make_points(b) || !pen_build_steps(b, at, 40 + (int64_t)count * count))
        return false;
    for (uint32_t i = 0; i < count; i++) {
        b->point[i] = vertex(b, b->face[i]);
        if (is_before(b->point[i], b->point[first]))
            first = i;
    }
    struct pen_vec3 n = newell(b, first);
    if (is_zero(n)) {
        b->m->flat++;
        return true;
    }
    if (!pen_triangulate(b->point, count, n, b->piece))
        return pen_fail(b->scan.st, PEN_NO_MEMORY, "No memory to cut a face of %u corners", count);
    for (uint32_t i = 0; i + 2 < count; i++)
        add_triangle(b, b->piece[i][0], b->piece[i][1], b->piece[i][2]);
    return true;
}

bool pen_build_face(struct pen_build *b, const char *at)
{
    const uint32_t *v = b->face, corners = b->face_count;
    if (corners < 3)
        b->face_count = 0;
    else if (corners > 3 || v[0] == v[1] || v[1] == v[2] || v[2] == v[0])
        drop_repeated(b);
    bool ok = b->face_count <= 3 || cut(b, at);
    if (b->face_count == 3)
        add_triangle(b, 0, 1, 2);
    else
        b->m->flat += corners < 3;
    b->face_count = 0;
    return ok && pen_build_steps(b, at, 0);
}

void pen_build_release(struct pen_build *b)
{
    pen_build_free(b, b->face, b->face_space, sizeof *b->face);
    pen_build_free(b, b->face_normal, b->face_space, sizeof *b->face_normal);
    pen_build_free(b, b->point, b->point_space, sizeof *b->point);
    pen_build_free(b, b->piece, b->point_space, sizeof *b->piece);
}

static void note_faces(struct pen_build *b)
{
    const struct pen_model *m = b->m;
    if (m->flat > 0)
        pen_build_note(b, NULL, "%u faces have no area and are left out", m->flat);
    if (m->repeated > 0)
        pen_build_note(b, NULL, "%u faces have a corner twice", m->repeated);
    if (m->open_edges > 0)
        pen_build_note(b, NULL,
                       "%u edges belong to one triangle only: the surface is open there, so glass "
                       "has no inside",
                       m->open_edges);
    if (m->crowded_edges > 0)
        pen_build_note(b, NULL, "%u edges belong to three triangles or more", m->crowded_edges);
}

bool pen_build_finish(struct pen_build *b)
{
    if (b->m->triangle_count == 0)
        return pen_fail(b->scan.st, PEN_INVALID,
                        "None of the model's faces has an area; write faces of three corners that "
                        "are not on one line");
    if (!pen_build_edges(b))
        return false;
    note_faces(b);
    return true;
}
