/* SPDX-License-Identifier: MIT */
/* A benchmark in the worker. It keeps its measurements in the store, so a worker that ends loses a
 * run, not the benchmark. When a job of higher priority waits, it gives the batch back, and
 * continues later. */
#include "jobs/bench_spec.h"
#include "jobs/internal/study.h"

struct benchmark {
    struct pen_study study; /* the first member: progress and keep take the address for the study */
    struct pen_bench_spec spec;
    struct pen_bench bench;
    struct pen_bench_result result;
};

static bool read_spec(struct benchmark *benchmark, struct pen_status *st)
{
    struct pen_batch_context *context = benchmark->study.context;
    const struct pen_stored_request *request = &context->request;
    struct pen_errors errors = {0};
    if (!pen_bench_spec_read(request->json, &request->settings, &benchmark->spec, &errors)) {
        *st = errors.item[0];
        return false;
    }
    benchmark->bench = pen_bench_of_spec(&benchmark->spec);
    benchmark->bench.frame = pen_study_frame_of(&benchmark->study, benchmark);
    benchmark->bench.views = benchmark->study.views;
    benchmark->bench.view_count = request->view_count;
    return true;
}

static bool write_report(struct benchmark *benchmark, struct pen_batch_output *output,
                         struct pen_status *st)
{
    json_t *report =
        pen_bench_report_new(&benchmark->bench, &benchmark->result,
                             pen_bench_spec_head(&benchmark->spec, &benchmark->bench,
                                                 &benchmark->study.context->request.settings));
    bool ok = report ? pen_study_store_report(&benchmark->study, report, NULL, output, st)
                     : pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    json_decref(report);
    return ok;
}

/* The job's statistics are those of the last counted run of the baseline row. */
static bool write_stats(struct benchmark *benchmark, struct pen_batch_output *output,
                        struct pen_status *st)
{
    const struct pen_bench_row_result *row = &benchmark->result.rows[benchmark->spec.baseline];
    return pen_study_write_stats(&benchmark->study, &row->stats, &row->accel,
                                 row->runs[benchmark->result.repeats - 1].build_ms, output, st);
}

bool pen_batch_benchmark(struct pen_batch_context *context, struct pen_batch_output *output,
                         struct pen_status *st)
{
    struct benchmark benchmark = {.spec = {.matrix = NULL}};
    bool ok =
        pen_study_begin(&benchmark.study, context, st) && read_spec(&benchmark, st) &&
        pen_batch_hook_done(context, pen_bench_run(&benchmark.bench, &benchmark.result, st), st) &&
        write_report(&benchmark, output, st) && write_stats(&benchmark, output, st);
    pen_bench_result_release(&benchmark.bench, &benchmark.result);
    pen_bench_spec_release(&benchmark.spec);
    pen_study_end(&benchmark.study);
    return ok;
}
