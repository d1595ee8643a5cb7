/* SPDX-License-Identifier: MIT */
/* The catalogue of hard cases is true. Every case is tested or has a reason why not. The tests that
 * it names exist. No test is of a case that has none by the catalogue. This test reads the sources
 * of the tests. */
#include <ctype.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "property/catalogue.h"
#include "support/suite.h"

/* The sources of all tests, one after the other. */
static char *sources;
static size_t bytes;

static void add_source(const char *path)
{
    FILE *f = fopen(path, "rb");
    ck_assert_msg(f != NULL, "%s", path);
    for (;;) {
        sources = realloc(sources, bytes + 65537);
        ck_assert(sources != NULL);
        size_t got = fread(sources + bytes, 1, 65536, f);
        bytes += got;
        sources[bytes] = '\0';
        if (got == 0)
            break;
    }
    fclose(f);
}

static void read_sources(void)
{
    glob_t found;
    ck_assert_int_eq(glob("tests/*/test_*.c", 0, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++)
        add_source(found.gl_pathv[i]);
    globfree(&found);
}

/* Whether libcheck has such a test: it begins, and a suite lists it. */
static bool is_test(const char *name)
{
    size_t length = strlen(name);
    int begun = 0, named = 0;
    for (const char *at = sources; (at = strstr(at, name)); at += length) {
        bool whole = !isalnum((unsigned char)at[length]) && at[length] != '_';
        named += whole;
        begun += whole && at - sources > 11 && strncmp(at - 11, "START_TEST(", 11) == 0;
    }
    return begun > 0 && named > begun;
}

static bool is_there(const char *name)
{
    return strchr(name, '/') ? access(name, F_OK) == 0 : is_test(name);
}

/* How many tests a case names; whether all of them are there. */
static int count_names(int number, bool *there)
{
    char list[1024];
    int count = 0;
    snprintf(list, sizeof list, "%s", catalogue_case(number)->tests);
    for (char *name = strtok(list, " "); name; name = strtok(NULL, " "), count++) {
        if (!is_there(name)) {
            printf("H%03d: %s is not there\n", number, name);
            *there = false;
        }
    }
    return count;
}

static int count_rows(int number)
{
    const struct row *row;
    int count = 0;
    for (int i = 0; (row = row_at(i)); i++)
        count += row->status == ROW_TESTED && catalogue_has(row, number);
    return count;
}

START_TEST(test_catalogue__every_case_is_tested_or_says_why_not)
{
    bool good = true;
    read_sources();
    for (int i = CATALOGUE_FIRST; i <= CATALOGUE_LAST; i++) {
        const struct catalogue_case *c = catalogue_case(i);
        bool there = true;
        ck_assert_msg(c->what && *c->what, "H%03d is missing", i);
        bool tested = count_names(i, &there) + count_rows(i) > 0;
        if (c->status == ROW_TESTED ? !tested : !c->why) {
            printf("H%03d has no test and no reason\n", i);
            good = false;
        }
        if (c->status == ROW_INAPPLICABLE && tested) {
            printf("H%03d does not apply, but has a test\n", i);
            good = false;
        }
        good = good && there;
    }
    fflush(stdout);
    ck_assert(good);
}
END_TEST

/* The number in a name such as h042_roles; 0 for none. */
static int number_in(const char *at)
{
    bool number = at[0] == 'h' && isdigit((unsigned char)at[1]) && isdigit((unsigned char)at[2]) &&
                  isdigit((unsigned char)at[3]) && at[4] == '_';
    return number ? atoi(at + 1) : 0;
}

/* Tests name cases: such a case is in the catalogue as one that has tests. */
START_TEST(test_catalogue__tests_are_of_cases_that_have_tests)
{
    int tests = 0;
    read_sources();
    for (const char *at = sources; (at = strstr(at, "START_TEST(test_")); at++) {
        for (const char *c = at; *c && *c != ')'; c++) {
            int number = c[-1] == '_' ? number_in(c) : 0;
            if (!number)
                continue;
            tests++;
            ck_assert_msg(number <= CATALOGUE_LAST, "H%03d", number);
            const struct catalogue_case *hard = catalogue_case(number);
            ck_assert_msg(hard->status == ROW_TESTED || *hard->tests,
                          "H%03d %s, but there is a test of it", number, catalogue_status(hard));
        }
    }
    ck_assert_int_gt(tests, 100);
}
END_TEST

START_TEST(test_catalogue__rows_are_of_cases_that_there_are)
{
    const struct row *row;
    for (int i = 0; (row = row_at(i)); i++)
        for (const char *id = row->id; (id = strchr(id, 'H')); id++) {
            int number = atoi(id + 1);
            ck_assert_msg(number >= CATALOGUE_FIRST && number <= CATALOGUE_LAST, "%s: %s",
                          row->name, row->id);
        }
}
END_TEST

PEN_SUITE("catalogue", test_catalogue__every_case_is_tested_or_says_why_not,
          test_catalogue__tests_are_of_cases_that_have_tests,
          test_catalogue__rows_are_of_cases_that_there_are)
