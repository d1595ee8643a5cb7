/* SPDX-License-Identifier: MIT */
/* OBJ: a pass counts, one reads the vertices (twice if they need a shift), and one the faces. So
 * faces may come before their vertices.
 * Source: Wavefront, "Object files (.obj)", appendix B1 of the Advanced Visualizer's manual, 1995.
 */
#include "io/mesh/mtl.h"

enum { MATERIALS = UINT16_MAX + 1 };

/* What is not read: the name of the first, and how many there are. */
struct unknown {
    const char *name;
    uint32_t count;
};

struct obj {
    struct pen_build *b;
    struct pen_mtl mtl;
    uint32_t current;           /* the material */
    uint64_t vertices, normals; /* those that this pass has met */
    uint64_t triangles;
    bool materials;           /* it has usemtl */
    struct unknown statement; /* of a name that is not known */
    struct unknown material;  /* that no MTL has */
};

/* Statements that change nothing here, and those of curves and curved surfaces. */
static const char *const silent[] = {"vt", "g",   "s",     "o",        "vp",
                                     "mg", "lod", "bevel", "c_interp", "d_interp"};
static const char *const curves[] = {"cstype", "curv", "curv2", "surf", "deg", "bsp",
                                     "bzp",    "cdc",  "cdp",   "res",  "parm"};

#define IS_ONE_OF(word, length, names) is_one_of(word, length, names, sizeof names / sizeof *names)

static bool is_one_of(const char *word, size_t length, const char *const *names, size_t count)
{
    for (size_t i = 0; i < count; i++)
        if (pen_word_is(word, length, names[i]))
            return true;
    return false;
}

static bool is_face(const char *word, size_t length)
{
    return pen_word_is(word, length, "f") || pen_word_is(word, length, "fo");
}

static void add_unknown(struct unknown *u, const char *name)
{
    *u = (struct unknown){u->count > 0 ? u->name : name, u->count + 1};
}

static bool count_other(struct obj *o, const char *word, size_t length)
{
    if (IS_ONE_OF(word, length, silent))
        return true;
    if (IS_ONE_OF(word, length, curves))
        return pen_scan_fail(&o->b->scan, PEN_UNSUPPORTED, word,
                             "%s belongs to a curve or curved surface, which are not read; export "
                             "polygons",
                             pen_scan_found(&o->b->scan, word).text);
    add_unknown(&o->statement, word);
    return true;
}

static bool count_statement(struct obj *o, const char *word, size_t length)
{
    struct pen_scan *s = &o->b->scan;
    uint64_t corners = 0;
    if (pen_word_is(word, length, "v")) {
        o->vertices++;
    } else if (pen_word_is(word, length, "vn")) {
        o->normals++;
    } else if (is_face(word, length)) {
        for (const char *corner; pen_scan_more(s); corners++)
            pen_scan_word(s, &corner);
        o->triangles += corners - 2;
        return corners >= 3 ||
               pen_scan_fail(s, PEN_INVALID, word, "a face of %u corners; write three or more",
                             (unsigned)corners);
    } else if (pen_word_is(word, length, "usemtl")) {
        o->materials = true;
    } else if (pen_word_is(word, length, "mtllib")) {
        return pen_mtl_read(&o->mtl, o->b);
    } else {
        return count_other(o, word, length);
    }
    return true;
}

static bool read_vector(struct obj *o, const char *word, size_t length)
{
    struct pen_scan *s = &o->b->scan;
    struct pen_model *m = o->b->m;
    struct pen_number x[3];
    const bool is_vertex = pen_word_is(word, length, "v");
    if (!is_vertex && !pen_word_is(word, length, "vn"))
        return true;
    for (int i = 0; i < 3; i++) {
        if (!pen_scan_more(s))
            return pen_scan_fail(s, PEN_SYNTAX, word, "%s needs three numbers",
                                 pen_scan_found(s, word).text);
        if (!pen_scan_number(s, &x[i]))
            return false;
        if (!is_vertex)
            m->normal[o->normals][i] = x[i].f;
    }
    if (is_vertex)
        pen_build_vertex(o->b, x, m->vertex[o->vertices++]);
    o->normals += !is_vertex;
    return true;
}

