/* SPDX-License-Identifier: MIT */
/* Properties of the XML reader for any text. It does not crash. Every error and warning has a line
 * and a column in the text. An accepted scene equals the scene that is read from its values written
 * as JSON. A failure prints the seed: PEN_SEED=… repeats it. */
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "support/corrupt.h"
#include "support/suite.h"

static const char *const tokens[] = {"<",
                                     ">",
                                     "/>",
                                     "</",
                                     "\"",
                                     "'",
                                     "=",
                                     "&",
                                     "&#32;",
                                     "&lt;",
                                     "&x;",
                                     "<!--",
                                     "-->",
                                     "<![CDATA[",
                                     "]]>",
                                     "<?",
                                     "?>",
                                     "<!DOCTYPE a [",
                                     "<group>",
                                     "</group>",
                                     "<sphere/>",
                                     "<transform/>",
                                     "<views><view/></views>",
                                     " material=\"m\"",
                                     " p0='0 0 0'",
                                     " P3='0 0 1'",
                                     " kD='.5'",
                                     " kq='+1f'",
                                     "<material kd='1'/>",
                                     "<pointLight intensity='1 1 1'/>",
                                     ";",
                                     "1e999",
                                     "-0",
                                     "0",
                                     " ",
                                     "\n",
                                     "\xC3",
                                     "\xE2\x82\xAC",
                                     "\xEF\xBB\xBF",
                                     "\x01",
                                     "nan"};

static const struct corrupt_kind kind = {tokens, sizeof tokens / sizeof tokens[0]};

/* Whether a position is in the text or at its end. Of UTF-16 the corpus has the positions. */
static bool is_inside(const struct corrupt_text *text, const struct pen_status *st)
{
    if (pen_text_is_utf16(text->data, text->bytes))
        return st->line > 0 && st->column > 0;
    int line = 1, column = 1;
    size_t i = text->bytes >= 3 && memcmp(text->data, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    for (; i <= text->bytes; i++) {
        if (line == st->line && column == st->column)
            return true;
        if (i < text->bytes && text->data[i] == '\n') {
            line++;
            column = 1;
        } else if (i + 1 >= text->bytes || (text->data[i + 1] & 0xC0) != 0x80) {
            column++;
        }
    }
    return false;
}

static void check_places(const struct corrupt_text *text, const struct pen_errors *errors,
                         const struct random *random)
{
    for (size_t i = 0; i < errors->count; i++) {
        const struct pen_status *st = &errors->item[i];
        ck_assert_msg(is_inside(text, st), "PEN_SEED=%llu: %d:%d: %s\n%.*s",
                      (unsigned long long)random->seed, st->line, st->column, st->msg,
                      (int)text->bytes, text->data);
        ck_assert(st->msg[0] != '\0' && st->at[0] == '\0');
        ck_assert_msg(i == 0 || errors->item[i - 1].line <= st->line, "not in order");
    }
}

static bool same_objects(const struct pen_object_desc *a, const struct pen_object_desc *b,
                         uint32_t count)
{
    bool same = true;
    for (uint32_t i = 0; i < count && same; i++) {
        same = a[i].kind == b[i].kind && a[i].material == b[i].material;
        if (same && a[i].kind == PEN_OBJECT_GROUP)
            same = a[i].u.group.count == b[i].u.group.count &&
                   same_objects(a[i].u.group.objects, b[i].u.group.objects, a[i].u.group.count);
        else if (same && a[i].kind == PEN_OBJECT_SPHERE)
            same = memcmp(&a[i].u.sphere, &b[i].u.sphere, sizeof a[i].u.sphere) == 0;
        else if (same && a[i].kind == PEN_OBJECT_PLANE)
            same = memcmp(&a[i].u.plane, &b[i].u.plane, sizeof a[i].u.plane) == 0;
    }
    return same;
}

static bool same_pattern(const struct pen_pattern *a, const struct pen_pattern *b)
{
    if (!a || !b)
        return a == b;
    return a->checker == b->checker &&
           memcmp(&a->a, &b->a, sizeof *a - offsetof(struct pen_pattern, a)) == 0;
}

static bool same_material(const struct pen_material *a, const struct pen_material *b)
{
    struct pen_material plain_a = *a, plain_b = *b;
    bool same = !a->patterns == !b->patterns;
    for (int i = 0; a->patterns && b->patterns && i < PEN_MATERIAL_COLOURS; i++)
        same = same && same_pattern(a->patterns->of[i], b->patterns->of[i]);
    plain_a.patterns = plain_b.patterns = NULL;
    return same && memcmp(&plain_a, &plain_b, sizeof plain_a) == 0;
}

/* -0 in a colour may become 0; everything else keeps its bits. */
static void check_round_trip(const struct pen_document *document, const struct pen_scene_desc *desc,
                             const struct random *random)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0};
    struct pen_status st;
    struct pen_scene_desc again;
    struct pen_buf out = {0};
    struct pen_arena *arena = pen_arena_new(0);
    ck_assert(pen_json_write(document->json, &out));
    json_t *json = pen_json_parse((char *)out.data, out.bytes, &limits, &st);
    ck_assert_msg(json != NULL, "PEN_SEED=%llu: %s", (unsigned long long)random->seed, st.msg);
    bool ok = pen_scene_read(json, "", &limits, arena, &again, &errors);
    ck_assert_msg(ok, "PEN_SEED=%llu: %s: %s", (unsigned long long)random->seed, errors.item[0].at,
                  errors.item[0].msg);
    ck_assert_uint_eq(again.object_count, desc->object_count);
    ck_assert_uint_eq(again.material_count, desc->material_count);
    ck_assert_uint_eq(again.light_count, desc->light_count);
    ck_assert_uint_eq(again.view_count, desc->view_count);
    const struct pen_settings *a = &again.settings, *b = &desc->settings;
    ck_assert(a->width == b->width && a->height == b->height && a->seed == b->seed);
    ck_assert(a->transfer == b->transfer && a->min_contribution == b->min_contribution);
    for (uint32_t i = 0; i < desc->material_count; i++)
        ck_assert(same_material(&again.materials[i], &desc->materials[i]));
    ck_assert(same_objects(again.objects, desc->objects, desc->object_count));
    json_decref(json);
    pen_arena_free(arena);
    pen_buf_release(&out);
}

