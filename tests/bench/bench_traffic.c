/* SPDX-License-Identifier: MIT */
/* The cost of a job besides rendering: a worker's calls on the store, their number of transactions,
 * and their time (wall time, and processor time of the calling thread). The runs of several jobs
 * are interleaved. Shares refer to the time that the job's tiles took to render. Pixels are
 * compressed in a thread of its own while rendering goes on, so compression counts as processor
 * time only. Heartbeats are also timed on their own, since a short job has few: most only read, and
 * once in a third of the lease one extends it.
 *
 * usage: bench_traffic [runs] [folder]     makes the store in a new folder below `folder` (/tmp) */
#include <inttypes.h>
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

/* The calls of one kind. */
struct tally {
    int calls;
    int64_t transactions;
    double wall_ms, cpu_ms;
};
enum { COMMIT, CLAIM, READ, HEARTBEAT, COMPRESS, CHECKPOINT, OTHER, KINDS };
static const char *const kind_names[KINDS] = {
    [COMMIT] = "commit",       [CLAIM] = "claim",       [READ] = "read",
    [HEARTBEAT] = "heartbeat", [COMPRESS] = "compress", [CHECKPOINT] = "checkpoint",
    [OTHER] = "other"};

/* One run of a job. */
struct run {
    struct tally kind[KINDS];
    double render_ms, cpu_ms, stats_store_ms;
};

static struct {
    pthread_mutex_t lock;
    struct run run; /* guarded by lock */
} current = {.lock = PTHREAD_MUTEX_INITIALIZER};

static int kind_of(const char *name)
{
    if (strcmp(name, "commit") == 0)
        return COMMIT;
    if (strcmp(name, "claim") == 0)
        return CLAIM;
    if (strcmp(name, "job") == 0 || strcmp(name, "scene") == 0 || strcmp(name, "pixels") == 0)
        return READ;
    if (strcmp(name, "compress") == 0)
        return COMPRESS;
    if (strcmp(name, "checkpoint") == 0)
        return CHECKPOINT;
    return strcmp(name, "heartbeat") == 0 ? HEARTBEAT : OTHER;
}

/* Called after each call on the store. */
static void count_call(void *user, const struct pen_store_call *call)
{
    (void)user;
    pthread_mutex_lock(&current.lock);
    struct tally *tally = &current.run.kind[kind_of(call->name)];
    tally->calls++;
    tally->transactions += call->transactions;
    tally->wall_ms += (double)call->wall_ns * 1e-6;
    tally->cpu_ms += (double)call->cpu_ns * 1e-6;
    pthread_mutex_unlock(&current.lock);
}

static void die(const char *step, const struct pen_status *st)
{
    fprintf(stderr, "bench_traffic: %s: %s\n", step, st->msg);
    exit(1);
}

static const struct pen_store_observer observer = {.called = count_call};
static struct pen_worker_options options = {.id = "bench:1:1", .threads = 2, .observer = &observer};
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
            pen_store_wait(store, PEN_SIGNAL_CHANGES, &seen, 100);
    }
    usleep(20000); /* the change is notified before the last call is counted */
}

static void read_times(struct pen_jobs *jobs, const char *id, struct run *run)
{
    struct pen_status st;
    json_t *stats = pen_jobs_stats(jobs, id, &st);
    if (!stats)
        die("stats", &st);
    const json_t *timing = json_object_get(stats, "timing");
    run->render_ms = json_number_value(json_object_get(timing, "render_ms"));
    run->cpu_ms = json_number_value(json_object_get(timing, "cpu_ms"));
    run->stats_store_ms = json_number_value(json_object_get(timing, "store_ms"));
    json_decref(stats);
}

static struct run run_job(struct pen_jobs *jobs, const char *body)
{
    struct pen_submission in = {.body = body, .bytes = strlen(body)};
    struct pen_submitted out;
    struct pen_errors errors = {0};
    pthread_mutex_lock(&current.lock);
    current.run = (struct run){0};
    pthread_mutex_unlock(&current.lock);
    if (!pen_jobs_submit(jobs, &in, &out, &errors)) {
        fprintf(stderr, "bench_traffic: refused: %s\n", errors.item[0].msg);
        exit(1);
    }
    pen_buf_release(&out.answer);
    wait_until_ended(pen_jobs_store(jobs), out.id);
    pthread_mutex_lock(&current.lock);
    struct run run = current.run;
    pthread_mutex_unlock(&current.lock);
    read_times(jobs, out.id, &run);
    return run;
}

struct range {
    double median, least, most;
};

static struct range range_of(double *values, int count)
{
    const double median = bench_median(values, count); /* which sorts them */
    return (struct range){.median = median, .least = values[0], .most = values[count - 1]};
}

