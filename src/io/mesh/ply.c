/* SPDX-License-Identifier: MIT */
/* PLY: after the header, one walk measures the elements and counts the triangles; then the vertices
 * and the faces are read, in any order of the file. ASCII and binary differ in reading one number
 * only. */
#include "io/mesh/ply.h"

#include <math.h>

static bool truncated(const struct pen_ply *ply, const struct pen_ply_element *e, uint32_t i)
{
    const struct pen_scan *s = &ply->b->scan;
    char name[64];
    snprintf(name, sizeof name, "%.*s", (int)(e->name_length < 32 ? e->name_length : 32), e->name);
    return pen_scan_fail(
        s, PEN_SYNTAX, s->end,
        "the file is truncated: it ends in number %u of %u of the element %s; copy it again, or "
        "correct the count in the header",
        i + 1, e->count, pen_text_quote(name).text);
}

static inline uint64_t load_bits(const char *at, uint32_t size, bool swapped)
{
    uint16_t half;
    uint32_t word;
    uint64_t both;
    switch (size) {
    case 1:
        return (unsigned char)*at;
    case 2:
        memcpy(&half, at, sizeof half);
        return swapped ? __builtin_bswap16(half) : half;
    case 4:
        memcpy(&word, at, sizeof word);
        return swapped ? __builtin_bswap32(word) : word;
    default:
        memcpy(&both, at, sizeof both);
        return swapped ? __builtin_bswap64(both) : both;
    }
}

static inline struct pen_number load(const char *at, enum pen_ply_type type, bool swapped)
{
    uint64_t bits = load_bits(at, pen_ply_size(type), swapped);
    uint32_t low = (uint32_t)bits;
    struct pen_number n = {0, 0};
    switch (type) {
    case PLY_F32:
        memcpy(&n.f, &low, sizeof n.f);
        n.d = (double)n.f;
        return n;
    case PLY_F64:
        memcpy(&n.d, &bits, sizeof n.d);
        break;
    case PLY_I8:
        n.d = (int8_t)bits;
        break;
    case PLY_I16:
        n.d = (int16_t)bits;
        break;
    case PLY_I32:
        n.d = (int32_t)low;
        break;
    case PLY_U8:
    case PLY_U16:
    case PLY_U32:
        n.d = low;
        break;
    }
    n.f = (float)n.d;
    return n;
}

/* Reads one number of number i of an element. */
static inline bool next(struct pen_ply *ply, const struct pen_ply_element *e, uint32_t i,
                        enum pen_ply_type type, struct pen_number *out)
{
    struct pen_scan *s = &ply->b->scan;
    if (!ply->binary)
        return pen_scan_space(s) ? pen_scan_number(s, out) : truncated(ply, e, i);
    const uint32_t size = pen_ply_size(type);
    if ((size_t)(s->end - s->at) < size)
        return truncated(ply, e, i);
    *out = load(s->at, type, ply->swapped);
    s->at += size;
    return true;
}

/* Reads the count of a list. */
static inline bool next_count(struct pen_ply *ply, const struct pen_ply_element *e, uint32_t i,
                              const struct pen_ply_property *p, uint32_t *count)
{
    struct pen_scan *s = &ply->b->scan;
    struct pen_number n;
    const char *at = s->at;
    if (ply->binary && p->count_type == PLY_U8 && at < s->end) {
        *count = (unsigned char)*s->at++;
        return true;
    }
    if (!next(ply, e, i, p->count_type, &n))
        return false;
    if (!(n.d >= 0 && n.d < UINT32_MAX) || n.d != (double)(uint32_t)n.d)
        return pen_scan_fail(s, PEN_INVALID, at, "a list of %s values; write a count from 0",
                             pen_text_number(n.d).text);
    *count = (uint32_t)n.d;
    return *count <= (size_t)(s->end - s->at) || truncated(ply, e, i);
}

