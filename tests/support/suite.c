/* SPDX-License-Identifier: MIT */
#include "support/suite.h"

#include <stdio.h>
#include <stdlib.h>

bool suite_timed(void)
{
    return getenv("PEN_TIMED") != NULL;
}

void suite_skip(const char *need, const char *why)
{
    printf("skipped: %s: %s\n", need, why);
}

int suite_run(const char *name, const TTest *const *tests, int count)
{
    Suite *suite = suite_create(name);
    TCase *tcase = tcase_create(name);
    tcase_set_timeout(tcase, 4 * SUITE_HANG_S);
    for (int i = 0; i < count && (tests[i] || suite_timed()); i++)
        if (tests[i])
            tcase_add_test(tcase, tests[i]);
    suite_add_tcase(suite, tcase);
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0;
}
