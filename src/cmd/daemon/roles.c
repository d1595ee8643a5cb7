/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/roles.h"

#include <malloc.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include "base/clock.h"
#include "base/log.h"
#include "cmd/daemon/control.h"
#include "cmd/daemon/crash_record.h"
#include "cmd/daemon/fault_injection.h"
#include "http/server.h"
#include "jobs/worker.h"
#include "store/store.h"

/* The names of the processes in the kernel's lists (at most 15 bytes). */
static const char api_process[] = "penumbrad-api", worker_process[] = "penumbrad-work";

/* How long the api may take for its last answers. Then SIGALRM ends it. */
enum { STOP_API_S = 3 };

/* The pause before an api process tries again to open a store. */
enum { OPEN_AGAIN_MS = 500 };

/* Opens the log again. text: "LEVEL FORMAT FILE". */
static void reopen_log(const char *text)
{
    char level[16] = "", format[16] = "";
    int end = 0;
    struct pen_status st;
    sscanf(text, "%15s %15s %n", level, format, &end);
    const struct pen_log_target target = {.level = level, .format = format, .file = text + end};
    if (!pen_config_log(&target, &st))
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
}

static int fail(const struct pen_status *st)
{
    pen_log(PEN_LOG_ERROR, "%s", st->msg);
    return pen_code_exit(st->code);
}

/* Makes SIGALRM end the process if it has not ended by itself by then. */
static void end_within(unsigned seconds)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGALRM);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
    signal(SIGALRM, SIG_DFL);
    alarm(seconds);
}

/* Opens the store, if it is not open yet. Logs the reason of a failure if it differs from
 * `last`. */
static bool open_store(struct pen_http *http, const struct pen_http_options *options,
                       struct pen_status *last, int control_fd)
{
    struct pen_status st;
    if (pen_http_open(http, options, &st)) {
        pen_log(PEN_LOG_INFO, "serving");
        pen_control_send(control_fd, "ready");
        return true;
    }
    if (strcmp(st.msg, last->msg) != 0)
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
    *last = st;
    return false;
}

/* The I/O error because of which the store can no longer be relied on. */
struct fault {
    pthread_mutex_t lock;
    struct pen_status why; /* guarded by lock; code PEN_OK: no error */
    const struct pen_event_source *events;
};

/* Notes the first I/O error. Threads: any. */
static void note_fault(void *user, const struct pen_status *why)
{
    struct fault *fault = user;
    pthread_mutex_lock(&fault->lock);
    const bool first = fault->why.code == PEN_OK;
    if (first)
        fault->why = *why;
    pthread_mutex_unlock(&fault->lock);
    if (first)
        pen_event_source_work_ended(fault->events);
}

/* Reports the I/O error for which this process ends to the supervisor and the log. Returns the exit
 * code, which is never charged to a job. */
static int end_for_fault(const struct pen_event_source *events, const struct pen_status *why)
{
    char text[PEN_CONTROL_BYTES];
    pen_log(PEN_LOG_ERROR, "the store has an I/O error, so this process ends: %s", why->msg);
    snprintf(text, sizeof text, "fault %s", why->msg);
    pen_control_send(events->control_fd, text);
    return pen_code_exit(PEN_STORAGE);
}

/* Opens the store, and handles the api's events until it must stop. Returns the exit code. */
static int handle_api_events(struct pen_event_source *events, struct pen_http *http,
                             const struct pen_http_options *options, struct fault *fault)
{
    struct pen_status last = {.code = PEN_OK}, why;
    bool opened = false;
    for (;;) {
        struct pen_event event;
        opened = opened || open_store(http, options, &last, events->control_fd);
        pen_event_source_next(events, opened ? -1 : OPEN_AGAIN_MS, &event);
        switch (event.kind) {
        case PEN_EVENT_DRAIN:
            pen_http_drain(http);
            break;
        case PEN_EVENT_LOG:
            reopen_log(event.text);
            break;
        case PEN_EVENT_STOP:
            pen_http_drain(http);
            end_within(STOP_API_S);
            return 0;
        case PEN_EVENT_LOST:
            pen_log(PEN_LOG_ERROR, "the supervisor has ended: ending");
            end_within(PEN_LOST_MS / 1000);
            return 0;
        case PEN_EVENT_STATE:
            pen_http_set_not_ready(http, event.text);
            break;
        case PEN_EVENT_WORK_END:
            end_within(STOP_API_S);
            pthread_mutex_lock(&fault->lock);
            why = fault->why;
            pthread_mutex_unlock(&fault->lock);
            return end_for_fault(events, &why);
        case PEN_EVENT_TIMEOUT:
            break;
        }
    }
}