/* Moves over values of one type. */
static bool skip(struct pen_ply *ply, const struct pen_ply_element *e, uint32_t i,
                 enum pen_ply_type type, uint32_t count)
{
    struct pen_scan *s = &ply->b->scan;
    const uint64_t bytes = (uint64_t)count * pen_ply_size(type);
    if (ply->binary) {
        if (bytes > (size_t)(s->end - s->at))
            return truncated(ply, e, i);
        s->at += bytes;
        return true;
    }
    for (const char *word; count > 0; count--) {
        if (!pen_scan_space(s))
            return truncated(ply, e, i);
        pen_scan_word(s, &word);
    }
    return true;
}

/* Moves over an element's numbers and adds the triangles of its faces. */
static bool measure(struct pen_ply *ply, struct pen_ply_element *e, uint64_t *triangles)
{
    struct pen_scan *s = &ply->b->scan;
    const size_t rest = (size_t)(s->end - s->at);
    uint64_t least = (uint64_t)e->count * (ply->binary ? e->bytes : 2 * e->properties);
    least -= !ply->binary && least > 0; /* between two numbers is a space */
    e->start = s->at;
    if (least > rest)
        return pen_scan_fail(s, PEN_SYNTAX, s->at,
                             "the header promises %u of the element %s, which take %llu bytes or "
                             "more, and %zu follow; copy the file again, or correct the count",
                             e->count, pen_scan_found(s, e->name).text, (unsigned long long)least,
                             rest);
    if (ply->binary && !e->lists) {
        s->at += least;
        return true;
    }
    for (uint32_t i = 0; e->properties > 0 && i < e->count; i++) {
        for (uint32_t k = 0; k < e->properties; k++) {
            const struct pen_ply_property *p = &ply->property[e->first + k];
            uint32_t count = 1;
            if ((p->list && !next_count(ply, e, i, p, &count)) || !skip(ply, e, i, p->type, count))
                return false;
            if (p->role == PLY_CORNERS)
                *triangles += count > 2 ? count - 2 : 0;
        }
    }
    return true;
}

static bool read_vertex(struct pen_ply *ply, const struct pen_ply_element *e, uint32_t i)
{
    struct pen_build *b = ply->b;
    struct pen_number value[6] = {{0, 0}};
    const char *at = b->scan.at;
    for (uint32_t k = 0; k < e->properties; k++) {
        const struct pen_ply_property *p = &ply->property[e->first + k];
        uint32_t count = 1;
        if (p->list && !next_count(ply, e, i, p, &count))
            return false;
        if (p->role < PLY_CORNERS ? !next(ply, e, i, p->type, &value[p->role])
                                  : !skip(ply, e, i, p->type, count))
            return false;
    }
    for (int k = 0; k < 6; k++)
        if (!isfinite(value[k].f))
            return pen_scan_fail(&b->scan, PEN_INVALID, at,
                                 "vertex %u has the number %s; write finite numbers below 3.4e38",
                                 i, pen_text_number(value[k].d).text);
    pen_build_vertex(b, value, b->m->vertex[i]);
    for (int k = 0; b->m->normal && k < 3; k++)
        b->m->normal[i][k] = value[PLY_NX + k].f;
    return true;
}

static bool read_vertices(struct pen_ply *ply)
{
    const struct pen_ply_element *e = ply->vertices;
    struct pen_build *b = ply->b;
    struct pen_model *m = b->m;
    const unsigned normals = 1u << PLY_NX | 1u << PLY_NY | 1u << PLY_NZ;
    if (!(m->vertex = pen_build_alloc(b, e->count, sizeof *m->vertex)))
        return false;
    m->vertex_count = e->count;
    if ((e->roles & normals) == normals) {
        if (!(m->normal = pen_build_alloc(b, e->count, sizeof *m->normal)))
            return false;
        m->normal_count = e->count;
    }
    for (uint32_t k = 0; k < e->properties; k++)
        if (ply->property[e->first + k].role <= PLY_Z)
            b->doubles = b->doubles || ply->property[e->first + k].type == PLY_F64;
    do {
        b->scan.at = e->start;
        pen_build_begin_vertices(b);
        for (uint32_t i = 0; i < e->count; i++)
            if (!read_vertex(ply, e, i))
                return false;
    } while (pen_build_far(b));
    return true;
}

