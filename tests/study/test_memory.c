/* SPDX-License-Identifier: MIT */
/* A benchmark fails with PEN_NO_MEMORY wherever an allocation fails. Under sanitizers, the test
 * also shows that nothing leaks. */
#include <stdio.h>
#include <string.h>

#include "report/report.h"
#include "study/bench.h"
#include "support/alloc.h"
#include "support/kit.h"
#include "support/random.h"
#include "support/suite.h"

static struct kit kit;

/* Runs a benchmark and writes its report in every format. */
static bool work(const struct pen_bench *bench, struct pen_status *st)
{
    struct pen_bench_result result;
    struct pen_buf text = {0};
    bool ok = pen_bench_run(bench, &result, st);
    json_t *report = ok ? pen_bench_report_new(bench, &result, json_object()) : NULL;
    if (ok && !report)
        ok = pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    for (int i = 0; ok && pen_report_formats[i]; i++) {
        ok = pen_report_write(report, pen_report_formats[i], NULL, &text, st);
        pen_buf_release(&text);
    }
    json_decref(report);
    pen_bench_result_release(bench, &result);
    return ok;
}

START_TEST(test_memory__every_failed_allocation_is_reported)
{
    static const int views[] = {0};
    struct pen_bench_row rows[2];
    struct pen_status st = {0};
    kit_medley(&kit);
    kit.settings.width = kit.settings.height = 8;
    for (int i = 0; i < 2; i++) {
        rows[i].settings = kit.settings;
        rows[i].settings.max_depth = i + 1;
        rows[i].varied = json_pack("{s:i, s:s}", "max_depth", i + 1, "transfer", "srgb");
    }
    struct pen_bench bench = {.frame = {.desc = &kit.desc, .pool = pen_thread_pool_new(1, &st)},
                              .views = views,
                              .view_count = 1,
                              .rows = rows,
                              .row_count = 2,
                              .repeats = 2};
    ck_assert(work(&bench, &st)); /* waits until the pool's thread has started, which allocates */
    for (long n = 0;; n += random_all() || n < 300 ? 1 : 5) {
        ck_assert_int_lt(n, 100000);
        alloc_fail_after(n);
        bool ok = work(&bench, &st);
        bool refused = alloc_succeed();
        ck_assert_msg(ok || refused, "after %ld: %s", n, st.msg);
        ck_assert_msg(ok || st.code == PEN_NO_MEMORY, "after %ld: %s", n, st.msg);
        if (!refused)
            break;
    }
    pen_thread_pool_free(bench.frame.pool);
    for (int i = 0; i < 2; i++)
        json_decref((json_t *)(uintptr_t)rows[i].varied);
}
END_TEST

PEN_SUITE("memory", test_memory__every_failed_allocation_is_reported)