/* The time that rendering waits: all calls of the worker's own thread. */
static double waited_ms(const struct run *run)
{
    return run->kind[COMMIT].wall_ms + run->kind[CLAIM].wall_ms + run->kind[READ].wall_ms +
           run->kind[OTHER].wall_ms;
}

static double spent_ms(const struct run *run)
{
    double ms = 0;
    for (int kind = 0; kind < KINDS; kind++)
        ms += run->kind[kind].cpu_ms;
    return ms;
}

static void print_kind(const struct run *runs, int count, int kind)
{
    double wall[RUNS_MAX], cpu[RUNS_MAX];
    const struct tally *first = &runs[0].kind[kind];
    for (int i = 0; i < count; i++) {
        wall[i] = runs[i].kind[kind].wall_ms;
        cpu[i] = runs[i].kind[kind].cpu_ms;
    }
    struct range w = range_of(wall, count), c = range_of(cpu, count);
    printf("  %-9s %3d calls, %2" PRId64 " transactions (run 1), wall %8.3f ms (%.3f to %.3f),"
           " processor %8.3f ms\n",
           kind_names[kind], first->calls, first->transactions, w.median, w.least, w.most,
           c.median);
}

static void print_range(const char *what, double *values, int count)
{
    struct range r = range_of(values, count);
    printf("  %s %.2f (%.2f to %.2f)\n", what, r.median, r.least, r.most);
}

static void print_job(const char *title, const struct run *runs, int count)
{
    double render[RUNS_MAX], commits[RUNS_MAX], all[RUNS_MAX], cpu[RUNS_MAX], stats[RUNS_MAX];
    for (int i = 0; i < count; i++) {
        const struct run *run = &runs[i];
        double beat_ms = run->kind[HEARTBEAT].wall_ms;
        render[i] = run->render_ms;
        commits[i] = 100 * (waited_ms(run) - run->kind[READ].wall_ms + beat_ms) / run->render_ms;
        all[i] = 100 * (waited_ms(run) + beat_ms) / run->render_ms;
        cpu[i] = 100 * spent_ms(run) / run->cpu_ms;
        stats[i] = run->stats_store_ms;
    }
    printf("%s, %d runs\n", title, count);
    for (int kind = 0; kind < KINDS; kind++)
        print_kind(runs, count, kind);
    print_range("rendering, ms", render, count);
    print_range("claims, commits and heartbeats, % of it", commits, count);
    print_range("with reads, %", all, count);
    print_range("processor time of all these, % of the tiles'", cpu, count);
    print_range("store_ms of the statistics", stats, count);
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
    struct pen_store *store = pen_store_open(url, &st);
    if (!store || !pen_jobs_submit(jobs, &in, &out, &errors) ||
        !pen_store_claim(store, "bench:2:2", LEASE_MS, &claim, &found, &st) || !found)
        die("claim", &st);
    pen_buf_release(&out.answer);
    int64_t begun = pen_clock_ns();
    for (int i = 0; i < BEATS; i++)
        pen_store_heartbeat(store, &claim, LEASE_MS, &held, &st);
    double read_ms = (double)(pen_clock_ns() - begun) * 1e-6 / BEATS;
    begun = pen_clock_ns();
    for (int64_t i = 1; i <= EXTENSIONS;
         i++) /* asks for a lease so long that it is extended each time */
        pen_store_heartbeat(store, &claim, (int64_t)LEASE_MS * 2 * (i + 1), &held, &st);
    double write_ms = (double)(pen_clock_ns() - begun) * 1e-6 / EXTENSIONS;
    /* A worker sends five heartbeats a second; with its lease of 15 s, one in 5 s extends the
     * lease. */
    printf("one heartbeat: %.4f ms to read, %.3f ms to extend the lease; at five a second and"
           " one extension in 5 s that is %.3f %% of the time\n",
           read_ms, write_ms, 100 * (5 * read_ms + write_ms / 5) / 1000);
    pen_store_close(store);
}

static void remove_store(const char *folder)
{
    static const char *const ends[] = {"", "-wal", "-shm", "-wake"};
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
    struct pen_jobs *jobs = pen_jobs_open(url, &limits, &st);
    if (!jobs || pthread_create(&thread, NULL, work, NULL) != 0)
        die("cannot start", &st);
    for (int i = -WARM_UP; i < count; i++) {
        for (int j = 0; j < JOBS; j++)
            runs[j][i < 0 ? 0 : i] = run_job(jobs, workloads[j].body);
    }
    atomic_store(&stop, true);
    pen_store_wake(pen_jobs_store(jobs), PEN_SIGNAL_WORK);
    pthread_join(thread, NULL);
    for (int j = 0; j < JOBS; j++)
        print_job(workloads[j].title, runs[j], count);
    time_heartbeats(jobs, url);
    pen_jobs_close(jobs);
    remove_store(folder);
    return 0;
}