/* Reads a copy of exact size. Returns whether it is a scene. */
static bool check(const struct corrupt_text *text, const struct random *random)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_errors errors = {0}, warnings = {0};
    struct pen_document document;
    struct pen_scene_desc desc;
    struct pen_status st = {0};
    struct pen_arena *arena = pen_arena_new(0);
    char *exact = malloc(text->bytes ? text->bytes : 1);
    memcpy(exact, text->data, text->bytes);
    bool parsed = pen_document_parse(exact, text->bytes, true, &limits, &document, &st);
    bool ok = parsed && pen_document_read(&document, &limits, arena, &desc, &errors);
    if (!parsed)
        pen_errors_add(&errors, &st);
    ck_assert(ok == (errors.total == 0));
    check_places(text, &errors, random);
    if (ok) {
        pen_scene_warnings(document.json, "", &desc, &warnings);
        for (size_t i = 0; i < warnings.count; i++)
            pen_document_locate(&document, &warnings.item[i]);
        for (size_t i = 0; i < warnings.count; i++)
            ck_assert(is_inside(text, &warnings.item[i]));
        check_round_trip(&document, &desc, random);
    }
    pen_document_release(&document);
    pen_arena_free(arena);
    free(exact);
    return ok;
}

START_TEST(test_xml_property__corrupted_text_gives_errors_with_positions)
{
    static struct corrupt_text text;
    struct random random = random_begin(1);
    glob_t files;
    int accepted = 0;
    ck_assert_int_eq(glob("tests/io/corpus/xml-*/*.xml", 0, NULL, &files), 0);
    ck_assert_int_eq(glob("tests/golden/xml/*.xml", GLOB_APPEND, NULL, &files), 0);
    for (int i = 0; i < 20000; i++) {
        corrupt_read(files.gl_pathv[random_below(&random, (uint32_t)files.gl_pathc)], &text);
        for (uint32_t changes = random_below(&random, 4); changes > 0; changes--)
            corrupt(&random, &text, &kind);
        accepted += check(&text, &random);
    }
    globfree(&files);
    ck_assert_int_gt(accepted, 500);
}
END_TEST

PEN_SUITE("io/xml_property", test_xml_property__corrupted_text_gives_errors_with_positions)
