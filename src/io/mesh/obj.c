/* SPDX-License-Identifier: MIT */
/* OBJ: a pass counts, one reads the vertices (twice if they need a shift), and one the faces. So
 * faces may come before their vertices. Curves and surfaces are refused. Statements that change no
 * pixel here are passed over; a warning counts all others.
 * Source: Wavefront, "Object files (.obj)", appendix B1 of the Advanced Visualizer's manual, 1995.
 */
#include "io/mesh/mtl.h"

enum { UNKNOWN_NAMES = 8, MATERIALS = UINT16_MAX + 1 };

struct unknown {
    const char *name;
    size_t length;
    uint32_t count;
};

struct obj {
    struct pen_build *b;
    struct pen_mtl mtl;
    struct pen_mtl_material *current;
    uint64_t vertices, normals, triangles; /* in the file, and while faces are read, before them */
    bool materials, corner_normals;        /* it has usemtl; some faces have normals */
    struct unknown unknown[UNKNOWN_NAMES + 1]; /* the last: all other names */
};

enum word { WORD_V, WORD_VN, WORD_F, WORD_USEMTL, WORD_MTLLIB, WORD_SILENT, WORD_CURVE, WORD_NONE };

static const struct {
    const char *name;
    enum word is;
} words[] = {{"v", WORD_V},           {"f", WORD_F},          {"vn", WORD_VN},
             {"vt", WORD_SILENT},     {"g", WORD_SILENT},     {"s", WORD_SILENT},
             {"usemtl", WORD_USEMTL}, {"o", WORD_SILENT},     {"mtllib", WORD_MTLLIB},
             {"fo", WORD_F},          {"mg", WORD_SILENT},    {"lod", WORD_SILENT},
             {"vp", WORD_SILENT},     {"bevel", WORD_SILENT}, {"c_interp", WORD_SILENT},
             {"cstype", WORD_CURVE},  {"curv", WORD_CURVE},   {"d_interp", WORD_SILENT},
             {"curv2", WORD_CURVE},   {"surf", WORD_CURVE},   {"deg", WORD_CURVE},
             {"bsp", WORD_CURVE},     {"bzp", WORD_CURVE},    {"cdc", WORD_CURVE},
             {"cdp", WORD_CURVE},     {"res", WORD_CURVE},    {"parm", WORD_CURVE}};

static enum word word_of(const char *word, size_t length)
{
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++)
        if (pen_word_is(word, length, words[i].name))
            return words[i].is;
    return WORD_NONE;
}

static void count_unknown(struct obj *o, const char *word, size_t length)
{
    struct unknown *u = o->unknown;
    for (; u < &o->unknown[UNKNOWN_NAMES] && u->count > 0; u++)
        if (u->length == length && memcmp(u->name, word, length) == 0)
            break;
    *u = (struct unknown){word, length, u->count + 1};
}

/* Counts the corners of a face. */
static uint64_t count_corners(struct obj *o)
{
    struct pen_scan *s = &o->b->scan;
    uint64_t count = 0;
    for (const char *word; pen_scan_more(s); count++) {
        size_t length = pen_scan_word(s, &word);
        const char *slash = memchr(word, '/', length);
        if (slash && memchr(slash + 1, '/', length - (size_t)(slash + 1 - word)))
            o->corner_normals = true;
    }
    return count;
}

static bool count_statement(struct obj *o, const char *word, size_t length)
{
    uint64_t corners;
    switch (word_of(word, length)) {
    case WORD_V:
        o->vertices++;
        return true;
    case WORD_VN:
        o->normals++;
        return true;
    case WORD_F:
        corners = count_corners(o);
        if (corners < 3)
            return pen_scan_fail(&o->b->scan, PEN_INVALID, word,
                                 "a face of %u corners; write three or more", (unsigned)corners);
        o->triangles += corners - 2;
        return true;
    case WORD_USEMTL:
        o->materials = true;
        return true;
    case WORD_MTLLIB:
        return pen_mtl_read(&o->mtl, o->b);
    case WORD_CURVE:
        return pen_scan_fail(&o->b->scan, PEN_UNSUPPORTED, word,
                             "%s belongs to a curve or a curved surface, which are not read; "
                             "export the model as polygons",
                             pen_scan_found(&o->b->scan, word).text);
    case WORD_NONE:
        count_unknown(o, word, length);
        return true;
    case WORD_SILENT:
        break;
    }
    return true;
}

