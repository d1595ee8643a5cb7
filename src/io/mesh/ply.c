/* SPDX-License-Identifier: MIT */
/* PLY: after the header, one walk measures the elements and counts the triangles; then the vertices
 * and the faces are read, in any order of the file. ASCII and binary differ in reading one number
 * only.
 * Source: Turk, "The PLY polygon file format", 1994. */
#include "io/mesh/build.h"

#include <math.h>

enum type { I8, U8, I16, U16, I32, U32, F32, F64 };

static const struct {
    const char *name, *other;
    uint32_t bytes;
} types[] = {
    [I8] = {"char", "int8", 1},      [U8] = {"uchar", "uint8", 1},    [I16] = {"short", "int16", 2},
    [U16] = {"ushort", "uint16", 2}, [I32] = {"int", "int32", 4},     [U32] = {"uint", "uint32", 4},
    [F32] = {"float", "float32", 4}, [F64] = {"double", "float64", 8}};

enum { ELEMENTS = 16, PROPERTIES = 192, VALUES = 6 };

/* What a property is: value 0 to 5 of `value_names`, the corners of a face, or skipped. */
enum { CORNERS = VALUES, SKIPPED };
static const char *const value_names[VALUES] = {"x", "y", "z", "nx", "ny", "nz"};

struct property {
    enum type type, count_type;
    unsigned role;
    bool list;
};

struct element {
    const char *name; /* in the file */
    size_t length;
    uint32_t count, first, properties;
    uint32_t bytes; /* of one in a binary file, with empty lists */
    bool lists;
    unsigned roles;    /* one bit per role */
    const char *start; /* of the data */
};

struct ply {
    struct pen_build *b;
    bool binary, swapped; /* swapped: the other byte order than this machine's */
    struct element element[ELEMENTS], *vertices, *faces;
    struct property property[PROPERTIES];
    uint32_t elements, properties;
    uint64_t triangles;
    uint32_t unknown; /* lines of the header */
};

/* Reads a word of the header's line; empty at its end. */
static size_t read_word(struct pen_scan *s, const char **word)
{
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t'))
        s->at++;
    return pen_scan_word(s, word);
}

static bool refuse(const struct pen_scan *s, const char *at, const char *wanted)
{
    return pen_scan_fail(s, PEN_SYNTAX, at, "found %s in the header of a PLY file; write %s",
                         pen_scan_found(s, at).text, wanted);
}

static bool read_type(struct pen_scan *s, enum type *type)
{
    const char *word;
    size_t length = read_word(s, &word);
    for (unsigned i = I8; i <= F64; i++) {
        *type = (enum type)i;
        if (pen_word_is(word, length, types[i].name) || pen_word_is(word, length, types[i].other))
            return true;
    }
    return refuse(s, word, "a type: char, uchar, short, ushort, int, uint, float or double");
}

static bool read_format(struct ply *ply, struct pen_scan *s)
{
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const uint16_t one = 1;
    const bool little = *(const unsigned char *)&one == 1;
    const char *word, *version;
    size_t length = read_word(s, &word), version_length = read_word(s, &version);
    for (int i = 0; i < 3; i++) {
        ply->binary = i > 0;
        ply->swapped = i == (little ? 2 : 1);
        if (pen_word_is(word, length, formats[i]) && pen_word_is(version, version_length, "1.0"))
            return true;
    }
    return refuse(s, word, "ascii, binary_little_endian or binary_big_endian, and 1.0");
}

static bool read_element(struct ply *ply, struct pen_scan *s)
{
    struct element *e = &ply->element[ply->elements];
    struct pen_number count;
    const char *at;
    if (ply->elements == ELEMENTS)
        return refuse(s, s->at, "at most 16 elements");
    *e = (struct element){.first = ply->properties};
    e->length = read_word(s, &e->name);
    if (read_word(s, &at) > 0)
        s->at = at;
    if (!pen_scan_number(s, &count))
        return false;
    if (!(count.d >= 0 && count.d < UINT32_MAX) || count.d != (double)(uint32_t)count.d)
        return refuse(s, at, "a count below 4294967295");
    e->count = (uint32_t)count.d;
    ply->elements++;
    if (pen_word_is(e->name, e->length, "vertex") && !ply->vertices)
        ply->vertices = e;
    if (pen_word_is(e->name, e->length, "face") && !ply->faces)
        ply->faces = e;
    return true;
}

