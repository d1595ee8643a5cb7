/* SPDX-License-Identifier: MIT */
/* MTL: Kd, Ks, Ke, Ns, d or Tr, and Ni. Ka, illum and sharpness mean nothing here. A warning names
 * all other statements of a material.
 * Source: Wavefront, "MTL material format (Lightwave, OBJ)", appendix of the Advanced Visualizer's
 * manual, 1995. */
#include "io/mesh/mtl.h"

#include <stddef.h>

#include "base/utf8.h"

enum { NAME_BYTES = 256 };

static const struct pen_model_material standard = {
    .diffuse = {0.8f, 0.8f, 0.8f}, .opacity = 1, .ior = 1};

/* The statements that are read: `numbers` of them go to `offset` in the material. */
static const struct statement {
    const char *name;
    unsigned given, numbers;
    size_t offset;
} statements[] = {{"Kd", PEN_MODEL_KD, 3, offsetof(struct pen_model_material, diffuse)},
                  {"Ks", PEN_MODEL_KS, 3, offsetof(struct pen_model_material, specular)},
                  {"Ke", PEN_MODEL_KE, 3, offsetof(struct pen_model_material, emission)},
                  {"Ns", PEN_MODEL_NS, 1, offsetof(struct pen_model_material, shininess)},
                  {"Ni", PEN_MODEL_NI, 1, offsetof(struct pen_model_material, ior)},
                  {"d", PEN_MODEL_D, 1, offsetof(struct pen_model_material, opacity)},
                  {"Tr", PEN_MODEL_D, 1, offsetof(struct pen_model_material, opacity)}};

/* An MTL that is read. */
struct reader {
    struct pen_build *b;
    struct pen_scan scan;
    struct pen_mtl_material *material; /* NULL before the first newmtl */
    const char *file;
    char lost[160]; /* the statements of the material that are not read */
    bool failed;
};

static bool is_silent(const char *word, size_t length)
{
    static const char *const names[] = {"Ka", "illum", "sharpness"};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++)
        if (pen_word_is(word, length, names[i]))
            return true;
    return false;
}

static void add_lost(struct reader *r, const char *word, size_t length)
{
    char name[16];
    snprintf(name, sizeof name, "%.*s", (int)(length < 15 ? length : 15), word);
    const char *shown = pen_text_quote(name).text;
    size_t used = strlen(r->lost);
    if (!strstr(r->lost, shown) && used + strlen(shown) + 3 < sizeof r->lost)
        snprintf(r->lost + used, sizeof r->lost - used, "%s%s", used ? ", " : "", shown);
}

/* One number of a colour stands for three. */
static bool read_numbers(struct reader *r, const struct statement *is)
{
    float value[3] = {0}, *to = (float *)(void *)((char *)&r->material->is + is->offset);
    unsigned count = 0;
    for (; count < is->numbers && pen_scan_more(&r->scan); count++) {
        struct pen_number n;
        if (!pen_scan_number(&r->scan, &n))
            return false;
        value[count] = n.f;
    }
    if (count == 0 || count == 2)
        return pen_scan_fail(&r->scan, PEN_SYNTAX, r->scan.at, "%s needs %s", is->name,
                             is->numbers == 3 ? "three numbers" : "a number");
    for (unsigned i = 0; i < is->numbers; i++)
        to[i] = i < count ? value[i] : value[0];
    if (pen_word_is("Tr", 2, is->name))
        *to = 1 - *to;
    r->material->is.given |= is->given;
    return true;
}

static bool read_statement(struct reader *r, const char *word, size_t length)
{
    const char *next;
    for (size_t i = 0; i < sizeof statements / sizeof statements[0]; i++) {
        if (!pen_word_is(word, length, statements[i].name))
            continue;
        if (!r->material)
            return pen_scan_fail(&r->scan, PEN_SYNTAX, word, "%s before the first newmtl",
                                 statements[i].name);
        struct pen_scan before = r->scan;
        bool number = pen_scan_more(&r->scan) && strchr("+-.0123456789", *r->scan.at);
        if (!number && pen_scan_word(&r->scan, &next) > 0 && r->scan.at > next) {
            add_lost(r, word, length); /* Kd spectral, Kd xyz, d -halo */
            return true;
        }
        r->scan = before;
        return read_numbers(r, &statements[i]);
    }
    if (r->material && !is_silent(word, length))
        add_lost(r, word, length);
    return true;
}

