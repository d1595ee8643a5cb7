/* SPDX-License-Identifier: MIT */
/* The reader against tests/io/corpus. Beside each bad/NAME.json and xml-bad/NAME.xml, NAME.expect
 * lists its errors in order, one a line:
 *
 *     CODE | PLACE | PART OF THE MESSAGE
 *
 * PLACE is a JSON Pointer, or LINE:COLUMN for XML and for a syntax error. A PLACE that ends in …
 * matches every place that begins with it. The line `more | N |` means that N further errors were
 * counted but not kept. A line `schema-blind: WHY` or `not-json: WHY` is for test_schema.c.
 *
 * Beside good/NAME.json and xml-good/NAME.xml, NAME.expect lists the warnings about the scene;
 * without this file there must be none. The JSON of good-marked begins with a byte-order mark.
 * Other parsers do not read it, and so neither do the tests that compare with them. */
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "scene/scene.h"
#include "support/suite.h"

enum { LINES_MAX = PEN_ERRORS_MAX + 2 };

struct expectation {
    char code[32], place[512], part[512];
};

struct expectations {
    int count;
    size_t more;
    struct expectation line[LINES_MAX];
};

static char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return NULL;
    fseek(file, 0, SEEK_END);
    *bytes = (size_t)ftell(file);
    rewind(file);
    char *text = malloc(*bytes + 1); /* one spare byte, since malloc(0) may return NULL */
    ck_assert_uint_eq(fread(text, 1, *bytes, file), *bytes);
    fclose(file);
    return text;
}

static void copy_part(char *out, size_t bytes, const char *from, const char *to)
{
    ck_assert(to && (size_t)(to - from) < bytes);
    memcpy(out, from, (size_t)(to - from));
    out[to - from] = '\0';
}

/* Reads NAME.expect beside NAME.json; a missing file counts as empty. */
static struct expectations read_expectations(const char *json_path)
{
    struct expectations e = {0};
    char path[512];
    size_t bytes = 0;
    copy_part(path, sizeof path - 8, json_path, strrchr(json_path, '.'));
    strcat(path, ".expect");
    char *text = read_file(path, &bytes);
    for (char *line = text; line && line < text + bytes;) {
        char *end = memchr(line, '\n', (size_t)(text + bytes - line));
        ck_assert_msg(end != NULL, "%s: last line without an end", path);
        *end = '\0';
        if (strncmp(line, "schema-blind: ", 14) != 0 && strncmp(line, "not-json: ", 10) != 0) {
            ck_assert_int_lt(e.count, LINES_MAX);
            struct expectation *x = &e.line[e.count];
            char *one = strstr(line, " | "), *two = one ? strstr(one + 3, " | ") : NULL;
            ck_assert_msg(two != NULL, "%s: %s", path, line);
            copy_part(x->code, sizeof x->code, line, one);
            copy_part(x->place, sizeof x->place, one + 3, two);
            copy_part(x->part, sizeof x->part, two + 3, end);
            if (strcmp(x->code, "more") == 0)
                e.more = strtoul(x->place, NULL, 10);
            else
                e.count++;
        }
        line = end + 1;
    }
    free(text);
    return e;
}

static bool place_matches(const char *wanted, const char *found)
{
    static const char more[] = "…";
    size_t length = strlen(wanted);
    if (length >= strlen(more) && strcmp(wanted + length - strlen(more), more) == 0)
        return strncmp(wanted, found, length - strlen(more)) == 0;
    return strcmp(wanted, found) == 0;
}

/* Prints the differences. Returns whether there are none. */
static bool compare(const char *path, const struct expectations *wanted,
                    const struct pen_errors *found)
{
    bool ok = (size_t)wanted->count == found->count && found->total == found->count + wanted->more;
    for (size_t i = 0; i < found->count; i++) {
        const struct pen_status *st = &found->item[i];
        char place[PEN_AT_BYTES];
        if (st->line)
            snprintf(place, sizeof place, "%d:%d", st->line, st->column);
        else
            snprintf(place, sizeof place, "%s", st->at);
        bool fits = (int)i < wanted->count &&
                    strcmp(wanted->line[i].code, pen_code_name(st->code)) == 0 &&
                    place_matches(wanted->line[i].place, place) &&
                    strstr(st->msg, wanted->line[i].part) != NULL;
        if (!fits)
            printf("%s: found\n  %s | %s | %s\n", path, pen_code_name(st->code), place, st->msg);
        if (!fits && (int)i < wanted->count)
            printf("expected\n  %s | %s | %s\n", wanted->line[i].code, wanted->line[i].place,
                   wanted->line[i].part);
        ok &= fits;
    }
    if (!ok)
        printf("%s: %zu of %zu kept, expected %d and %zu more\n", path, found->count, found->total,
               wanted->count, wanted->more);
    fflush(stdout); /* a failed test exits without flushing */
    return ok;
}

/* Reads a copy of exact size, so that a sanitizer finds an access beyond it. */
static bool load(const char *path, struct pen_errors *errors, struct pen_errors *warnings)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    size_t bytes;
    char *file = read_file(path, &bytes);
    char *text = malloc(bytes ? bytes : 1);
    memcpy(text, file, bytes);
    struct pen_document document;
    struct pen_status st;
    bool xml = strcmp(strrchr(path, '.'), ".xml") == 0;
    bool ok = pen_document_parse(text, bytes, xml, &limits, &document, &st);
    if (ok)
        ok = pen_document_read(&document, &limits, arena, &desc, errors);
    else
        pen_errors_add(errors, &st);
    if (ok && warnings) {
        pen_scene_warnings(document.json, "", &desc, warnings);
        for (size_t i = 0; i < warnings->count; i++)
            pen_document_locate(&document, &warnings->item[i]);
    }
    pen_document_release(&document);
    free(text);
    free(file);
    pen_arena_free(arena);
    return ok;
}