static unsigned role_of(const struct ply *ply, const struct element *e, bool list, const char *word,
                        size_t length)
{
    for (unsigned i = 0; e == ply->vertices && !list && i < VALUES; i++)
        if (pen_word_is(word, length, value_names[i]))
            return i;
    return e == ply->faces && list &&
                   (pen_word_is(word, length, "vertex_indices") ||
                    pen_word_is(word, length, "vertex_index"))
               ? CORNERS
               : SKIPPED;
}

static bool read_property(struct ply *ply, struct pen_scan *s)
{
    struct property *p = &ply->property[ply->properties];
    const char *word, *type = s->at;
    if (ply->elements == 0 || ply->properties == PROPERTIES)
        return refuse(s, type, "a property after its element, and at most 192");
    struct element *e = &ply->element[ply->elements - 1];
    size_t length = read_word(s, &word);
    *p = (struct property){.list = pen_word_is(word, length, "list")};
    if (!p->list)
        s->at = type;
    if ((p->list && !read_type(s, &p->count_type)) || !read_type(s, &p->type))
        return false;
    length = read_word(s, &word);
    p->role = role_of(ply, e, p->list, word, length);
    if (p->role != SKIPPED && (e->roles & 1u << p->role))
        return refuse(s, word, "each property once");
    e->roles |= 1u << p->role;
    e->lists = e->lists || p->list;
    e->bytes += types[p->list ? p->count_type : p->type].bytes;
    e->properties++;
    ply->properties++;
    return true;
}

/* Moves behind the line's end: a line feed, a carriage return, or both. */
static bool end_line(struct pen_scan *s)
{
    while (s->at < s->end && *s->at != '\n' && *s->at != '\r')
        s->at++;
    const bool found = s->at<s->end, both = s->end - s->at> 1 && memcmp(s->at, "\r\n", 2) == 0;
    s->at += both ? 2 : found;
    return found;
}

static bool read_header(struct ply *ply)
{
    struct pen_scan *s = &ply->b->scan;
    const char *word;
    bool format = false, ok = true;
    size_t length = read_word(s, &word);
    if (!pen_word_is(word, length, "ply"))
        return refuse(s, word, "ply as the first line");
    while (ok && end_line(s)) {
        length = read_word(s, &word);
        if (pen_word_is(word, length, "end_header"))
            return format ? end_line(s) || refuse(s, s->at, "the data after end_header")
                          : refuse(s, word, "a line with the format before it");
        if (pen_word_is(word, length, "format"))
            ok = format = read_format(ply, s);
        else if (pen_word_is(word, length, "element"))
            ok = read_element(ply, s);
        else if (pen_word_is(word, length, "property"))
            ok = read_property(ply, s);
        else if (length > 0 && !pen_word_is(word, length, "comment") &&
                 !pen_word_is(word, length, "obj_info") && ply->unknown++ == 0)
            pen_build_note(ply->b, word, "the header's line %s is not known, and passed over",
                           pen_scan_found(s, word).text);
    }
    return ok && refuse(s, s->end, "end_header: the file is truncated");
}

static bool truncated(const struct ply *ply, const struct element *e, uint32_t i)
{
    const struct pen_scan *s = &ply->b->scan;
    return pen_scan_fail(s, PEN_SYNTAX, s->end,
                         "the file ends in number %u of %u of the element %s; copy it again, or "
                         "correct the count in the header",
                         i + 1, e->count, pen_scan_found(s, e->name).text);
}

static inline struct pen_number load(const char *at, enum type type, bool swapped)
{
    uint16_t half;
    uint32_t word;
    uint64_t bits;
    struct pen_number n;
    if (types[type].bytes == 2) {
        memcpy(&half, at, sizeof half);
        half = swapped ? __builtin_bswap16(half) : half;
        n.d = type == I16 ? (int16_t)half : half;
    } else if (types[type].bytes == 4) {
        memcpy(&word, at, sizeof word);
        word = swapped ? __builtin_bswap32(word) : word;
        memcpy(&n.f, &word, sizeof n.f);
        n.d = type == F32 ? (double)n.f : type == I32 ? (double)(int32_t)word : (double)word;
    } else if (type == F64) {
        memcpy(&bits, at, sizeof bits);
        bits = swapped ? __builtin_bswap64(bits) : bits;
        memcpy(&n.d, &bits, sizeof n.d);
    } else {
        n.d = type == I8 ? (signed char)*at : (unsigned char)*at;
    }
    n.f = (float)n.d;
    return n;
}

