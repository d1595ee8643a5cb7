/* SPDX-License-Identifier: MIT */
/* The cost of a job besides rendering, in a worker of this process. It is the time from the first
 * claim to the job's end in which no tile was rendered (scene, encoding, store), and the part of it
 * in which the worker waited for the store. The runs of several jobs are interleaved. Heartbeats
 * are also timed separately, because a short job has few. Most of them only read; once in a third
 * of the lease one extends it.
 *
 * usage: bench_traffic [runs] [folder]     makes the store in a new folder below `folder` (/tmp) */
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "base/clock.h"
#include "bench/median.h"
#include "jobs/jobs.h"
#include "jobs/worker.h"

static const struct {
    const char *title, *body;
} workloads[] = {
    {"room 1000x1400", "{\"scene\": \"builtin:room\"}"},
    {"room 1000x1400, 4 samples",
     "{\"scene\": \"builtin:room\", \"render\": {\"samples_per_pixel\": 4}}"},
    {"spheres 64x48", "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 64,"
                      " \"height\": 48}}"},
};
enum { JOBS = sizeof workloads / sizeof workloads[0], RUNS_MAX = 100, WARM_UP = 1 };

struct run {
    double render_ms, outside_ms, store_ms;
};

static void die(const char *step, const struct pen_status *st)
{
    fprintf(stderr, "bench_traffic: %s: %s\n", step, st->msg);
    exit(1);
}

static struct pen_worker_options options = {.id = "bench:1:1", .threads = 2};
static atomic_bool stop;

static void *work(void *user)
{
    struct pen_status st;
    (void)user;
    if (!pen_worker_run(&options, &stop, &st))
        die("worker", &st);
    return NULL;
}

static void wait_until_ended(struct pen_store *store, const char *id)
{
    uint32_t seen = 0;
    struct pen_job_record job;
    struct pen_status st;
    enum pen_job_state state = PEN_JOB_QUEUED;
    while (!pen_job_state_ended(state)) {
        if (!pen_store_job(store, id, &job, &st))
            die("job", &st);
        state = job.state;
        pen_job_record_release(&job);
        if (!pen_job_state_ended(state))
            pen_store_wait(store, &seen, 100);
    }
}

static double timing_of(const json_t *stats, const char *name)
{
    return json_number_value(json_object_get(json_object_get(stats, "timing"), name));
}

static struct run run_job(struct pen_jobs *jobs, const char *body)
{
    struct pen_submission in = {.body = body, .bytes = strlen(body)};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    struct pen_status st;
    if (!pen_jobs_submit(jobs, &in, &out, &errors)) {
        fprintf(stderr, "bench_traffic: refused: %s\n", errors.item[0].msg);
        exit(1);
    }
    pen_buf_release(&out.answer);
    wait_until_ended(pen_jobs_store(jobs), out.id);
    json_t *stats = pen_jobs_stats(jobs, out.id, &st);
    if (!stats)
        die("stats", &st);
    const double render_ms = timing_of(stats, "render_ms");
    const struct run run = {.render_ms = render_ms,
                            .outside_ms = timing_of(stats, "total_ms") -
                                          timing_of(stats, "queue_ms") - render_ms,
                            .store_ms = timing_of(stats, "store_ms")};
    json_decref(stats);
    return run;
}

static void print_range(const char *what, double *values, int count)
{
    const double median = bench_median(values, count); /* which sorts them */
    printf("  %-38s %8.2f ms (%.2f to %.2f)\n", what, median, values[0], values[count - 1]);
}

static void print_job(const char *title, const struct run *runs, int count)
{
    double render[RUNS_MAX], outside[RUNS_MAX], store[RUNS_MAX];
    for (int i = 0; i < count; i++) {
        render[i] = runs[i].render_ms;
        outside[i] = runs[i].outside_ms;
        store[i] = runs[i].store_ms;
    }
    printf("%s, %d runs\n", title, count);
    print_range("rendering", render, count);
    print_range("from the first claim on, besides it", outside, count);
    print_range("of that, waiting for the store", store, count);
}

/* Times the two kinds of heartbeat of a valid lease: those that read, and those that extend it. */
static void time_heartbeats(struct pen_jobs *jobs, const char *url)
{
    enum { BEATS = 1000, EXTENSIONS = 50, LEASE_MS = 60000 };
    struct pen_submission in = {.body = workloads[2].body, .bytes = strlen(workloads[2].body)};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    struct pen_claim claim;
    struct pen_status st;
    bool found = false, held = false;
    struct pen_store *store = pen_store_open(url, false, &st);
    if (!store || !pen_jobs_submit(jobs, &in, &out, &errors) ||
        !pen_store_claim(store, "bench:2:2", LEASE_MS, 1, &claim, &found, &st) || !found)
        die("claim", &st);
    pen_buf_release(&out.answer);
    int64_t begun = pen_clock_ns();
    for (int i = 0; i < BEATS; i++)
        pen_store_heartbeat(store, &claim, LEASE_MS, &held, &st);
    const double read_ms = (double)(pen_clock_ns() - begun) * 1e-6 / BEATS;
    begun = pen_clock_ns();
    for (int64_t i = 1; i <= EXTENSIONS; i++) /* asks for one so long that it is extended */
        pen_store_heartbeat(store, &claim, (int64_t)LEASE_MS * 2 * (i + 1), &held, &st);
    const double write_ms = (double)(pen_clock_ns() - begun) * 1e-6 / EXTENSIONS;
    printf("one heartbeat: %.4f ms to read, %.3f ms to extend the lease\n", read_ms, write_ms);
    pen_store_close(store);
}

static void remove_store(const char *folder)
{
    static const char *const ends[] = {"", "-wal", "-shm", "-reserve"};
    char path[300];
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        snprintf(path, sizeof path, "%s/penumbra.db%s", folder, ends[i]);
        unlink(path);
    }
    rmdir(folder);
}

int main(int argc, char **argv)
{
    static struct run runs[JOBS][RUNS_MAX];
    int count = argc > 1 ? atoi(argv[1]) : 5;
    char folder[200], url[230];
    struct pen_limits limits = pen_limits_default();
    struct pen_status st = {0};
    pthread_t thread;
    count = count < 1 ? 1 : count > RUNS_MAX ? RUNS_MAX : count;
    snprintf(folder, sizeof folder, "%s/penumbra-bench-XXXXXX", argc > 2 ? argv[2] : "/tmp");
    if (!mkdtemp(folder))
        die("cannot make a folder", &st);
    snprintf(url, sizeof url, "%s/penumbra.db", folder);
    options.store_url = url;
    struct pen_store *store = pen_store_open(url, true, &st);
    struct pen_jobs *jobs = store ? pen_jobs_open(url, &limits, &st) : NULL;
    pen_store_close(store);
    if (!jobs || pthread_create(&thread, NULL, work, NULL) != 0)
        die("cannot start", &st);
    for (int i = -WARM_UP; i < count; i++) {
        for (int j = 0; j < JOBS; j++)
            runs[j][i < 0 ? 0 : i] = run_job(jobs, workloads[j].body);
    }
    atomic_store(&stop, true);
    pen_store_wake(pen_jobs_store(jobs));
    pthread_join(thread, NULL);
    for (int j = 0; j < JOBS; j++)
        print_job(workloads[j].title, runs[j], count);
    time_heartbeats(jobs, url);
    pen_jobs_close(jobs);
    remove_store(folder);
    return 0;
}