/* Raises the limit of descriptors as far as the system allows: each connection needs a
 * descriptor. */
static void raise_descriptor_limit(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0)
        return;
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
}

/* Rays that a thread traces in a second in scenes that are quick to render. A job usually takes
 * longer than this implies. */
static const double thread_rays_per_second = 4e6;

static struct pen_limits limits_of(const struct pen_config *config)
{
    const struct pen_job_limits *max = &config->max;
    struct pen_limits limits = pen_limits_default();
    const long cores = sysconf(_SC_NPROCESSORS_ONLN);
    const double threads = config->threads ? config->threads : cores > 0 ? (double)cores : 1;
    if (max->timeout)
        limits.timeout_seconds = max->timeout;
    if (max->pixels)
        limits.pixels_per_view = (uint64_t)max->pixels;
    limits.samples = max->samples;
    limits.priority = max->priority;
    limits.queue = max->queue;
    limits.address_queue = max->client_queue;
    limits.seconds = max->seconds;
    limits.rays_per_second = threads * thread_rays_per_second;
    return limits;
}

static int serve(const struct pen_config *config)
{
    struct pen_event_source events;
    struct pen_status st;
    if (!pen_event_source_open(&events, config->control_fd, &st))
        return fail(&st);
    struct fault fault = {.lock = PTHREAD_MUTEX_INITIALIZER, .events = &events};
    struct pen_http_options options = {.broken = note_fault,
                                       .broken_user = &fault,
                                       .listen_fd = config->listen_fd,
                                       .store_url = config->store,
                                       .limits = limits_of(config),
                                       .trusted_proxy = config->access.trusted_proxy,
                                       .tokens = config->access.tokens,
                                       .tls_cert = config->access.tls_cert,
                                       .tls_key = config->access.tls_key,
                                       .cors = config->access.cors};
    struct pen_http *http = pen_http_start(&options, &st);
    if (!http) {
        pen_event_source_close(&events);
        return fail(&st);
    }
    const int code = handle_api_events(&events, http, &options, &fault);
    pen_http_stop(http);
    pen_event_source_close(&events);
    pen_log(PEN_LOG_INFO, "ended");
    return code;
}

static void set_allocator(void)
{
    mallopt(M_ARENA_MAX, 2); /* answers are small, so more arenas would only keep memory */
    mallopt(M_MMAP_THRESHOLD, 1 << 20); /* large ones go back to the system when they are freed */
    /* Otherwise the hundreds of thousands of small blocks of a freed large scene would stay apart.
     * Later a thread that answers another request would have to merge them all. */
    mallopt(M_MXFAST, 0);
}

int pen_role_api(const struct pen_config *config)
{
    pen_log_set_name("api");
    prctl(PR_SET_NAME, api_process);
    raise_descriptor_limit();
    set_allocator();
    if (!pen_log_writer_start()) /* threads that serve connections must not block */
        pen_log(PEN_LOG_WARN, "no thread for the log");
    const int code = serve(config);
    pen_log_writer_stop();
    return code;
}

/* The worker's own thread. The main thread handles events meanwhile. */
struct worker_thread {
    struct pen_worker_options options;
    atomic_bool stop;
    const struct pen_event_source *events;
    /* Written by the thread, read after joining it. */
    bool ok;
    struct pen_status st;
};

static void *run_worker(void *user)
{
    struct worker_thread *worker = user;
    worker->ok = pen_worker_run(&worker->options, &worker->stop, &worker->st);
    pen_event_source_work_ended(worker->events);
    return NULL;
}

