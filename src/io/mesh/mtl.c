/* SPDX-License-Identifier: MIT */
/* MTL: Kd, Ks, Ke, Ns, Ni, and d or Tr are read. Ka, illum and sharpness have no meaning here. A
 * warning names what else a material has.
 * Source: Wavefront, "MTL material format", appendix of the Advanced Visualizer's manual, 1995. */
#include "io/mesh/mtl.h"

#include <float.h>
#include <stddef.h>
#include <strings.h>

enum { NAME_BYTES = 256, FILES = 64 };

/* The statements that are read: `numbers` of them, from 0 to `most`, go to `offset` in the
 * material. */
static const struct statement {
    const char *name;
    unsigned numbers;
    float most;
    size_t offset;
} statements[] = {{"Kd", 3, 1, offsetof(struct pen_model_material, diffuse)},
                  {"Ks", 3, 1, offsetof(struct pen_model_material, specular)},
                  {"Ke", 3, FLT_MAX, offsetof(struct pen_model_material, emission)},
                  {"Ns", 1, FLT_MAX, offsetof(struct pen_model_material, shininess)},
                  {"Ni", 1, FLT_MAX, offsetof(struct pen_model_material, ior)},
                  {"d", 1, 1, offsetof(struct pen_model_material, opacity)},
                  {"Tr", 1, 1, offsetof(struct pen_model_material, opacity)},
                  {"Ka", 0, 0, 0},
                  {"illum", 0, 0, 0},
                  {"sharpness", 0, 0, 0}};

/* An MTL that is read. */
struct reader {
    struct pen_build *b;
    const char *text; /* of all MTL files */
    struct pen_scan scan;
    struct pen_mtl_material *material;
    char lost[160]; /* the statements of the material that are not read */
};

static void add_lost(struct reader *r, const char *word)
{
    struct pen_text shown = pen_scan_found(&r->scan, word);
    size_t used = strlen(r->lost);
    if (!strstr(r->lost, shown.text) && used + strlen(shown.text) + 3 < sizeof r->lost)
        snprintf(r->lost + used, sizeof r->lost - used, "%s%s", used ? ", " : "", shown.text);
}

/* The name of the material in quotes. */
static struct pen_text name_of(const struct reader *r)
{
    char name[200]; /* more than is shown */
    const size_t length = r->material->length;
    snprintf(name, sizeof name, "%.*s", (int)(length < sizeof name ? length : sizeof name),
             r->text + r->material->name);
    return pen_text_quote(name);
}

/* Takes the nearest numbers from 0 to the most that the statement allows, with a warning that shows
 * the first that differs. */
static void take_numbers(struct reader *r, const struct statement *is,
                         const struct pen_number found[3], float *to)
{
    bool told = false;
    for (unsigned i = 0; i < is->numbers; i++) {
        const float f = found[i].f;
        to[i] = f < 0 ? 0 : f > is->most ? is->most : f;
        if (to[i] != f && !told)
            pen_build_note(r->b, NULL, "the material %s has %s %s; it is taken as %s",
                           name_of(r).text, is->name, pen_text_number((double)f).text,
                           pen_text_number((double)to[i]).text);
        told = told || to[i] != f;
    }
}

/* One number of a colour stands for three. */
static bool read_numbers(struct reader *r, const struct statement *is)
{
    float *to = (float *)(void *)((char *)&r->material->is + is->offset);
    struct pen_number n[3];
    unsigned count = 0;
    for (; count < is->numbers && pen_scan_more(&r->scan); count++)
        if (!pen_scan_number(&r->scan, &n[count]))
            return false;
    if (count != 1 && count != is->numbers)
        return pen_scan_fail(&r->scan, PEN_SYNTAX, r->scan.at, "%s needs %u numbers", is->name,
                             is->numbers);
    for (; count < is->numbers; count++)
        n[count] = n[0];
    take_numbers(r, is, n, to);
    if (is->name[0] == 'T')
        *to = 1 - *to;
    return true;
}

/* Colours may also be given in other ways, as Kd spectral FILE, Kd xyz, d -halo. */
static bool read_statement(struct reader *r, const char *word, size_t length)
{
    const char *next;
    const struct statement *is = statements, *end = is + sizeof statements / sizeof statements[0];
    while (is < end && !pen_word_is(word, length, is->name))
        is++;
    if (is < end && is->numbers == 0)
        return true;
    pen_scan_more(&r->scan);
    struct pen_scan ahead = r->scan;
    const size_t ahead_length = pen_scan_word(&ahead, &next);
    if (is == end || pen_word_is(next, ahead_length, "spectral") ||
        pen_word_is(next, ahead_length, "xyz") || pen_word_is(next, ahead_length, "-halo")) {
        add_lost(r, word);
        return true;
    }
    return read_numbers(r, is);
}

