/* SPDX-License-Identifier: MIT */
/* A test program: `PEN_SUITE("name", test_a, test_b)` at the end of a test file makes its main.
 * Each test runs in a process of its own (libcheck), so a crash fails one test only. */
#ifndef TESTS_SUPPORT_SUITE_H
#define TESTS_SUPPORT_SUITE_H

#include <check.h>

/* Runs the tests of one suite and prints libcheck's closing line. Returns the exit code. */
int suite_run(const char *name, const TTest *const *tests, int count);

#define PEN_SUITE(name, ...)                                                                       \
    int main(void)                                                                                 \
    {                                                                                              \
        const TTest *const tests[] = {__VA_ARGS__};                                                \
        return suite_run(name, tests, (int)(sizeof tests / sizeof tests[0]));                      \
    }

#endif
