/* SPDX-License-Identifier: MIT */
/* A test program: `PEN_SUITE("name", test_a, test_b)` at the end of a test file makes its main.
 * Each test runs in a process of its own (libcheck), so a crash fails one test only.
 *
 * Tests that judge how long something takes stand behind PEN_TIMED in the list, or use
 * ck_assert_timed: they would fail on a slow machine, so only `make check-all PARTS=timed`, which
 * sets the environment variable PEN_TIMED, judges times. A test that lacks a privilege or a feature
 * of the machine calls suite_skip and returns. */
#ifndef TESTS_SUPPORT_SUITE_H
#define TESTS_SUPPORT_SUITE_H

#include <check.h>
#include <stdbool.h>

/* Runs the tests of one suite and prints libcheck's closing line. Returns the exit code. */
int suite_run(const char *name, const TTest *const *tests, int count);

/* Whether times are judged. */
bool suite_timed(void);

/* Says that the running test is skipped, and why: `need` is a word that tests/needs.sh knows. */
void suite_skip(const char *need, const char *why);

/* In a list of tests: those behind it judge times. */
#define PEN_TIMED NULL

#define ck_assert_timed(condition) ck_assert(!suite_timed() || (condition))

/* Seconds after which a test gives up, because what it waits for seems never to come. No time that
 * a test judges is so long. */
enum { SUITE_HANG_S = 300 };

#define PEN_SUITE(name, ...)                                                                       \
    int main(void)                                                                                 \
    {                                                                                              \
        const TTest *const tests[] = {__VA_ARGS__};                                                \
        return suite_run(name, tests, (int)(sizeof tests / sizeof tests[0]));                      \
    }

#endif