/* Warns of what the material has lost. */
static void end_material(struct reader *r)
{
    char name[PEN_MODEL_NAME_BYTES];
    if (!r->material || !r->lost[0])
        return;
    snprintf(name, sizeof name, "%s", r->material->is.name);
    pen_build_note(r->b, NULL, "the material %s loses %s, which are not read%s",
                   pen_text_quote(name).text, r->lost,
                   strstr(r->lost, "\"map_Kd\"") ? "; its colour stays Kd" : "");
    r->lost[0] = '\0';
}

static void begin_material(struct pen_mtl *mtl, struct reader *r)
{
    char name[NAME_BYTES];
    end_material(r);
    r->material = &mtl->material[mtl->materials++];
    *r->material = (struct pen_mtl_material){.is = standard};
    r->material->length = pen_scan_rest(&r->scan, &r->material->name);
    snprintf(name, sizeof name, "%.*s",
             (int)(r->material->length < 200 ? r->material->length : 200), r->material->name);
    pen_utf8_copy(r->material->is.name, sizeof r->material->is.name, name);
}

/* Makes space for the materials of a text. */
static bool reserve(struct pen_mtl *mtl, struct pen_build *b, struct pen_scan scan)
{
    const char *word;
    size_t length;
    uint32_t more = mtl->space == 0;
    while (pen_scan_statement(&scan, &word, &length)) {
        more += pen_word_is(word, length, "newmtl");
        pen_scan_next_line(&scan);
    }
    struct pen_mtl_material *all = pen_build_alloc(b, (uint64_t)mtl->space + more, sizeof *all);
    if (!all)
        return false;
    if (mtl->material)
        memcpy(all, mtl->material, mtl->materials * sizeof *all);
    else
        all[mtl->materials++] = (struct pen_mtl_material){.name = "", .is = standard};
    pen_build_free(b, mtl->material, mtl->space, sizeof *all);
    mtl->material = all;
    mtl->space += more;
    return true;
}

static bool parse(struct pen_mtl *mtl, struct pen_build *b, const struct pen_buf *text,
                  const char *file)
{
    const char *first = text->bytes > 0 ? (const char *)text->data : "", *word;
    struct reader r = {b,    {first, first, first + text->bytes, false, b->scan.st}, NULL, file, "",
                       false};
    size_t length;
    if (!reserve(mtl, b, r.scan))
        return false;
    while (!r.failed && pen_scan_statement(&r.scan, &word, &length)) {
        if (pen_word_is(word, length, "newmtl"))
            begin_material(mtl, &r);
        else
            r.failed = !read_statement(&r, word, length);
        pen_scan_next_line(&r.scan);
    }
    end_material(&r);
    return !r.failed;
}

/* Makes a name a path inside the model's folder. */
static bool make_path(struct pen_scan *s, const char *name, size_t length, char path[NAME_BYTES])
{
    size_t n = 0;
    for (; n < length && length < NAME_BYTES && (unsigned char)name[n] >= ' '; n++)
        path[n] = name[n] == '\\' ? '/' : name[n];
    path[n] = '\0';
    if (n < length || n == 0)
        return pen_scan_fail(s, PEN_SYNTAX, name,
                             "mtllib needs the name of an MTL file, of at most 255 characters");
    while (strncmp(path, "./", 2) == 0)
        memmove(path, path + 2, strlen(path + 2) + 1);
    bool out = path[0] == '/' || path[0] == '\0' || (path[0] && path[1] == ':');
    for (const char *part = path; part; part = strchr(part, '/'))
        out = out || strncmp(part += *part == '/', "../", 3) == 0 || strcmp(part, "..") == 0;
    return !out || pen_scan_fail(s, PEN_INVALID, name,
                                 "%s leads out of the model's folder; put the MTL file beside the "
                                 "model and write its name alone",
                                 pen_text_quote(path).text);
}

