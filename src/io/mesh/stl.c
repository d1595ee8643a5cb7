/* SPDX-License-Identifier: MIT */
/* STL: a binary file has 84 bytes and 50 per triangle, an ASCII file any other size. (The header of
 * a binary file may begin with "solid" too; text has no zero byte.) Vertices at the same place
 * become one. The normals in the file repeat what the corners say, and are not read. */
#include "io/mesh/build.h"

#include <math.h>
#include <strings.h>

enum { HEAD = 84, TRIANGLE = 50, COUNT_AT = 80, NORMAL = 12, TEXT_LEAST = 64 };

struct stl {
    struct pen_build *b;
    struct pen_weld weld;
    uint64_t facets; /* that were read, of an ASCII file */
};

static uint32_t load_u32(const char *at)
{
    const unsigned char *p = (const unsigned char *)at;
    return p[0] | (uint32_t)p[1] << 8 | (uint32_t)p[2] << 16 | (uint32_t)p[3] << 24;
}

/* Adds a corner of the triangle that is read. */
static bool add_corner(struct stl *stl, const char *at, const struct pen_number x[3])
{
    struct pen_build *b = stl->b;
    struct pen_model *m = b->m;
    pen_build_vertex(b, x, m->vertex[m->vertex_count]);
    uint32_t v = pen_weld_vertex(&stl->weld, b, m->vertex_count);
    m->vertex_count += v == m->vertex_count;
    return v != UINT32_MAX && pen_build_corner(b, at, v);
}

static bool read_binary(struct stl *stl)
{
    struct pen_scan *s = &stl->b->scan;
    s->binary = true;
    for (const char *at = s->begin + HEAD; at < s->end; at += TRIANGLE) {
        for (int i = 0; i < 3; i++) {
            const char *corner = at + NORMAL * (i + 1);
            struct pen_number x[3];
            for (int k = 0; k < 3; k++) {
                uint32_t bits = load_u32(corner + 4 * k);
                memcpy(&x[k].f, &bits, sizeof bits);
                x[k].d = (double)x[k].f;
                if (!isfinite(x[k].f))
                    return pen_scan_fail(s, PEN_INVALID, corner + 4 * k,
                                         "the coordinate %s; write finite numbers",
                                         pen_text_number(x[k].d).text);
            }
            if (!add_corner(stl, corner, x))
                return false;
        }
        if (!pen_build_face(stl->b, at))
            return false;
    }
    return true;
}

/* Reads a word of the grammar, in upper or lower case. */
static bool expect(struct pen_scan *s, const char *name)
{
    const char *word;
    pen_scan_space(s);
    size_t length = pen_scan_word(s, &word);
    return (length == strlen(name) && strncasecmp(word, name, length) == 0) ||
           pen_scan_fail(s, PEN_SYNTAX, word, "found %s in an ASCII STL file; write %s",
                         pen_scan_found(s, word).text, name);
}

/* Reads a facet behind its first word. */
static bool read_facet(struct stl *stl, const char *at)
{
    struct pen_scan *s = &stl->b->scan;
    const char *normal;
    pen_scan_rest(s, &normal);
    if (!expect(s, "outer") || !expect(s, "loop"))
        return false;
    for (int i = 0; i < 3; i++) {
        struct pen_number x[3];
        if (!expect(s, "vertex"))
            return false;
        for (int k = 0; k < 3; k++) {
            pen_scan_space(s);
            if (!pen_scan_number(s, &x[k]))
                return false;
        }
        if (!add_corner(stl, at, x))
            return false;
    }
    return expect(s, "endloop") && expect(s, "endfacet") && pen_build_face(stl->b, at);
}

static bool read_text(struct stl *stl)
{
    struct pen_build *b = stl->b;
    struct pen_scan *s = &b->scan;
    const char *word, *name;
    bool inside = false;
    s->at = s->begin;
    while (pen_scan_space(s)) {
        size_t length = pen_scan_word(s, &word);
        if (inside && length == 5 && strncasecmp(word, "facet", 5) == 0) {
            if (stl->facets++ == b->space)
                return pen_scan_fail(s, PEN_TOO_LARGE, word,
                                     "the model has more than %u triangles; reduce the mesh or "
                                     "raise the limit of triangles",
                                     b->limit);
            if (!read_facet(stl, word))
                return false;
        } else {
            s->at = word;
            if (!expect(s, inside ? "endsolid" : "solid"))
                return false;
            pen_scan_rest(s, &name);
            inside = !inside;
        }
    }
    return !inside || expect(s, "endsolid");
}

/* The triangles for which there must be memory; 0 with an error if the size is wrong. */
static uint64_t count_triangles(struct pen_build *b, bool *binary)
{
    struct pen_scan *s = &b->scan;
    const size_t bytes = b->file->bytes;
    const uint64_t count = bytes >= HEAD ? load_u32(s->begin + COUNT_AT) : 0;
    *binary = bytes >= HEAD && bytes == HEAD + TRIANGLE * count;
    if (*binary)
        return count;
    pen_scan_space(s);
    if (s->end - s->at >= 5 && strncasecmp(s->at, "solid", 5) == 0 &&
        !memchr(s->begin, '\0', bytes < HEAD ? bytes : HEAD))
        return bytes / TEXT_LEAST + 1 < b->limit ? bytes / TEXT_LEAST + 1 : b->limit;
    pen_fail(s->st, PEN_SYNTAX,
             "An STL file is ASCII and begins with solid, or it has 84 bytes and 50 for each "
             "triangle. This file has %zu bytes, and byte 80 promises %llu triangles, which take "
             "%llu bytes; copy it again",
             bytes, (unsigned long long)count, (unsigned long long)(HEAD + TRIANGLE * count));
    return 0;
}

bool pen_stl_read(struct pen_build *b)
{
    struct stl stl = {.b = b};
    struct pen_model *m = b->m;
    bool binary, ok;
    const uint64_t triangles = count_triangles(b, &binary), vertices = 3 * triangles;
    if ((triangles == 0 && !binary) || !pen_build_space(b, triangles, false) ||
        !(m->vertex = pen_build_alloc(b, vertices, sizeof *m->vertex)))
        return false;
    do {
        m->vertex_count = m->triangle_count = m->flat = m->repeated = 0;
        stl.facets = 0;
        pen_build_begin_vertices(b);
        ok = binary ? read_binary(&stl) : read_text(&stl);
        pen_weld_release(&stl.weld, b);
    } while (ok && pen_build_far(b));
    return ok;
}