static bool read_three(struct obj *o, const char *word, struct pen_number x[3])
{
    struct pen_scan *s = &o->b->scan;
    for (int i = 0; i < 3; i++) {
        if (!pen_scan_more(s))
            return pen_scan_fail(s, PEN_SYNTAX, word, "%s needs three numbers",
                                 pen_scan_found(s, word).text);
        if (!pen_scan_number(s, &x[i]))
            return false;
    }
    return true;
}

static bool read_vector(struct obj *o, const char *word, size_t length)
{
    struct pen_model *m = o->b->m;
    struct pen_number x[3];
    if (word[0] != 'v' || length > 2 || (length == 2 && word[1] != 'n'))
        return true;
    if (!read_three(o, word, x))
        return false;
    if (length == 1)
        pen_build_vertex(o->b, x, m->vertex[o->vertices++]);
    else
        for (int i = 0; m->normal && i < 3; i++)
            m->normal[o->normals][i] = x[i].f;
    o->normals += length == 2;
    return true;
}

/* Reads an index from 1, or from the end if it is negative. `count` are before it, and `all` in the
 * file. */
static bool read_index(struct obj *o, const char *what, uint64_t count, uint64_t all, uint32_t *out)
{
    struct pen_scan *s = &o->b->scan;
    const char *at = s->at, *first = at + (at < s->end && *at == '-');
    uint64_t n = 0;
    for (s->at = first; s->at < s->end && *s->at >= '0' && *s->at <= '9'; s->at++)
        n = n < UINT32_MAX ? n * 10 + (uint64_t)(*s->at - '0') : n;
    if (s->at == first)
        return pen_scan_fail(s, PEN_SYNTAX, at,
                             "found %s in a face; write corners as v, v/vt, v//vn or v/vt/vn",
                             pen_scan_found(s, at).text);
    if (n == 0 || (first > at ? n > count : n > all))
        return pen_scan_fail(s, PEN_INVALID, at,
                             "the %s %s does not exist: the file has %llu, numbered from 1, and "
                             "%llu before this line",
                             what, pen_scan_found(s, at).text, (unsigned long long)all,
                             (unsigned long long)count);
    *out = (uint32_t)(first > at ? count - n : n - 1);
    return true;
}

/* Reads a corner: v, v/vt, v//vn or v/vt/vn. vt is not looked at. */
static bool read_corner(struct obj *o)
{
    struct pen_build *b = o->b;
    struct pen_scan *s = &b->scan;
    const char *at = s->at;
    uint32_t v, n = PEN_MODEL_NO_NORMAL;
    if (!read_index(o, "vertex", o->vertices, b->m->vertex_count, &v))
        return false;
    if (s->at < s->end && *s->at == '/') {
        for (s->at++; s->at < s->end && (*s->at == '-' || (*s->at >= '0' && *s->at <= '9'));
             s->at++)
            ;
        if (s->at < s->end && *s->at == '/') {
            s->at++;
            if (!read_index(o, "normal", o->normals, b->m->normal_count, &n))
                return false;
        }
    }
    if (s->at < s->end && !pen_is_space(*s->at) && *s->at != '\\')
        return pen_scan_fail(s, PEN_SYNTAX, at,
                             "found %s in a face; write corners as v, v/vt, v//vn or v/vt/vn",
                             pen_scan_found(s, at).text);
    if (!pen_build_corner(b, at, v))
        return false;
    b->face_normal[b->face_count - 1] = n;
    return true;
}

/* The place of the current material in the model, where its first face adds it. */
static bool use_material(struct obj *o, const char *at)
{
    struct pen_model *m = o->b->m;
    if (!o->b->m->material_of || o->current->used > 0) {
        o->b->material = (uint16_t)(o->current->used - (o->current->used > 0));
        return true;
    }
    if (m->material_count == MATERIALS)
        return pen_scan_fail(&o->b->scan, PEN_TOO_LARGE, at, "more than %d materials", MATERIALS);
    o->b->material = (uint16_t)m->material_count++;
    o->current->used = m->material_count;
    return true;
}

static bool read_face(struct obj *o, const char *word)
{
    struct pen_build *b = o->b;
    bool all = true;
    while (pen_scan_more(&b->scan))
        if (!read_corner(o))
            return false;
    for (uint32_t i = 0; i < b->face_count; i++)
        all = all && b->face_normal[i] != PEN_MODEL_NO_NORMAL;
    for (uint32_t i = 0; !all && i < b->face_count; i++)
        b->face_normal[i] = PEN_MODEL_NO_NORMAL;
    return use_material(o, word) && pen_build_face(b, word);
}