static bool read_library(struct pen_mtl *mtl, struct pen_build *b, const char *name, size_t length)
{
    char path[NAME_BYTES];
    struct pen_scan *s = &b->scan;
    for (uint32_t i = 0; i < mtl->libraries; i++)
        if (mtl->length[i] == length && memcmp(mtl->name[i], name, length) == 0)
            return true;
    if (!make_path(s, name, length, path))
        return false;
    if (mtl->libraries == MTL_LIBRARIES)
        return pen_scan_fail(s, PEN_TOO_LARGE, name, "more than %d MTL files", MTL_LIBRARIES);
    struct pen_buf *text = &mtl->library[mtl->libraries];
    struct pen_status why = {0};
    if (!b->file->fetch)
        pen_fail(&why, PEN_UNSUPPORTED, "no other files can be read here");
    if (!b->file->fetch || !b->file->fetch(b->file->self, path, text, &why)) {
        pen_buf_release(text);
        return pen_scan_fail(s, why.code, name,
                             "the MTL file %s cannot be read: %.200s; put it beside the model, or "
                             "remove this line",
                             pen_text_quote(path).text, why.msg);
    }
    mtl->name[mtl->libraries] = name;
    mtl->length[mtl->libraries++] = length;
    b->left += 4 * text->bytes;
    if (parse(mtl, b, text, path))
        return true;
    if (s->st->line == 0)
        return false;
    why = *s->st;
    return pen_scan_fail(s, why.code, name, "%s, line %d: %.300s", pen_text_quote(path).text,
                         why.line, why.msg);
}

/* A name may contain spaces; it ends with .mtl, or with the line. */
bool pen_mtl_read(struct pen_mtl *mtl, struct pen_build *b)
{
    const char *rest;
    size_t length = pen_scan_rest(&b->scan, &rest);
    do {
        size_t n = 0;
        while (n < length &&
               !(n >= 4 && strncasecmp(rest + n - 4, ".mtl", 4) == 0 && pen_is_space(rest[n])))
            n++;
        if (!read_library(mtl, b, rest, n))
            return false;
        for (; n < length && pen_is_space(rest[n]); n++)
            ;
        rest += n;
        length -= n;
    } while (length > 0);
    return true;
}

static uint32_t *find(const struct pen_mtl *mtl, const char *name, size_t length)
{
    uint64_t hash = 0;
    for (size_t i = 0; i < length; i++)
        hash = (hash ^ (unsigned char)name[i]) * UINT64_C(0x9E3779B97F4A7C15);
    for (hash ^= hash >> 32;; hash++) {
        uint32_t *slot = &mtl->slot[hash & (mtl->slots - 1)];
        const struct pen_mtl_material *m = *slot ? &mtl->material[*slot - 1] : NULL;
        if (!m || (m->length == length && memcmp(m->name, name, length) == 0))
            return slot;
    }
}

bool pen_mtl_index(struct pen_mtl *mtl, struct pen_build *b)
{
    const char *none = "";
    const struct pen_scan nothing = {none, none, none, false, b->scan.st};
    if (!mtl->material && !reserve(mtl, b, nothing))
        return false;
    for (mtl->slots = 16; mtl->slots < 2 * mtl->materials; mtl->slots *= 2)
        ;
    if (!(mtl->slot = pen_build_zeroed(b, mtl->slots, sizeof *mtl->slot)))
        return false;
    for (uint32_t i = 1; i < mtl->materials; i++)
        *find(mtl, mtl->material[i].name, mtl->material[i].length) = i + 1;
    return true;
}

struct pen_mtl_material *pen_mtl_find(const struct pen_mtl *mtl, const char *name, size_t length)
{
    uint32_t slot = *find(mtl, name, length);
    return slot ? &mtl->material[slot - 1] : NULL;
}

void pen_mtl_release(struct pen_mtl *mtl, struct pen_build *b)
{
    for (uint32_t i = 0; i < mtl->libraries; i++)
        pen_buf_release(&mtl->library[i]);
    pen_build_free(b, mtl->material, mtl->space, sizeof *mtl->material);
    pen_build_free(b, mtl->slot, mtl->slots, sizeof *mtl->slot);
}