/* Reads an index from 1, or from the end if it is negative. Does not move if there is none. `count`
 * are before it, and `all` in the file. */
static bool read_index(struct obj *o, uint64_t count, uint64_t all, uint32_t *out)
{
    struct pen_scan *s = &o->b->scan;
    const char *at = s->at, *end = s->end, *first = at + (at < end && *at == '-'), *digit = first;
    uint64_t n = 0;
    for (; digit < end && *digit >= '0' && *digit <= '9'; digit++)
        n = n < UINT32_MAX ? n * 10 + (uint64_t)(*digit - '0') : n;
    *out = (uint32_t)(first > at ? count - n : n - 1);
    s->at = digit > first ? digit : at;
    return (n > 0 && n <= (first > at ? count : all)) || s->at == at ||
           pen_scan_fail(s, PEN_INVALID, at,
                         "%s does not exist: the file has %llu, numbered from 1, and %llu before "
                         "this line",
                         pen_scan_found(s, at).text, (unsigned long long)all,
                         (unsigned long long)count);
}

/* Reads a corner: v, v/vt, v//vn or v/vt/vn. vt is not looked at. */
static bool read_corner(struct obj *o)
{
    struct pen_build *b = o->b;
    struct pen_scan *s = &b->scan;
    const char *at = s->at, *from;
    uint32_t v, n = PEN_NO_NORMAL;
    if (!read_index(o, o->vertices, b->m->vertex_count, &v))
        return false;
    bool ok = s->at > at;
    if (ok && s->at < s->end && *s->at == '/') {
        for (s->at++; s->at < s->end && strchr("-0123456789", *s->at) && *s->at; s->at++)
            ;
        if (s->at < s->end && *s->at == '/') {
            from = ++s->at;
            if (!read_index(o, o->normals, b->m->normal_count, &n))
                return false;
            ok = s->at > from;
        }
    }
    if (!ok || (s->at < s->end && !pen_is_space(*s->at) && *s->at != '\\'))
        return pen_scan_fail(s, PEN_SYNTAX, at,
                             "found %s in a face; write corners as v, v/vt, v//vn or v/vt/vn",
                             pen_scan_found(s, at).text);
    if (!pen_build_corner(b, at, v))
        return false;
    b->face_normal[b->face_count - 1] = n;
    return true;
}

/* Sets the place of the face's material in the model. Its first face adds it. */
static bool use_material(struct obj *o, const char *at)
{
    struct pen_model *m = o->b->m;
    struct pen_mtl_material *current = &o->mtl.material[o->current];
    if (m->material_of && current->used == 0) {
        if (m->material_count == MATERIALS)
            return pen_scan_fail(&o->b->scan, PEN_TOO_LARGE, at, "more than %d materials",
                                 MATERIALS);
        current->used = ++m->material_count;
    }
    o->b->material = (uint16_t)(current->used - 1);
    return true;
}

static bool read_face(struct obj *o, const char *at)
{
    struct pen_build *b = o->b;
    bool all = true;
    while (pen_scan_more(&b->scan))
        if (!read_corner(o))
            return false;
    for (uint32_t i = 0; i < b->face_count; i++)
        all = all && b->face_normal[i] != PEN_NO_NORMAL;
    for (uint32_t i = 0; !all && i < b->face_count; i++)
        b->face_normal[i] = PEN_NO_NORMAL;
    return use_material(o, at) && pen_build_face(b, at);
}

