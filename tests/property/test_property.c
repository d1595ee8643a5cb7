/* SPDX-License-Identifier: MIT */
/* The rows of the stability suite as tests, with fewer cases than `make stability`, after the cases
 * of the corpus. Each prints its seed if it fails; PEN_SEED repeats it. */
#include <check.h>
#include <stdio.h>

#include "property/corpus.h"
#include "property/row.h"

static struct corpus corpus;
static struct row_result result;

static uint64_t cases_of(const struct row *row)
{
    return (uint64_t)random_cases(row->check ? (int)row->check : 10000);
}

static void run_row(int i)
{
    const struct row *row = row_at(i);
    struct pen_row_run run = {row, random_begin(1).seed, 0, cases_of(row), &corpus, &result};
    char text[2048] = "";
    row_run(&run);
    ck_assert_msg(result.tried > 0, "%s: no case was judged", row->id);
    if (result.failures == 0 && row->known)
        printf("%s holds in %llu cases: is it still true that %s?\n", row->name,
               (unsigned long long)result.tried, row->known);
    if (result.failures == 0)
        return;
    row_print(text, sizeof text, &result.kept[0].small);
    if (row->known)
        printf("%s fails by a known defect (%s): %s: %s\n", row->name, row->known,
               result.kept[0].why, text);
    else
        ck_abort_msg("%s: %llu of %llu cases failed, the first: %s: %s %s; seed %llu", row->id,
                     (unsigned long long)result.failures, (unsigned long long)result.tried,
                     result.kept[0].why, row->name, text, (unsigned long long)run.seed);
}

int main(void)
{
    static char name[ROWS_MAX][80];
    static TTest test[ROWS_MAX];
    const struct row *row;
    Suite *suite = suite_create("property");
    int bad = corpus_read(&corpus, "tests/property/corpus/worst.txt");
    if (bad)
        printf("tests/property/corpus/worst.txt:%d: not a case\n", bad);
    for (int i = 0; i < ROWS_MAX && (row = row_at(i)); i++) {
        if (row->status != ROW_TESTED)
            continue;
        snprintf(name[i], sizeof name[i], "test_property__%s", row->name);
        test[i] = (TTest){name[i], run_row, __FILE__, __LINE__};
        TCase *tcase = tcase_create(row->name);
        tcase_set_timeout(tcase, 1200);
        tcase_add_loop_test(tcase, &test[i], i, i + 1);
        suite_add_tcase(suite, tcase);
    }
    SRunner *runner = srunner_create(suite);
    srunner_run_all(runner, CK_NORMAL);
    int failed = srunner_ntests_failed(runner);
    srunner_free(runner);
    return failed != 0 || bad != 0;
}