/* Releases the leases of the predecessor. The supervisor has reported its end, which may be charged
 * to its jobs (src/store/README.md). */
static bool release_predecessor(struct pen_store *store, const struct pen_config *config,
                                struct pen_status *st)
{
    int opened = 0;
    const char *dead = config->dead_worker;
    struct pen_worker_report report = {.worker = dead,
                                       .end = PEN_WORKER_DIED,
                                       .how = config->dead_how ? config->dead_how : "?",
                                       .trace = pen_crash_record_map(config->dead_trace_fd)};
    if (config->dead_end && strcmp(config->dead_end, "crashed") == 0)
        report.end = PEN_WORKER_CRASHED;
    if (dead && !pen_jobs_worker_ended(store, &report, &opened, st))
        return false;
    if (opened > 0)
        pen_log(PEN_LOG_INFO, "released %d batch%s of the dead worker %s", opened,
                opened == 1 ? "" : "es", dead);
    return true;
}

/* Gives up the lease of a batch that takes too long, so that a later commit of it would be refused.
 * Then ends the process while render threads still run. */
static _Noreturn void abandon_batch(struct pen_store *store, const struct worker_thread *worker)
{
    struct pen_status st;
    struct pen_worker_death left = {.worker = worker->options.id, .end = PEN_WORKER_LEFT};
    int opened;
    end_within(1);
    pen_log(PEN_LOG_WARN, "giving the unfinished batch back");
    if (!pen_store_worker_ended(store, &left, &opened, &st))
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
    _exit(0);
}

/* Handles the worker's events until its thread has ended. "stop" and the end of the supervisor set
 * a deadline for the thread; the earlier deadline counts. */
static void handle_worker_events(struct pen_event_source *events, struct worker_thread *worker,
                                 struct pen_store *store)
{
    int64_t deadline_ns = INT64_MAX;
    for (;;) {
        struct pen_event event;
        int64_t left_ms = (deadline_ns - pen_clock_ns()) / 1000000;
        int timeout_ms = deadline_ns == INT64_MAX ? -1 : left_ms > 0 ? (int)left_ms : 0;
        pen_event_source_next(events, timeout_ms, &event);
        if (event.kind == PEN_EVENT_WORK_END)
            return;
        if (event.kind == PEN_EVENT_TIMEOUT)
            abandon_batch(store, worker);
        if (event.kind == PEN_EVENT_LOG)
            reopen_log(event.text);
        bool lost = event.kind == PEN_EVENT_LOST;
        if (lost)
            pen_log(PEN_LOG_ERROR, "the supervisor has ended: ending");
        if (!lost && event.kind != PEN_EVENT_STOP)
            continue;
        int64_t until =
            pen_clock_ns() + (lost ? PEN_LOST_MS / 2 : PEN_DRAIN_WORKER_MS) * INT64_C(1000000);
        deadline_ns = until < deadline_ns ? until : deadline_ns;
        atomic_store(&worker->stop, true);
        pen_store_wake(store);
    }
}

static void end_broken(void *user, const struct pen_status *why)
{
    _exit(end_for_fault(user, why));
}

/* Ends after a store call that failed before there was work. */
static int fail_store(const struct pen_event_source *events, const struct pen_status *st)
{
    return st->code == PEN_STORAGE ? end_for_fault(events, st) : fail(st);
}

/* Ends render threads that do not stop, by ending the process. The worker calls it after it has
 * stored that their claim has ended. */
static void end_stuck_threads(void *user)
{
    (void)user;
    _exit(0);
}

#ifndef __has_feature
#define __has_feature(name) 0 /* clang has it; gcc defines __SANITIZE_… instead */
#endif

/* Makes allocations fail beyond a limit: `mib`, or if that is 0, three quarters of the machine's
 * memory. Returns the limit in bytes. It is 0 if there is none, as under sanitizers, which need
 * more address space than a limit leaves. */
