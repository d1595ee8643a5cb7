/* SPDX-License-Identifier: MIT */
/* Scenes in XML with other people's names. Each NAME.xml of tests/io/corpus/xml-spellings has the
 * values, and so the picture, of NAME.ours.xml, which has only our names. */
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "io/xml/spellings.h"
#include "support/suite.h"

static char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    ck_assert_msg(file != NULL, "%s", path);
    char *text = malloc(1 << 20);
    *bytes = fread(text, 1, (1 << 20) - 1, file);
    text[*bytes] = '\0';
    fclose(file);
    return text;
}

/* The values of a scene that is accepted. */
static json_t *values_of(const char *path)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_errors errors = {0};
    struct pen_status st;
    struct pen_scene_desc desc;
    struct pen_document document;
    size_t bytes;
    char *text = read_file(path, &bytes);
    ck_assert_msg(pen_document_parse(text, bytes, true, &limits, &document, &st), "%s:%d:%d: %s",
                  path, st.line, st.column, st.msg);
    ck_assert_msg(pen_document_read(&document, &limits, arena, &desc, &errors), "%s:%d:%d: %s",
                  path, errors.item[0].line, errors.item[0].column, errors.item[0].msg);
    json_t *json = json_incref(document.json);
    pen_document_release(&document);
    pen_arena_free(arena);
    free(text);
    return json;
}

/* Whether two values are the same scene: 60 and 60.0 are one number. */
static bool is_same(const json_t *a, const json_t *b)
{
    const char *key;
    json_t *value;
    if (json_is_number(a) && json_is_number(b))
        return json_number_value(a) == json_number_value(b);
    if (json_is_array(a) && json_is_array(b)) {
        bool same = json_array_size(a) == json_array_size(b);
        for (size_t i = 0; same && i < json_array_size(a); i++)
            same = is_same(json_array_get(a, i), json_array_get(b, i));
        return same;
    }
    if (!json_is_object(a) || !json_is_object(b))
        return json_equal(a, b);
    if (json_object_size(a) != json_object_size(b))
        return false;
    json_object_foreach((json_t *)a, key, value)
    {
        if (!json_object_get(b, key) || !is_same(value, json_object_get(b, key)))
            return false;
    }
    return true;
}

START_TEST(test_xml_spellings__each_is_the_same_scene_as_in_our_words)
{
    glob_t found;
    ck_assert_int_eq(glob("tests/io/corpus/xml-spellings/*.ours.xml", 0, NULL, &found), 0);
    ck_assert_uint_ge(found.gl_pathc, 15);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        char theirs[256];
        const char *ours = found.gl_pathv[i];
        snprintf(theirs, sizeof theirs, "%.*s.xml", (int)(strlen(ours) - strlen(".ours.xml")),
                 ours);
        json_t *a = values_of(theirs), *b = values_of(ours);
        if (!is_same(a, b)) {
            char *x = json_dumps(a, JSON_INDENT(1)), *y = json_dumps(b, JSON_INDENT(1));
            ck_abort_msg("%s: %s\nnot as in our words: %s", theirs, x, y);
        }
        json_decref(a);
        json_decref(b);
    }
    globfree(&found);
}
END_TEST

/* Whether a text has the name in front of an = or behind a <. */
static bool has_name(const char *text, const char *name, bool element)
{
    const char *const letters = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789-_";
    for (const char *at = text; *at; at++) {
        char word[64];
        size_t length = strspn(at, letters);
        if (length > 0 && length < sizeof word) {
            snprintf(word, sizeof word, "%.*s", (int)length, at);
            bool here = element ? at > text && at[-1] == '<' : at[length] == '=';
            if (here && pen_xml_same_name(word, name))
                return true;
        }
        at += length;
        if (!*at)
            break;
    }
    return false;
}

START_TEST(test_xml_spellings__every_other_name_is_in_one_of_the_scenes)
{
    static char all[1 << 18];
    glob_t found;
    ck_assert_int_eq(glob("tests/io/corpus/xml-spellings/*.xml", 0, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        size_t bytes;
        char *text = read_file(found.gl_pathv[i], &bytes);
        ck_assert_uint_lt(strlen(all) + strlen(text), sizeof all);
        if (!strstr(found.gl_pathv[i], ".ours.xml"))
            strcat(all, text);
        free(text);
    }
    globfree(&found);
    for (const struct pen_xml_spelling *row = pen_xml_spellings; row->ours; row++)
        for (const char *const *other = row->other; *other; other++)
            ck_assert_msg(strcmp(*other, "…") == 0 ||
                              has_name(all, *other, row->kind == PEN_XML_OTHER_ELEMENT),
                          "%s", *other);
}
END_TEST

/* The rows as the page has them. */
static void write_row(const struct pen_xml_spelling *row, char *out, size_t bytes)
{
    bool element = row->kind == PEN_XML_OTHER_ELEMENT, first = true;
    int used = snprintf(out, bytes, "| `%s%s%s` | %s", element ? "<" : "", row->ours,
                        element ? ">" : "", row->kind == PEN_XML_PARTS ? "its parts " : "");
    for (const char *const *other = row->other; *other; other++, first = false) {
        const char *quote = strcmp(*other, "…") == 0 ? "" : element ? "`<" : "`";
        const char *end = *quote ? (element ? ">`" : "`") : "";
        used += snprintf(out + used, bytes - (size_t)used, "%s%s%s%s", first ? "" : ", ", quote,
                         *other, end);
    }
    snprintf(out + used, bytes - (size_t)used, " |\n");
}

START_TEST(test_xml_spellings__the_page_has_the_rows_of_the_table)
{
    static const char head[] = "| name | other names |\n|---|---|\n";
    size_t bytes;
    char *page = read_file("api/scene-format.md", &bytes), *at = strstr(page, head);
    ck_assert_ptr_nonnull(at);
    at += strlen(head);
    for (const struct pen_xml_spelling *row = pen_xml_spellings; row->ours; row++) {
        char line[256];
        write_row(row, line, sizeof line);
        ck_assert_msg(strncmp(at, line, strlen(line)) == 0, "expected %sfound %.80s", line, at);
        at += strlen(line);
    }
    ck_assert_int_eq(*at, '\n');
    free(page);
}
END_TEST

PEN_SUITE("io/xml_spellings", test_xml_spellings__each_is_the_same_scene_as_in_our_words,
          test_xml_spellings__every_other_name_is_in_one_of_the_scenes,
          test_xml_spellings__the_page_has_the_rows_of_the_table)
