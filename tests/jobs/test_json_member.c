/* SPDX-License-Identifier: MIT */
/* Finding the text of a member in the text of an object. Generated objects are compared with
 * jansson, which parses the text found and the whole object. A failure prints the seed: PEN_SEED=…
 * repeats it. */
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <unistd.h>

#include "base/buf.h"
#include "jobs/internal/members.h"
#include "support/random.h"
#include "support/suite.h"

static void expect_member(const char *text, const char *wanted)
{
    size_t length = 0;
    const char *found = pen_json_member(text, strlen(text), "scene", &length);
    ck_assert_msg(wanted ? found && length == strlen(wanted) && memcmp(found, wanted, length) == 0
                         : !found,
                  "%s: found %.*s", text, found ? (int)length : 7, found ? found : "nothing");
}

START_TEST(test_json_member__a_value_of_any_type_is_found)
{
    expect_member("{\"scene\":{\"format\":1}}", "{\"format\":1}");
    expect_member("{\"scene\":[1,[2],{}],\"b\":2}", "[1,[2],{}]");
    expect_member("{\"a\":1,\"scene\":-1.5e3}", "-1.5e3");
    expect_member("{\"a\":{\"b\":[1]},\"scene\":null,\"c\":3}", "null");
    expect_member("{\"scene\":\"builtin:room\"}", "\"builtin:room\"");
    expect_member("{\"scene\":\"\"}", "\"\"");
    expect_member("{\"a\":\"\",\"scene\":true}", "true");
}
END_TEST

START_TEST(test_json_member__the_key_inside_strings_and_nested_values_is_not_the_member)
{
    expect_member("{}", NULL);
    expect_member("{\"a\":\"scene\"}", NULL);
    expect_member("{\"a\":{\"scene\":1}}", NULL);
    expect_member("{\"a\":[{\"scene\":1}]}", NULL);
    expect_member("{\"a\":\"\\\",\\\"scene\\\":1,\"}", NULL);
    expect_member("{\"a\":\"{\\\"scene\\\":1}\",\"scene\":2}", "2");
    expect_member("{\"a\":{\"scene\":1},\"scene\":2,\"b\":{\"scene\":3}}", "2");
    expect_member("{\"a\":\"ends with a backslash \\\\\",\"scene\":2}", "2");
}
END_TEST

START_TEST(test_json_member__only_the_whole_key_matches)
{
    expect_member("{\"Scene\":1}", NULL);
    expect_member("{\"scenes\":1}", NULL);
    expect_member("{\"scen\":1}", NULL);
    expect_member("{\" scene\":1}", NULL);
    expect_member("{\"\":1}", NULL);
    expect_member("{\"a\\\"scene\":1}", NULL);
    expect_member("{\"scene\\\"\":1}", NULL);
    expect_member("{\"scen\\\\\":1}", NULL);
    expect_member("{\"scenes\":1,\"scen\":2,\"scene\":3}", "3");
}
END_TEST

/* The caller then writes the value anew. */
START_TEST(test_json_member__a_key_with_escapes_is_not_found)
{
    expect_member("{\"sc\\u0065ne\":1}", NULL);
    expect_member("{\"\\u0073cene\":{\"a\":1}}", NULL);
}
END_TEST

START_TEST(test_json_member__white_space_around_a_value_is_not_part_of_it)
{
    expect_member(" \t\r\n{ \n\"scene\"\t:\r 1 \n} ", "1");
    expect_member("{\"scene\" : { \"a\" : 1 } , \"b\" : 2}", "{ \"a\" : 1 }");
    expect_member("{\"scene\":\n[ ]\n}", "[ ]");
    expect_member("{\"a\" : 1 ,\n\"scene\" : \" x \"\n}", "\" x \"");
}
END_TEST

/* The parser of documents refuses duplicate keys before. */
START_TEST(test_json_member__the_first_of_duplicate_keys_is_found)
{
    expect_member("{\"scene\":1,\"scene\":2}", "1");
}
END_TEST

START_TEST(test_json_member__text_that_is_no_object_has_no_members)
{
    expect_member("", NULL);
    expect_member("  ", NULL);
    expect_member("\"scene\"", NULL);
    expect_member("[\"scene\",1]", NULL);
    expect_member("[{\"scene\":1}]", NULL);
    expect_member("1", NULL);
}
END_TEST

