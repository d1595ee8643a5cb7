/* SPDX-License-Identifier: MIT */
/* Properties of the reader for any text. It does not crash. Every error has a place in the
 * document. Exactly the texts that jansson's own parser accepts are JSON. A failure prints the
 * seed: PEN_SEED=… repeats it. */
#include <glob.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "scene/scene.h"
#include "support/corrupt.h"
#include "support/mutate.h"
#include "support/suite.h"

static const char *const tokens[] = {"{",
                                     "}",
                                     "[",
                                     "]",
                                     ",",
                                     ":",
                                     "\"",
                                     "\\",
                                     "\\u0000",
                                     "\\ud83d",
                                     "null",
                                     "true",
                                     "NaN",
                                     "-",
                                     "1e",
                                     "1e999",
                                     "0",
                                     ".",
                                     "\n",
                                     "\t",
                                     "\xC3",
                                     "\xE2\x82\xAC",
                                     "\xFF",
                                     "//",
                                     "'",
                                     "\"a\":1,",
                                     "\xEF\xBB\xBF",
                                     "[[",
                                     "1e-999",
                                     "\r"};

static const struct corrupt_kind kind = {tokens, sizeof tokens / sizeof tokens[0]};

/* Whether the document has a value at a JSON Pointer. A pointer that was cut counts as one that
 * does. */
static bool exists_at(const json_t *value, const char *pointer)
{
    if (strstr(pointer, "…"))
        return true;
    while (value && *pointer == '/') {
        char step[PEN_AT_BYTES];
        size_t n = 0;
        for (pointer++; *pointer && *pointer != '/'; pointer++) {
            bool escape = pointer[0] == '~' && (pointer[1] == '0' || pointer[1] == '1');
            step[n++] = escape ? (pointer[1] == '0' ? '~' : '/') : *pointer;
            pointer += escape;
        }
        step[n] = '\0';
        value = json_is_array(value) ? json_array_get(value, strtoul(step, NULL, 10))
                                     : json_object_get(value, step);
    }
    return value && !*pointer;
}

/* Every scene that was read can be frozen, unless its sizes are too different for one local
 * frame. */
static void check_freeze(const json_t *document, const struct pen_scene_desc *desc,
                         const struct random *random)
{
    struct pen_status st = {0};
    struct pen_scene *scene = pen_scene_freeze(desc, PEN_ACCEL_NONE, 0, &st);
    if (!scene)
        ck_assert_msg(st.code == PEN_INVALID && exists_at(document, st.at), "PEN_SEED=%llu: %s: %s",
                      (unsigned long long)random->seed, st.at, st.msg);
    pen_scene_free(scene);
}

static void check_read(const json_t *document, const struct random *random)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    struct pen_errors errors = {0}, warnings = {0};
    bool ok = pen_scene_read(document, "", &limits, arena, &desc, &errors);
    ck_assert(ok == (errors.total == 0));
    if (ok) {
        pen_scene_warnings(document, "", &desc, &warnings);
        check_freeze(document, &desc, random);
    }
    for (size_t i = 0; i < errors.count + warnings.count; i++) {
        const struct pen_status *st =
            i < errors.count ? &errors.item[i] : &warnings.item[i - errors.count];
        ck_assert_msg(exists_at(document, st->at), "PEN_SEED=%llu: %s: %s",
                      (unsigned long long)random->seed, st->at, st->msg);
        ck_assert(st->msg[0] != '\0');
    }
    pen_arena_free(arena);
}

/* Whether two values are equal, where an integer in one may be a real in the other. */
static bool equal(const json_t *a, const json_t *b)
{
    if (json_is_number(a) && json_is_number(b))
        return json_number_value(a) == json_number_value(b);
    if (json_typeof(a) != json_typeof(b))
        return false;
    if (json_is_array(a)) {
        bool same = json_array_size(a) == json_array_size(b);
        for (size_t i = 0; same && i < json_array_size(a); i++)
            same = equal(json_array_get(a, i), json_array_get(b, i));
        return same;
    }
    if (!json_is_object(a))
        return json_equal(a, b);
    bool same = json_object_size(a) == json_object_size(b);
    const char *key;
    json_t *value;
    json_object_foreach((json_t *)a, key, value)
    {
        json_t *other = json_object_get(b, key);
        same = same && other && equal(value, other);
    }
    return same;
}

/* Parses a copy of exact size with both parsers, which must agree. Returns the document, or
 * NULL. */
static json_t *check_parse(const struct corrupt_text *text, const struct random *random)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_status st = {.line = -1};
    char *exact = malloc(text->bytes ? text->bytes : 1);
    memcpy(exact, text->data, text->bytes);
    json_t *ours = pen_json_parse(exact, text->bytes, &limits, &st);
    /* jansson does not read a byte-order mark */
    const size_t mark = text->bytes >= 3 && memcmp(exact, "\xEF\xBB\xBF", 3) == 0 ? 3 : 0;
    json_t *theirs =
        json_loadb(exact + mark, text->bytes - mark,
                   JSON_REJECT_DUPLICATES | JSON_DECODE_ANY | JSON_DECODE_INT_AS_REAL, NULL);
    bool deep = !ours && st.code == PEN_INVALID;
    bool zero = memchr(exact, '\0', text->bytes) != NULL; /* jansson accepts some after numbers */
    bool same = ours ? theirs && equal(ours, theirs) : deep || zero || !theirs;
    ck_assert_msg(same, "PEN_SEED=%llu: %s: %.*s", (unsigned long long)random->seed,
                  ours ? "accepted" : st.msg, (int)text->bytes, text->data);
    if (!ours && !deep)
        ck_assert(st.code == PEN_SYNTAX && st.line >= 1 && st.column >= 1 && st.msg[0]);
    json_decref(theirs);
    free(exact);
    return ours;
}

static const char *some_file(struct random *random, const glob_t *files)
{
    return files->gl_pathv[random_below(random, (uint32_t)files->gl_pathc)];
}

START_TEST(test_property__jansson_accepts_the_same_corrupted_text)
{
    static struct corrupt_text text;
    struct random random = random_begin(1);
    glob_t files;
    ck_assert_int_eq(glob("tests/io/corpus/*/*.json", 0, NULL, &files), 0);
    for (int i = 0; i < 40000; i++) {
        corrupt_read(some_file(&random, &files), &text);
        for (uint32_t changes = random_below(&random, 4); changes > 0; changes--)
            corrupt(&random, &text, &kind);
        json_t *document = check_parse(&text, &random);
        if (document)
            check_read(document, &random);
        json_decref(document);
    }
    globfree(&files);
}
END_TEST

START_TEST(test_property__errors_point_into_the_document)
{
    static struct corrupt_text text;
    struct random random = random_begin(2);
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    glob_t files;
    ck_assert_int_eq(glob("tests/io/corpus/good/*.json", 0, NULL, &files), 0);
    for (int i = 0; i < 20000; i++) {
        corrupt_read(some_file(&random, &files), &text);
        json_t *document = pen_json_parse(text.data, text.bytes, &limits, &st);
        for (uint32_t changes = 1 + random_below(&random, 4); changes > 0; changes--)
            mutate_document(&random, document);
        check_read(document, &random);
        json_decref(document);
    }
    globfree(&files);
}
END_TEST

PEN_SUITE("io/property", test_property__jansson_accepts_the_same_corrupted_text,
          test_property__errors_point_into_the_document)