static void read_usemtl(struct obj *o, const char *word)
{
    const char *name;
    char shown[PEN_MODEL_NAME_BYTES];
    size_t length = pen_scan_rest(&o->b->scan, &name);
    struct pen_mtl_material *found = pen_mtl_find(&o->mtl, name, length);
    o->current = found ? found : &o->mtl.material[0];
    if (found)
        return;
    snprintf(shown, sizeof shown, "%.*s", (int)(length < 60 ? length : 60), name);
    pen_build_note(o->b, word, "no MTL file has the material %s; its faces are grey",
                   pen_text_quote(shown).text);
}

static bool read_element(struct obj *o, const char *word, size_t length)
{
    switch (word_of(word, length)) {
    case WORD_V:
        o->vertices++;
        return true;
    case WORD_VN:
        o->normals++;
        return true;
    case WORD_F:
        return read_face(o, word);
    case WORD_USEMTL:
        read_usemtl(o, word);
        return true;
    case WORD_MTLLIB:
    case WORD_SILENT:
    case WORD_CURVE:
    case WORD_NONE:
        break;
    }
    return true;
}

/* Gives each statement of the file to a function. */
static bool pass(struct obj *o, bool (*each)(struct obj *, const char *, size_t))
{
    struct pen_scan *s = &o->b->scan;
    const char *word;
    size_t length;
    o->vertices = o->normals = 0;
    for (s->at = s->begin; pen_scan_statement(s, &word, &length); pen_scan_next_line(s))
        if (!each(o, word, length))
            return false;
    return true;
}

static bool make_space(struct obj *o)
{
    struct pen_build *b = o->b;
    struct pen_model *m = b->m;
    const uint64_t vertices = o->vertices, normals = o->corner_normals ? o->normals : 0;
    if (vertices >= UINT32_MAX || o->normals >= UINT32_MAX)
        return pen_fail(b->scan.st, PEN_TOO_LARGE, "The model has more than 4294967294 vertices");
    if (!pen_build_space(b, o->triangles, o->materials) ||
        !(m->vertex = pen_build_alloc(b, vertices, sizeof *m->vertex)) ||
        (normals > 0 && !(m->normal = pen_build_alloc(b, normals, sizeof *m->normal))) ||
        (normals > 0 &&
         !(m->corner_normal = pen_build_alloc(b, o->triangles, sizeof *m->corner_normal))))
        return false;
    m->vertex_count = (uint32_t)vertices;
    m->normal_count = (uint32_t)normals;
    return true;
}

static bool take_materials(struct obj *o)
{
    struct pen_model *m = o->b->m;
    if (!m->material_of)
        return true;
    if (!(m->material = pen_build_alloc(o->b, m->material_count, sizeof *m->material)))
        return false;
    for (uint32_t i = 0; i < o->mtl.materials; i++)
        if (o->mtl.material[i].used > 0)
            m->material[o->mtl.material[i].used - 1] = o->mtl.material[i].is;
    return true;
}

static void note_unknown(struct obj *o)
{
    for (const struct unknown *u = o->unknown; u <= &o->unknown[UNKNOWN_NAMES] && u->count; u++)
        if (u < &o->unknown[UNKNOWN_NAMES])
            pen_build_note(o->b, u->name, "%u statements %s are not read", u->count,
                           pen_scan_found(&o->b->scan, u->name).text);
        else
            pen_build_note(o->b, u->name, "%u statements of other names are not read", u->count);
}

static bool read(struct obj *o)
{
    if (!pass(o, count_statement) || !make_space(o) || !pen_mtl_index(&o->mtl, o->b))
        return false;
    do {
        pen_build_begin_vertices(o->b);
        if (!pass(o, read_vector))
            return false;
    } while (pen_build_far(o->b));
    o->current = &o->mtl.material[0];
    if (!pass(o, read_element) || !take_materials(o))
        return false;
    note_unknown(o);
    return true;
}

bool pen_obj_read(struct pen_build *b)
{
    struct obj o = {.b = b};
    bool ok = read(&o);
    pen_mtl_release(&o.mtl, b);
    return ok;
}