/* Warns of what the material has lost. */
static void end_material(struct reader *r)
{
    if (r->lost[0])
        pen_build_note(r->b, NULL, "the material %s loses %s%s", name_of(r).text, r->lost,
                       strstr(r->lost, "\"map_Kd\"") ? "; its colour stays Kd" : "");
    r->lost[0] = '\0';
}

bool pen_mtl_add(struct pen_mtl *mtl, struct pen_build *b, size_t name, size_t length)
{
    if (mtl->count == mtl->space && !pen_build_grow(b, (void **)&mtl->material, &mtl->space,
                                                    mtl->count + 1, sizeof *mtl->material))
        return false;
    mtl->material[mtl->count++] = (struct pen_mtl_material){
        .name = name,
        .length = length,
        .is = {.diffuse = {0.8f, 0.8f, 0.8f}, .shininess = 1, .opacity = 1}};
    return true;
}

/* Reads the text from `from` on. */
static bool parse(struct pen_mtl *mtl, struct pen_build *b, size_t from)
{
    const char *text = (const char *)mtl->text.data, *word;
    struct reader r = {
        b, text, {text + from, text + from, text + mtl->text.bytes, false, b->scan.st}, NULL, ""};
    size_t length;
    bool ok = true;
    for (; ok && pen_scan_statement(&r.scan, &word, &length); pen_scan_next_line(&r.scan)) {
        if (pen_word_is(word, length, "newmtl")) {
            end_material(&r);
            length = pen_scan_rest(&r.scan, &word);
            ok = pen_mtl_add(mtl, b, (size_t)(word - text), length);
            r.material = ok ? &mtl->material[mtl->count - 1] : NULL;
        } else {
            ok = r.material
                     ? read_statement(&r, word, length)
                     : pen_scan_fail(&r.scan, PEN_SYNTAX, word, "found %s before the first newmtl",
                                     pen_scan_found(&r.scan, word).text);
        }
    }
    end_material(&r);
    return ok;
}

/* Makes a name a path inside the model's folder. */
static bool make_path(struct pen_scan *s, const char *name, size_t length, char path[NAME_BYTES])
{
    size_t n = 0;
    for (; n < length && n < NAME_BYTES - 1 && (unsigned char)name[n] >= ' '; n++)
        path[n] = name[n] == '\\' ? '/' : name[n];
    path[n] = '\0';
    while (strncmp(path, "./", 2) == 0)
        memmove(path, path + 2, strlen(path + 2) + 1);
    return (n == length && pen_model_name_is_inside(path) && path[1] != ':') ||
           pen_scan_fail(s, PEN_INVALID, name,
                         "%s is no path inside the model's folder; put the MTL file beside "
                         "the model and write its name",
                         pen_text_quote(path).text);
}

static bool read_file(struct pen_mtl *mtl, struct pen_build *b, const char *name, size_t length)
{
    char path[NAME_BYTES];
    struct pen_scan *s = &b->scan;
    struct pen_status why = {0};
    const size_t from = mtl->text.bytes;
    if (mtl->files > 0 && mtl->length == length && memcmp(mtl->name, name, length) == 0)
        return true; /* exporters repeat it for each object */
    if (!make_path(s, name, length, path))
        return false;
    if (mtl->files++ == FILES)
        return pen_scan_fail(s, PEN_TOO_LARGE, name, "more than %d statements mtllib", FILES);
    mtl->name = name;
    mtl->length = length;
    if (!b->file->fetch)
        pen_fail(&why, PEN_UNSUPPORTED, "other files are not read here");
    if (why.code || !b->file->fetch(b->file->self, path, &mtl->text, &why))
        return pen_scan_fail(s, why.code, name,
                             "the MTL file %s cannot be read: %.200s; put it beside the model, or "
                             "remove this line",
                             pen_text_quote(path).text, why.msg);
    b->left += 4 * (mtl->text.bytes - from);
    if (mtl->text.bytes == from || parse(mtl, b, from))
        return true;
    why = *s->st;
    return why.line > 0 && pen_scan_fail(s, why.code, name, "%s, line %d: %.300s",
                                         pen_text_quote(path).text, why.line, why.msg);
}

/* A name may contain spaces; it ends with .mtl, or with the line. */
bool pen_mtl_read(struct pen_mtl *mtl, struct pen_build *b)
{
    const char *rest;
    struct pen_scan line = b->scan; /* as for usemtl */
    size_t length = pen_scan_rest(&line, &rest), n;
    do {
        for (n = 0; n < length; n++)
            if (n >= 4 && strncasecmp(rest + n - 4, ".mtl", 4) == 0 && pen_is_space(rest[n]))
                break;
        if (!read_file(mtl, b, rest, n))
            return false;
        while (n < length && pen_is_space(rest[n]))
            n++;
        rest += n;
        length -= n;
    } while (length > 0);
    return true;
}

void pen_mtl_release(struct pen_mtl *mtl, struct pen_build *b)
{
    pen_buf_release(&mtl->text);
    pen_build_free(b, mtl->material, mtl->space, sizeof *mtl->material);
}
