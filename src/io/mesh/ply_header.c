/* SPDX-License-Identifier: MIT */
#include "io/mesh/ply.h"

static const char *const types[][2] = {
    {"char", "int8"}, {"uchar", "uint8"}, {"short", "int16"},   {"ushort", "uint16"},
    {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"}, {"double", "float64"}};

/* Reads a word of the line; empty at its end. */
static size_t word_of_line(struct pen_scan *s, const char **word)
{
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t'))
        s->at++;
    return pen_scan_word(s, word);
}

static bool unexpected(const struct pen_scan *s, const char *at, const char *wanted)
{
    return pen_scan_fail(s, PEN_SYNTAX, at, "found %s in the header of a PLY file; write %s",
                         pen_scan_found(s, at).text, wanted);
}

static bool read_type(struct pen_scan *s, enum pen_ply_type *type)
{
    const char *word;
    size_t length = word_of_line(s, &word);
    for (unsigned i = 0; i < sizeof types / sizeof types[0]; i++) {
        if (pen_word_is(word, length, types[i][0]) || pen_word_is(word, length, types[i][1])) {
            *type = (enum pen_ply_type)i;
            return true;
        }
    }
    return unexpected(s, word, "a type: char, uchar, short, ushort, int, uint, float or double");
}

static bool read_format(struct pen_ply *ply, struct pen_scan *s)
{
    static const char *const formats[] = {"ascii", "binary_little_endian", "binary_big_endian"};
    const uint16_t one = 1;
    const char *word, *version;
    size_t length = word_of_line(s, &word);
    for (int i = 0; i < 3; i++) {
        if (!pen_word_is(word, length, formats[i]))
            continue;
        ply->binary = i > 0;
        ply->swapped = i == (*(const unsigned char *)&one == 1 ? 2 : 1);
        length = word_of_line(s, &version);
        return pen_word_is(version, length, "1.0") || unexpected(s, version, "the version 1.0");
    }
    return unexpected(s, word, "a format: ascii, binary_little_endian or binary_big_endian");
}

static bool read_element(struct pen_ply *ply, struct pen_scan *s)
{
    struct pen_ply_element *e = &ply->element[ply->elements];
    struct pen_number count;
    if (ply->elements == PLY_ELEMENTS)
        return unexpected(s, s->at, "at most 16 elements");
    *e = (struct pen_ply_element){.first = ply->properties};
    e->name_length = word_of_line(s, &e->name);
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t'))
        s->at++;
    const char *at = s->at;
    if (!pen_scan_number(s, &count))
        return false;
    if (count.d < 0 || count.d > UINT32_MAX - 1 || count.d != (double)(uint32_t)count.d)
        return unexpected(s, at, "a count below 4294967295");
    e->count = (uint32_t)count.d;
    ply->elements++;
    if (pen_word_is(e->name, e->name_length, "vertex") && !ply->vertices)
        ply->vertices = e;
    if (pen_word_is(e->name, e->name_length, "face") && !ply->faces)
        ply->faces = e;
    return true;
}

static enum pen_ply_role role_of(const struct pen_ply *ply, const char *word, size_t length,
                                 bool list)
{
    static const char *const names[] = {"x", "y", "z", "nx", "ny", "nz"};
    const struct pen_ply_element *e = &ply->element[ply->elements - 1];
    for (int i = 0; e == ply->vertices && !list && i < 6; i++)
        if (pen_word_is(word, length, names[i]))
            return (enum pen_ply_role)i;
    return e == ply->faces && list &&
                   (pen_word_is(word, length, "vertex_indices") ||
                    pen_word_is(word, length, "vertex_index"))
               ? PLY_CORNERS
               : PLY_SKIPPED;
}

static bool read_property(struct pen_ply *ply, struct pen_scan *s, const char *line)
{
    struct pen_ply_property *p = &ply->property[ply->properties];
    const char *word;
    if (ply->elements == 0)
        return unexpected(s, line, "the property after its element");
    if (ply->properties == PLY_PROPERTIES)
        return unexpected(s, line, "at most 192 properties");
    struct pen_ply_element *e = &ply->element[ply->elements - 1];
    const char *type = s->at;
    size_t length = word_of_line(s, &word);
    *p = (struct pen_ply_property){.list = pen_word_is(word, length, "list")};
    if (!p->list)
        s->at = type;
    if ((p->list && !read_type(s, &p->count_type)) || !read_type(s, &p->type))
        return false;
    length = word_of_line(s, &word);
    p->role = role_of(ply, word, length, p->list);
    if (p->role != PLY_SKIPPED && (e->roles & 1u << p->role))
        return unexpected(s, word, "each property once");
    e->roles |= 1u << p->role;
    e->lists = e->lists || p->list;
    e->bytes += pen_ply_size(p->list ? p->count_type : p->type);
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

bool pen_ply_header(struct pen_ply *ply)
{
    struct pen_scan *s = &ply->b->scan;
    const char *word;
    bool format = false, ok = true;
    size_t length = word_of_line(s, &word);
    if (!pen_word_is(word, length, "ply"))
        return unexpected(s, word, "ply as the first line");
    while (ok && end_line(s)) {
        length = word_of_line(s, &word);
        if (pen_word_is(word, length, "end_header")) {
            if (!format)
                return unexpected(s, word, "a line with the format before it");
            return end_line(s) || unexpected(s, s->at, "the data after end_header");
        }
        if (pen_word_is(word, length, "format"))
            ok = format = read_format(ply, s);
        else if (pen_word_is(word, length, "element"))
            ok = read_element(ply, s);
        else if (pen_word_is(word, length, "property"))
            ok = read_property(ply, s, word);
        else if (length > 0 && !pen_word_is(word, length, "comment") &&
                 !pen_word_is(word, length, "obj_info"))
            pen_build_note(ply->b, word, "the line %s of the header is not known and passed over",
                           pen_scan_found(s, word).text);
    }
    return ok && unexpected(s, s->end, "end_header: the file is truncated");
}
