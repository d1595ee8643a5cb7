/* SPDX-License-Identifier: MIT */
/* A test program: `PEN_SUITE("name", test_a, test_b)` at the end of a test file makes its main.
 * Each test runs in its own process (libcheck), so a crash fails only one test.
 *
 * Tests that judge how long something takes come after PEN_TIMED in the list, or use
 * ck_assert_timed. They would fail on a slow machine. So only `make check-all PARTS=timed`, which
 * sets PEN_TIMED in the environment, judges times. A test that lacks a privilege or a feature of
 * the machine calls suite_skip and returns. */
#ifndef TESTS_SUPPORT_SUITE_H
#define TESTS_SUPPORT_SUITE_H

#include <check.h>
#include <stdbool.h>

/* Runs the tests of one suite and prints libcheck's closing line. Returns the exit code. */
int suite_run(const char *name, const TTest *const *tests, int count);

/* Returns true if times are judged. */
bool suite_timed(void);

/* Says that the running test is skipped, and why. `need` is a word from tests/needs.sh. */
void suite_skip(const char *need, const char *why);

/* In a list of tests: all tests after it judge times. */
#define PEN_TIMED NULL

#define ck_assert_timed(condition) ck_assert(!suite_timed() || (condition))

/* Seconds after which a test gives up, because it waits for something that seems never to come. No
 * test judges a time as long as this. */
enum { SUITE_HANG_S = 300 };

#define PEN_SUITE(name, ...)                                                                       \
    int main(void)                                                                                 \
    {                                                                                              \
        const TTest *const tests[] = {__VA_ARGS__};                                                \
        return suite_run(name, tests, (int)(sizeof tests / sizeof tests[0]));                      \
    }

#endif