static size_t limit_memory(int mib)
{
#if defined __SANITIZE_ADDRESS__ || defined __SANITIZE_THREAD__ ||                                 \
    __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
    (void)mib;
    return 0;
#else
    long pages = sysconf(_SC_PHYS_PAGES), page = sysconf(_SC_PAGESIZE);
    size_t bytes = (size_t)mib << 20;
    if (mib == 0 && pages > 0 && page > 0)
        bytes = (size_t)pages / 4 * 3 * (size_t)page;
    struct rlimit limit;
    if (bytes == 0 || getrlimit(RLIMIT_DATA, &limit) != 0)
        return 0;
    if (limit.rlim_max == RLIM_INFINITY || bytes < limit.rlim_max)
        limit.rlim_cur = bytes;
    else
        limit.rlim_cur = limit.rlim_max;
    return setrlimit(RLIMIT_DATA, &limit) == 0 ? (size_t)limit.rlim_cur : 0;
#endif
}

/* Reads the test settings in a worker's environment: the length of leases, the times between kept
 * states and between rounds of the housekeeping, and a fault. */
static bool take_test_settings(struct pen_worker_options *options, struct pen_fault_hook *hook,
                               struct pen_status *st)
{
    const char *lease = getenv("PENUMBRA_LEASE_MS"), *keep = getenv("PENUMBRA_KEEP_MS"),
               *round = getenv("PENUMBRA_HOUSEKEEPING_MS"), *fault = getenv("PENUMBRA_TEST_FAULT");
    if (lease)
        options->lease_ms = strtol(lease, NULL, 10);
    if (keep)
        options->keep_ms = strtol(keep, NULL, 10);
    if (round)
        options->housekeeping_ms = strtol(round, NULL, 10);
    if (!fault || !*fault)
        return true;
    if (!pen_fault_parse(fault, hook, st))
        return false;
    options->fault = &hook->calls;
    return true;
}

static int run_worker_process(const struct pen_config *config, struct pen_event_source *events,
                              struct pen_store *store)
{
    struct worker_thread worker = {
        .events = events,
        .options = {.store_url = config->store,
                    .id = config->worker_name,
                    .idle_ms = (int64_t)config->until_idle * 1000,
                    .threads = config->threads,
                    .scene_cap_bytes = limit_memory(config->memory_limit) / 2,
                    .max_seconds = config->max.seconds,
                    .supervisor = getppid(),
                    .trace = pen_crash_record_map(config->trace_fd),
                    .stuck = end_stuck_threads,
                    .broken = end_broken,
                    .user = events}};
    struct pen_fault_hook hook;
    struct pen_status st;
    pthread_t thread;
    if (worker.options.trace)
        pen_crash_record_install(worker.options.trace);
    if (!take_test_settings(&worker.options, &hook, &st))
        return fail(&st);
    if (!release_predecessor(store, config, &st))
        return fail_store(events, &st);
    /* Before a job is taken: a later crash is charged to the job, an earlier crash to the
     * worker. */
    pen_control_send(events->control_fd, "ready");
    if (pthread_create(&thread, NULL, run_worker, &worker) != 0) {
        pen_fail(&st, PEN_NO_MEMORY, "cannot start a thread");
        return fail(&st);
    }
    pen_log(PEN_LOG_INFO, "working as %s", config->worker_name);
    handle_worker_events(events, &worker, store);
    pthread_join(thread, NULL);
    if (!worker.ok)
        return fail_store(events, &worker.st);
    if (!atomic_load(&worker.stop))
        pen_control_send(events->control_fd, "idle");
    pen_log(PEN_LOG_INFO, "ended");
    return 0;
}

int pen_role_worker(const struct pen_config *config)
{
    struct pen_event_source events;
    struct pen_status st;
    pen_log_set_name("worker");
    prctl(PR_SET_NAME, worker_process);
    if (!pen_event_source_open(&events, config->control_fd, &st))
        return fail(&st);
    struct pen_store *store = pen_store_open(config->store, false, &st);
    int code = store ? run_worker_process(config, &events, store) : fail_store(&events, &st);
    pen_store_close(store);
    pen_event_source_close(&events);
    return code;
}