static void check_refusals(const char *pattern, size_t least)
{
    glob_t files;
    int wrong = 0;
    ck_assert_int_eq(glob(pattern, 0, NULL, &files), 0);
    ck_assert_uint_ge(files.gl_pathc, least);
    for (size_t i = 0; i < files.gl_pathc; i++) {
        struct pen_errors errors = {0};
        struct expectations wanted = read_expectations(files.gl_pathv[i]);
        ck_assert_int_gt(wanted.count, 0);
        bool refused = !load(files.gl_pathv[i], &errors, NULL);
        wrong += !compare(files.gl_pathv[i], &wanted, &errors) || !refused;
    }
    globfree(&files);
    ck_assert_int_eq(wrong, 0);
}

START_TEST(test_corpus__bad_scenes_are_refused_where_and_as_expected)
{
    check_refusals("tests/io/corpus/bad/*.json", 120);
}
END_TEST

START_TEST(test_corpus__bad_xml_is_refused_where_and_as_expected)
{
    check_refusals("tests/io/corpus/xml-bad/*.xml", 130);
}
END_TEST

/* Every scene that the reader accepts can be frozen. */
START_TEST(test_corpus__good_scenes_can_be_frozen)
{
    struct pen_limits limits = pen_limits_default();
    glob_t files;
    ck_assert_int_eq(glob("tests/io/corpus/good/*.json", 0, NULL, &files), 0);
    ck_assert_int_eq(glob("tests/io/corpus/good-marked/*.json", GLOB_APPEND, NULL, &files), 0);
    ck_assert_int_eq(glob("tests/io/corpus/xml-good/*.xml", GLOB_APPEND, NULL, &files), 0);
    for (size_t i = 0; i < files.gl_pathc; i++) {
        struct pen_errors errors = {0};
        struct pen_status st = {0};
        struct pen_scene_desc desc;
        struct pen_arena *arena = pen_arena_new(0);
        size_t bytes;
        char *text = read_file(files.gl_pathv[i], &bytes);
        ck_assert(pen_scene_load(text, bytes, &limits, arena, &desc, &errors));
        struct pen_scene *scene = pen_scene_freeze(&desc, PEN_ACCEL_NONE, 0, &st);
        ck_assert_msg(scene != NULL, "%s: %s: %s", files.gl_pathv[i], st.at, st.msg);
        pen_scene_free(scene);
        pen_arena_free(arena);
        free(text);
    }
    globfree(&files);
}
END_TEST

START_TEST(test_corpus__good_scenes_are_read_with_the_warnings_expected)
{
    glob_t files;
    int wrong = 0;
    ck_assert_int_eq(glob("tests/io/corpus/good/*.json", 0, NULL, &files), 0);
    ck_assert_int_eq(glob("tests/io/corpus/good-marked/*.json", GLOB_APPEND, NULL, &files), 0);
    ck_assert_int_eq(glob("scenes/*.json", GLOB_APPEND, NULL, &files), 0);
    ck_assert_int_eq(glob("tests/io/corpus/xml-good/*.xml", GLOB_APPEND, NULL, &files), 0);
    ck_assert_int_eq(glob("tests/golden/xml/*.xml", GLOB_APPEND, NULL, &files), 0);
    for (size_t i = 0; i < files.gl_pathc; i++) {
        struct pen_errors errors = {0}, warnings = {0};
        struct expectations wanted = read_expectations(files.gl_pathv[i]), none = {0};
        bool read = load(files.gl_pathv[i], &errors, &warnings);
        wrong += !compare(files.gl_pathv[i], &none, &errors) || !read;
        wrong += !compare(files.gl_pathv[i], &wanted, &warnings);
    }
    globfree(&files);
    ck_assert_int_eq(wrong, 0);
}
END_TEST

/* Inside a job every pointer begins with the place of the scene. */
START_TEST(test_corpus__pointers_start_at_the_place_given)
{
    static const char text[] = "{\"format\": \"penumbra-scene/1\", \"camera\": {}, \"x\": 1}";
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    struct pen_errors errors = {0};
    struct pen_status st;
    json_t *document = pen_json_parse(text, sizeof text - 1, &limits, &st);
    ck_assert_ptr_nonnull(document);
    ck_assert(!pen_scene_read(document, "/scene", &limits, arena, &desc, &errors));
    ck_assert_uint_eq(errors.count, 3);
    ck_assert_str_eq(errors.item[0].at, "/scene/x");
    ck_assert_str_eq(errors.item[1].at, "/scene/camera");
    json_decref(document);
    pen_arena_free(arena);
}
END_TEST

PEN_SUITE("io/corpus", test_corpus__bad_scenes_are_refused_where_and_as_expected,
          test_corpus__bad_xml_is_refused_where_and_as_expected,
          test_corpus__good_scenes_are_read_with_the_warnings_expected,
          test_corpus__good_scenes_can_be_frozen, test_corpus__pointers_start_at_the_place_given)