START_TEST(test_json_member__deep_nesting_takes_no_stack)
{
    enum { DEPTH = 4 << 20 };
    struct pen_buf text = {0};
    pen_buf_puts(&text, "{\"a\":");
    for (int i = 0; i < DEPTH; i++)
        pen_buf_puts(&text, i % 2 ? "{\"scene\":" : "[");
    pen_buf_puts(&text, "0");
    for (int i = DEPTH - 1; i >= 0; i--)
        pen_buf_puts(&text, i % 2 ? "}" : "]");
    pen_buf_puts(&text, ",\"scene\":7}");
    ck_assert(!text.failed);
    expect_member((const char *)text.data, "7");
    pen_buf_release(&text);
}
END_TEST

/* Keys as they are written. The first two are the same key; all others differ. */
static const char *const keys[] = {"scene",      "sc\\u0065ne", "",
                                   "scen",       "scenes",      "Scene",
                                   "a\\\"scene", "scene\\\\",   "{\\\"scene\\\":1}",
                                   "name",       "\\u00e9\\/",  "\xC3\xA9t\xC3\xA9"};
enum { PLAIN, ESCAPED, KEYS = sizeof keys / sizeof keys[0] };

static const char *const scalars[] = {"0",
                                      "-12.5E+3",
                                      "true",
                                      "false",
                                      "null",
                                      "\"\"",
                                      "\"scene\"",
                                      "\"\\\"scene\\\": {\"",
                                      "\"}, ]\"",
                                      "\"\\\\\"",
                                      "\"\\u0022,\\u005c\"",
                                      "[]",
                                      "{}"};

struct generator {
    struct random random;
    struct pen_buf text;
    bool plain; /* the outermost object has the key "scene" without escapes */
};

static void add_space(struct generator *g)
{
    static const char *const spaces[] = {"", "", "", " ", "\t", "\r\n", "\n  "};
    pen_buf_puts(&g->text, spaces[random_below(&g->random, sizeof spaces / sizeof spaces[0])]);
}

static void add_value(struct generator *g, int depth);

/* An object with a random choice of keys, none twice. */
static void add_object(struct generator *g, int depth)
{
    uint32_t chosen = (uint32_t)random_bits(&g->random) & (uint32_t)random_bits(&g->random);
    uint32_t start = random_below(&g->random, KEYS);
    bool first = true;
    if (chosen & 1u << PLAIN)
        chosen &= ~(1u << ESCAPED);
    if (depth == 0)
        g->plain = chosen & 1u << PLAIN;
    pen_buf_puts(&g->text, "{");
    for (uint32_t i = 0; i < KEYS; i++) {
        uint32_t key = (start + i) % KEYS;
        if (!(chosen & 1u << key))
            continue;
        pen_buf_puts(&g->text, first ? "" : ",");
        add_space(g);
        pen_buf_puts(&g->text, "\"");
        pen_buf_puts(&g->text, keys[key]);
        pen_buf_puts(&g->text, "\"");
        add_space(g);
        pen_buf_puts(&g->text, ":");
        add_space(g);
        add_value(g, depth + 1);
        add_space(g);
        first = false;
    }
    add_space(g);
    pen_buf_puts(&g->text, "}");
}

static void add_array(struct generator *g, int depth)
{
    uint32_t count = random_below(&g->random, 4);
    pen_buf_puts(&g->text, "[");
    for (uint32_t i = 0; i < count; i++) {
        pen_buf_puts(&g->text, i ? "," : "");
        add_space(g);
        add_value(g, depth + 1);
        add_space(g);
    }
    pen_buf_puts(&g->text, "]");
}

static void add_value(struct generator *g, int depth)
{
    uint32_t kind = depth > 4 ? 0 : random_below(&g->random, 4);
    if (kind == 2)
        add_object(g, depth);
    else if (kind == 3)
        add_array(g, depth);
    else
        pen_buf_puts(&g->text,
                     scalars[random_below(&g->random, sizeof scalars / sizeof scalars[0])]);
}

static void generate(struct generator *g)
{
    g->text.bytes = 0;
    add_space(g);
    add_object(g, 0);
    add_space(g);
    ck_assert(!g->text.failed);
}