/* Reads one number of number i of an element. */
static inline bool next(struct ply *ply, const struct element *e, uint32_t i, enum type type,
                        struct pen_number *out)
{
    struct pen_scan *s = &ply->b->scan;
    if (!ply->binary)
        return pen_scan_space(s) ? pen_scan_number(s, out) : truncated(ply, e, i);
    if ((size_t)(s->end - s->at) < types[type].bytes)
        return truncated(ply, e, i);
    *out = load(s->at, type, ply->swapped);
    s->at += types[type].bytes;
    return true;
}

/* Reads an integer from 0 to below `limit`. */
static inline bool next_count(struct ply *ply, const struct element *e, uint32_t i, enum type type,
                              uint32_t limit, uint32_t *count)
{
    struct pen_scan *s = &ply->b->scan;
    struct pen_number n;
    if (!ply->binary)
        pen_scan_space(s);
    const char *at = s->at;
    if (type == U8 && ply->binary && at < s->end && (unsigned char)*at < limit) { /* nearly all */
        *count = (unsigned char)*s->at++;
        return true;
    }
    if (!next(ply, e, i, type, &n))
        return false;
    if (!(n.d >= 0 && n.d < limit) || n.d != (double)(uint32_t)n.d)
        return pen_scan_fail(
            s, PEN_INVALID, at,
            "number %u of the element %s has %s where an integer from 0 to below %u is allowed; "
            "vertices are numbered from 0, and lists begin with their length",
            i + 1, pen_scan_found(s, e->name).text, pen_text_number(n.d).text, limit);
    *count = (uint32_t)n.d;
    return true;
}

