/* SPDX-License-Identifier: MIT */
/* A benchmark in the worker. It keeps what it has measured in the store, so that a worker that ends
 * loses a run and not the benchmark; and gives the batch back, to go on later, when a job of higher
 * priority waits. */
#include <stdlib.h>
#include <string.h>

#include "base/clock.h"
#include "jobs/bench_spec.h"
#include "jobs/internal/study.h"
#include "study/report.h"

enum { KEEP_MS = 250 }; /* the shortest time between two writes of what is measured */

struct benchmark {
    struct pen_study study; /* the first member: the progress function takes it for the study */
    int64_t kept_ns;        /* when it was last written */
    json_t *kept;           /* what an earlier worker has written; NULL: nothing */
    struct pen_bench_spec spec;
    struct pen_bench bench;
    struct pen_bench_result result;
};

/* Writes what is measured. A failure is ignored: the next write may succeed, and the heartbeat
 * notices a lost lease. Returns false if a job of higher priority waits. */
static bool keep(void *user, const struct pen_bench_state *state)
{
    struct benchmark *benchmark = user;
    struct pen_store *store = benchmark->study.context->store;
    struct pen_status ignored;
    bool outranked = false;
    const int64_t now_ns = pen_clock_ns();
    if (now_ns - benchmark->kept_ns < (int64_t)KEEP_MS * 1000000)
        return true;
    benchmark->kept_ns = now_ns;
    json_t *json = pen_bench_state_json(state);
    char *text = json ? json_dumps(json, JSON_COMPACT | JSON_REAL_PRECISION(17)) : NULL;
    if (text) {
        const struct pen_kept kept = {pen_bench_state_done(state), text, strlen(text)};
        pen_store_keep(store, benchmark->study.claim, &kept, &outranked, &ignored);
    }
    free(text);
    json_decref(json);
    return !outranked;
}

/* Reads what an earlier worker has written. What is damaged counts as nothing: the benchmark begins
 * again. */
static void read_kept(struct benchmark *benchmark)
{
    struct pen_buf text = {0};
    struct pen_status ignored;
    if (pen_store_kept(benchmark->study.context->store, benchmark->study.claim, &text, &ignored))
        benchmark->kept = json_loadb((const char *)text.data, text.bytes, 0, NULL);
    pen_buf_release(&text);
    benchmark->bench.kept = benchmark->kept;
}

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
    benchmark->bench.desc = &benchmark->study.desc;
    benchmark->bench.views = benchmark->study.views;
    benchmark->bench.view_count = request->view_count;
    benchmark->bench.scene_cap_bytes = pen_scene_cache_cap(context->scenes);
    benchmark->bench.pool = context->pool;
    benchmark->bench.cancel = pen_heartbeat_cancel_flag(context->heart);
    benchmark->bench.progress = pen_study_progress;
    benchmark->bench.between = keep;
    benchmark->bench.user = benchmark;
    read_kept(benchmark);
    return true;
}

static bool run(struct benchmark *benchmark, struct pen_status *st)
{
    struct pen_batch_context *context = benchmark->study.context;
    benchmark->bench.pixel_begins = pen_batch_pixel_hook(context);
    benchmark->bench.pixel_user = context;
    return pen_batch_hook_done(context, pen_bench_run(&benchmark->bench, &benchmark->result, st),
                               st);
}

static bool write_report(struct benchmark *benchmark, struct pen_batch_output *output,
                         struct pen_status *st)
{
    json_t *report =
        pen_bench_report_new(&benchmark->bench, &benchmark->result,
                             pen_bench_spec_head(&benchmark->spec, &benchmark->bench,
                                                 &benchmark->study.context->request.settings));
    bool ok = report ? pen_bench_report_write(report, "json", &output->artefact, st)
                     : pen_fail(st, PEN_NO_MEMORY, "no memory for a report");
    json_decref(report);
    pen_study_set_report(output);
    return ok;
}

/* The job's statistics are those of the baseline row's last counted run. */
static bool write_stats(struct benchmark *benchmark, struct pen_batch_output *output,
                        struct pen_status *st)
{
    const struct pen_bench_row_result *row = &benchmark->result.rows[benchmark->spec.baseline];
    return pen_study_write_stats(&benchmark->study, &row->stats, &row->accel,
                                 row->runs[benchmark->result.repeats - 1].build_ms, output, st);
}

bool pen_batch_benchmark(struct pen_batch_context *context, const struct pen_claim *claim,
                         struct pen_batch_output *output, struct pen_status *st)
{
    struct benchmark benchmark = {.spec = {.matrix = NULL}};
    bool ok = pen_study_begin(&benchmark.study, context, claim, st) && read_spec(&benchmark, st) &&
              run(&benchmark, st) && write_report(&benchmark, output, st) &&
              write_stats(&benchmark, output, st);
    pen_bench_result_release(&benchmark.bench, &benchmark.result);
    pen_bench_spec_release(&benchmark.spec);
    json_decref(benchmark.kept);
    pen_study_end(&benchmark.study);
    return ok;
}