/* The text found must be exactly the value that jansson has for the key. */
static void compare_with_jansson(const struct generator *g)
{
    const char *text = (const char *)g->text.data;
    unsigned long long seed = (unsigned long long)g->random.seed;
    size_t length = 0;
    const char *found = pen_json_member(text, g->text.bytes, "scene", &length);
    json_t *object = json_loadb(text, g->text.bytes, JSON_REJECT_DUPLICATES, NULL);
    ck_assert_msg(json_is_object(object), "PEN_SEED=%llu: not JSON: %s", seed, text);
    ck_assert_msg(g->plain == (found != NULL), "PEN_SEED=%llu: %s in %s", seed,
                  found ? "found" : "not found", text);
    if (found) {
        json_t *value = json_loadb(found, length, JSON_DECODE_ANY, NULL);
        ck_assert_msg(value && json_equal(value, json_object_get(object, "scene")),
                      "PEN_SEED=%llu: %.*s in %s", seed, (int)length, found, text);
        ck_assert_msg(!strchr(" \t\r\n", found[0]) && !strchr(" \t\r\n", found[length - 1]),
                      "PEN_SEED=%llu: white space in %.*s", seed, (int)length, found);
        json_decref(value);
    }
    json_decref(object);
}

START_TEST(test_json_member__generated_objects_give_the_value_that_jansson_has)
{
    struct generator g = {.random = random_begin(1)};
    int found = 0, cases = random_cases(20000);
    for (int i = 0; i < cases; i++) {
        generate(&g);
        compare_with_jansson(&g);
        found += g.plain;
    }
    ck_assert_int_gt(found, cases / 8);
    ck_assert_int_lt(found, cases / 2);
    pen_buf_release(&g.text);
}
END_TEST

/* Pages whose end is followed by one that cannot be read, so that reading past a text put at their
 * end ends the test. */
static char *guarded_end(size_t page)
{
    char *pages = mmap(NULL, 2 * page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    ck_assert_ptr_ne(pages, MAP_FAILED);
    ck_assert_int_eq(mprotect(pages + page, page, PROT_NONE), 0);
    return pages + page;
}

static void expect_inside(const char *text, size_t bytes, char *end)
{
    size_t length = 0;
    char *copy = memcpy(end - bytes, text, bytes);
    const char *found = pen_json_member(copy, bytes, "scene", &length);
    if (found)
        ck_assert(found >= copy && length <= (size_t)(end - found));
}

/* The function requires well-formed text, but must not read beyond the end of any other. */
START_TEST(test_json_member__truncated_text_is_never_read_beyond_its_end)
{
    static const char *const texts[] = {"{\"scene\":\"\\", "{\"sce\\n\":1}",
                                        "{\"a\":{\"b\":\"\\\"\\\\\"},",
                                        "{\"scene\" : [1, {\"a\" : \"\\u00"};
    struct generator g = {.random = random_begin(2)};
    size_t page = (size_t)sysconf(_SC_PAGESIZE);
    char *end = guarded_end(page);
    for (size_t i = 0; i < sizeof texts / sizeof texts[0]; i++) {
        for (size_t bytes = 0; bytes <= strlen(texts[i]); bytes++)
            expect_inside(texts[i], bytes, end);
    }
    for (int i = random_cases(200); i > 0; i--) {
        generate(&g);
        for (size_t bytes = 0; bytes <= g.text.bytes && bytes <= page; bytes++)
            expect_inside((const char *)g.text.data, bytes, end);
    }
    munmap(end - page, 2 * page);
    pen_buf_release(&g.text);
}
END_TEST

PEN_SUITE("jobs/json_member", test_json_member__a_value_of_any_type_is_found,
          test_json_member__the_key_inside_strings_and_nested_values_is_not_the_member,
          test_json_member__only_the_whole_key_matches,
          test_json_member__a_key_with_escapes_is_not_found,
          test_json_member__white_space_around_a_value_is_not_part_of_it,
          test_json_member__the_first_of_duplicate_keys_is_found,
          test_json_member__text_that_is_no_object_has_no_members,
          test_json_member__deep_nesting_takes_no_stack,
          test_json_member__generated_objects_give_the_value_that_jansson_has,
          test_json_member__truncated_text_is_never_read_beyond_its_end)