/* Moves over values of one type. */
static bool skip(struct ply *ply, const struct element *e, uint32_t i, enum type type,
                 uint32_t count)
{
    struct pen_scan *s = &ply->b->scan;
    const uint64_t bytes = (uint64_t)count * types[type].bytes;
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

/* Reads corners that are integers of 32 bits, as in nearly all binary files. Returns their number;
 * stops before the first that is wrong. */
static uint32_t read_usual_corners(struct ply *ply, enum type type, uint32_t count)
{
    struct pen_build *b = ply->b;
    uint32_t k = 0, v;
    if (!ply->binary || (type != I32 && type != U32) ||
        (size_t)(b->scan.end - b->scan.at) / sizeof v < count)
        return 0;
    for (; k < count; k++, b->scan.at += sizeof v) {
        memcpy(&v, b->scan.at, sizeof v);
        v = ply->swapped ? __builtin_bswap32(v) : v;
        if (v >= b->m->vertex_count)
            break;
        b->face[k] = v;
    }
    return k;
}

static bool read_corners(struct ply *ply, const struct element *e, uint32_t i, enum type type,
                         uint32_t count)
{
    struct pen_build *b = ply->b;
    if (count > b->face_space && !pen_build_corners(b, b->scan.at, count))
        return false;
    for (uint32_t k = read_usual_corners(ply, type, count); k < count; k++)
        if (!next_count(ply, e, i, type, b->m->vertex_count, &b->face[k]))
            return false;
    b->face_count = count;
    return true;
}

/* Reads number i of the vertices or faces. With `measures`, it only counts triangles. */
static inline bool read_one(struct ply *ply, const struct element *e, uint32_t i, bool measures,
                            struct pen_number value[VALUES])
{
    for (uint32_t k = 0; k < e->properties; k++) {
        const struct property *p = &ply->property[e->first + k];
        uint32_t count = 1;
        bool ok = !p->list || next_count(ply, e, i, p->count_type, UINT32_MAX, &count);
        if (measures && p->role == CORNERS && count > 2)
            ply->triangles += count - 2;
        if (!ok)
            return false;
        ok = measures || p->role == SKIPPED ? skip(ply, e, i, p->type, count)
             : p->role == CORNERS           ? read_corners(ply, e, i, p->type, count)
                                            : next(ply, e, i, p->type, &value[p->role]);
        if (!ok)
            return false;
    }
    return true;
}

/* Moves over an element's data. */
static bool measure(struct ply *ply, struct element *e)
{
    struct pen_scan *s = &ply->b->scan;
    uint64_t least = (uint64_t)e->count * (ply->binary ? e->bytes : 2 * e->properties);
    bool ok = true;
    least -= !ply->binary && least > 0; /* a space between two numbers */
    e->start = s->at;
    if (least > (size_t)(s->end - s->at))
        return pen_scan_fail(s, PEN_SYNTAX, s->at,
                             "the header promises %u of the element %s, which take %llu bytes or "
                             "more, and %zu follow; copy the file again, or correct the count",
                             e->count, pen_scan_found(s, e->name).text, (unsigned long long)least,
                             (size_t)(s->end - s->at));
    if (ply->binary && !e->lists)
        s->at += least;
    else
        for (uint32_t i = 0; ok && e->properties > 0 && i < e->count; i++)
            ok = read_one(ply, e, i, true, NULL);
    return ok;
}

static bool read_vertices(struct ply *ply, const struct element *e)
{
    struct pen_build *b = ply->b;
    struct pen_number value[VALUES] = {{0, 0}};
    b->scan.at = e->start;
    pen_build_begin_vertices(b);
    for (uint32_t i = 0; i < e->count; i++) {
        const char *at = b->scan.at;
        if (!read_one(ply, e, i, false, value))
            return false;
        for (int k = 0; k < VALUES; k++)
            if (!isfinite(value[k].f))
                return pen_scan_fail(&b->scan, PEN_INVALID, at,
                                     "vertex %u has the number %s; write finite ones below 3.4e38",
                                     i, pen_text_number(value[k].d).text);
        pen_build_vertex(b, value, b->m->vertex[i]);
        for (int k = 0; b->m->normal && k < 3; k++)
            b->m->normal[i][k] = value[3 + k].f;
    }
    return true;
}

static bool read_faces(struct ply *ply, const struct element *e)
{
    struct pen_build *b = ply->b;
    b->scan.at = e->start;
    for (uint32_t i = 0; i < e->count; i++) {
        const char *at = b->scan.at;
        if (!read_one(ply, e, i, false, NULL) || !pen_build_face(b, at))
            return false;
    }
    return true;
}

/* Takes memory for vertices and normals. */
static bool make_space(struct ply *ply, const struct element *e)
{
    struct pen_build *b = ply->b;
    struct pen_model *m = b->m;
    const bool normals = (e->roles & 070) == 070;
    for (uint32_t k = 0; k < e->properties; k++) {
        const struct property *p = &ply->property[e->first + k];
        b->doubles = b->doubles || (p->role < 3 && p->type == F64);
    }
    m->vertex_count = e->count;
    m->normal_count = normals ? e->count : 0;
    return pen_build_space(b, ply->triangles, false) &&
           (m->vertex = pen_build_alloc(b, e->count, sizeof *m->vertex)) &&
           (!normals || (m->normal = pen_build_alloc(b, e->count, sizeof *m->normal)));
}

bool pen_ply_read(struct pen_build *b)
{
    struct ply ply = {.b = b};
    if (!read_header(&ply))
        return false;
    b->scan.binary = ply.binary;
    if (!ply.vertices || (ply.vertices->roles & 7) != 7)
        return pen_fail(b->scan.st, PEN_INVALID,
                        "The PLY file has no element vertex with the properties x, y and z");
    for (uint32_t i = 0; ply.faces && i < ply.elements; i++)
        if (!measure(&ply, &ply.element[i]))
            return false;
    if (!make_space(&ply, ply.vertices))
        return false;
    do {
        do {
            if (!read_vertices(&ply, ply.vertices))
                return false;
        } while (pen_build_far(b));
        if (!read_faces(&ply, ply.faces))
            return false;
    } while (pen_build_faces_far(b));
    return true;
}