static bool read_usemtl(struct obj *o, const char *at)
{
    const char *name, *text = (const char *)o->mtl.text.data;
    struct pen_scan rest = o->b->scan; /* the place stays: both passes see the same line ends */
    const size_t length = pen_scan_rest(&rest, &name);
    const struct pen_mtl_material *m = o->mtl.material;
    uint32_t i = 1;
    while (i < o->mtl.count && (m[i].length != length || memcmp(text + m[i].name, name, length)))
        i++;
    o->current = i < o->mtl.count ? i : 0;
    if (o->current == 0)
        add_unknown(&o->material, name);
    return pen_build_steps(o->b, at, i) ||
           pen_scan_fail(&o->b->scan, PEN_TOO_LARGE, at,
                         "finding this one of %u materials, again and again, takes too long; sort "
                         "the faces by material, or write fewer materials",
                         o->mtl.count - 1);
}

static bool read_element(struct obj *o, const char *word, size_t length)
{
    o->vertices += pen_word_is(word, length, "v");
    o->normals += pen_word_is(word, length, "vn");
    return is_face(word, length) ? read_face(o, word)
                                 : !pen_word_is(word, length, "usemtl") || read_usemtl(o, word);
}

/* Gives each statement of the file to a function. */
static bool pass(struct obj *o, bool (*each)(struct obj *, const char *, size_t))
{
    struct pen_scan *s = &o->b->scan;
    const char *word;
    size_t length;
    o->vertices = o->normals = 0;
    s->at = s->begin + (o->b->file->bytes >= 3 && memcmp(s->begin, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0);
    for (; pen_scan_statement(s, &word, &length); pen_scan_next_line(s))
        if (!each(o, word, length))
            return false;
    return true;
}

static bool make_space(struct obj *o)
{
    struct pen_build *b = o->b;
    struct pen_model *m = b->m;
    if (!pen_build_space(b, o->triangles, o->materials) ||
        !(m->vertex = pen_build_alloc(b, o->vertices, sizeof *m->vertex)))
        return false;
    m->vertex_count = (uint32_t)o->vertices;
    m->normal_count = (uint32_t)o->normals;
    return o->normals == 0 ||
           ((m->normal = pen_build_alloc(b, o->normals, sizeof *m->normal)) &&
            (m->corner_normal = pen_build_alloc(b, o->triangles, sizeof *m->corner_normal)));
}

static bool take_materials(struct obj *o)
{
    struct pen_model *m = o->b->m;
    if (!m->material_of)
        return true;
    if (!(m->material = pen_build_alloc(o->b, m->material_count, sizeof *m->material)))
        return false;
    for (uint32_t i = 0; i < o->mtl.count; i++)
        if (o->mtl.material[i].used > 0)
            m->material[o->mtl.material[i].used - 1] = o->mtl.material[i].is;
    return true;
}

static void add_notes(struct obj *o)
{
    struct pen_build *b = o->b;
    if (o->statement.count > 0)
        pen_build_note(b, o->statement.name, "%u statements are not read, first %s",
                       o->statement.count, pen_scan_found(&b->scan, o->statement.name).text);
    if (o->material.count > 0)
        pen_build_note(b, o->material.name,
                       "no MTL file has the material of %u statements usemtl, first %s; their "
                       "faces are grey",
                       o->material.count, pen_scan_found(&b->scan, o->material.name).text);
}

static bool read(struct obj *o)
{
    if (!pen_mtl_add(&o->mtl, o->b, 0, 0) || !pass(o, count_statement) || !make_space(o))
        return false;
    do {
        do {
            pen_build_begin_vertices(o->b);
            if (!pass(o, read_vector))
                return false;
        } while (pen_build_far(o->b));
        o->current = o->material.count = 0;
        if (!pass(o, read_element))
            return false;
    } while (pen_build_faces_far(o->b));
    if (!take_materials(o))
        return false;
    add_notes(o);
    return true;
}

bool pen_obj_read(struct pen_build *b)
{
    struct obj o = {.b = b};
    bool ok = read(&o);
    pen_mtl_release(&o.mtl, b);
    return ok;
}