/* Reads corners that are integers of 32 bits, as in nearly all binary files. Returns their number;
 * stops before the first that is wrong. */
static uint32_t read_usual_corners(struct pen_ply *ply, enum pen_ply_type type, uint32_t count)
{
    struct pen_build *b = ply->b;
    const uint32_t vertices = b->m->vertex_count;
    uint32_t k = 0, v;
    if (!ply->binary || (type != PLY_I32 && type != PLY_U32) ||
        (size_t)(b->scan.end - b->scan.at) / sizeof v < count)
        return 0;
    for (; k < count; k++, b->scan.at += sizeof v) {
        memcpy(&v, b->scan.at, sizeof v);
        v = ply->swapped ? __builtin_bswap32(v) : v;
        if (v >= vertices)
            break;
        b->face[k] = v;
    }
    return k;
}

static bool read_corners(struct pen_ply *ply, const struct pen_ply_element *e, uint32_t i,
                         const struct pen_ply_property *p)
{
    struct pen_build *b = ply->b;
    const double vertices = b->m->vertex_count;
    const char *at = b->scan.at;
    uint32_t count = 0;
    struct pen_number n;
    if (!next_count(ply, e, i, p, &count) ||
        (count > b->face_space && !pen_build_corners(b, at, count)))
        return false;
    for (uint32_t k = read_usual_corners(ply, p->type, count); k < count; k++) {
        at = b->scan.at;
        if (!next(ply, e, i, p->type, &n))
            return false;
        if (!(n.d >= 0 && n.d < vertices) || n.d != (double)(uint32_t)n.d)
            return pen_scan_fail(
                &b->scan, PEN_INVALID, at,
                "face %u has the vertex %s; the file's %u vertices are numbered from 0", i,
                pen_text_number(n.d).text, b->m->vertex_count);
        b->face[k] = (uint32_t)n.d;
    }
    b->face_count = count;
    return true;
}

static bool read_faces(struct pen_ply *ply)
{
    const struct pen_ply_element *e = ply->faces;
    struct pen_build *b = ply->b;
    b->scan.at = e->start;
    for (uint32_t i = 0; i < e->count; i++) {
        const char *at = b->scan.at;
        for (uint32_t k = 0; k < e->properties; k++) {
            const struct pen_ply_property *p = &ply->property[e->first + k];
            uint32_t count = 1;
            if (p->role == PLY_CORNERS ? !read_corners(ply, e, i, p)
                                       : (p->list && !next_count(ply, e, i, p, &count)) ||
                                             !skip(ply, e, i, p->type, count))
                return false;
        }
        if (b->face_count < 3) {
            b->m->flat++;
            b->face_count = 0;
        } else if (!pen_build_face(b, at)) {
            return false;
        }
    }
    return true;
}

bool pen_ply_read(struct pen_build *b)
{
    const unsigned xyz = 1u << PLY_X | 1u << PLY_Y | 1u << PLY_Z;
    struct pen_ply ply = {.b = b};
    uint64_t triangles = 0;
    if (!pen_ply_header(&ply))
        return false;
    b->scan.binary = ply.binary;
    if (!ply.vertices || (ply.vertices->roles & xyz) != xyz)
        return pen_fail(b->scan.st, PEN_INVALID,
                        "The PLY file has no element vertex with the properties x, y and z");
    for (uint32_t i = 0; ply.faces && i < ply.elements; i++)
        if (!measure(&ply, &ply.element[i], &triangles))
            return false;
    return pen_build_space(b, triangles, false) && read_vertices(&ply) && read_faces(&ply);
}
