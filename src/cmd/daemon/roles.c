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
#include "jobs/worker_report.h"
#include "store/store.h"

/* How long the api may take to end its answers before it is ended by force. */
enum { STOP_API_S = 3 };

/* "LEVEL FORMAT FILE" from the supervisor; after a bare SIGHUP the configuration stays. */
static void reopen_log(const struct pen_config *config, const char *text)
{
    char level[16] = "", format[16] = "";
    int end = 0;
    struct pen_status st;
    struct pen_log_target target = {config->log_level, config->log_format, config->log_file};
    if (sscanf(text, "%15s %15s %n", level, format, &end) == 2)
        target = (struct pen_log_target){level, format, text + end};
    if (!pen_config_log(&target, &st))
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
}

static int fail(const struct pen_status *st)
{
    pen_log(PEN_LOG_ERROR, "%s", st->msg);
    return pen_code_exit(st->code);
}

/* The last resort of a process that does not end by itself. */
static void end_within(unsigned seconds)
{
    sigset_t set;
    sigemptyset(&set);
    sigaddset(&set, SIGALRM);
    pthread_sigmask(SIG_UNBLOCK, &set, NULL);
    signal(SIGALRM, SIG_DFL);
    alarm(seconds);
}

/* Handles events until it is time to stop. */
static void serve(const struct pen_config *config, struct pen_event_source *watch,
                  struct pen_http *http)
{
    for (;;) {
        struct pen_event event;
        pen_event_source_next(watch, -1, &event);
        switch (event.kind) {
        case PEN_EVENT_DRAIN:
            pen_http_drain(http);
            break;
        case PEN_EVENT_LOG:
            reopen_log(config, event.text);
            break;
        case PEN_EVENT_STOP:
            pen_http_drain(http);
            end_within(STOP_API_S);
            return;
        case PEN_EVENT_LOST:
            pen_log(PEN_LOG_ERROR, "the supervisor is gone: ending");
            end_within(PEN_LOST_MS / 1000);
            return;
        case PEN_EVENT_STATE:
            pen_http_set_not_ready(http, event.text);
            break;
        case PEN_EVENT_WORK_END:
        case PEN_EVENT_TIMEOUT:
            break;
        }
    }
}

/* Each connection is a descriptor: takes as many as the system grants. */
static void raise_descriptor_limit(void)
{
    struct rlimit limit;
    if (getrlimit(RLIMIT_NOFILE, &limit) != 0)
        return;
    limit.rlim_cur = limit.rlim_max;
    setrlimit(RLIMIT_NOFILE, &limit);
}

int pen_role_api(const struct pen_config *config, int listen_fd)
{
    struct pen_event_source watch;
    struct pen_status st;
    pen_log_set_name("api");
    prctl(PR_SET_NAME, "penumbrad-api");
    raise_descriptor_limit();
    mallopt(M_ARENA_MAX, 2); /* many small answers: arenas per thread would only hold memory */
    if (!pen_event_source_open(&watch, config->control_fd, &st))
        return fail(&st);
    struct pen_http_options options = {
        .listen_fd = listen_fd, .store_url = config->store, .limits = pen_limits_default()};
    struct pen_http *http = pen_http_start(&options, &st);
    if (!http) {
        pen_event_source_close(&watch);
        return fail(&st);
    }
    pen_log(PEN_LOG_INFO, "serving");
    pen_control_send(watch.control_fd, "ready");
    serve(config, &watch, http);
    pen_http_stop(http);
    pen_event_source_close(&watch);
    pen_log(PEN_LOG_INFO, "ended");
    return 0;
}

/* The worker runs in a thread of its own, so that the process can be told things meanwhile. */
struct work {
    struct pen_worker_options options;
    atomic_bool stop;
    const struct pen_event_source *watch;
    bool ok; /* written by the thread, read after it was joined */
    struct pen_status st;
};

static void *run_worker(void *user)
{
    struct work *work = user;
    work->ok = pen_worker_run(&work->options, &work->stop, &work->st);
    pen_event_source_work_ended(work->watch);
    return NULL;
}

/* Releases the leases of workers that are dead: of the predecessor, whose end the supervisor has
 * reported and which may be charged, and of all others that hold no lock any more. */
static bool release_dead(struct pen_store *store, const struct pen_config *config,
                         struct pen_status *st)
{
    int opened = 0, others = 0;
    const char *dead = config->dead_worker;
    struct pen_worker_report report = {.worker = dead,
                                       .end = PEN_WORKER_DIED,
                                       .how = config->dead_how ? config->dead_how : "?",
                                       .trace = pen_crash_record_map(config->dead_trace_fd)};
    if (config->dead_end && strcmp(config->dead_end, "crashed") == 0)
        report.end = PEN_WORKER_CRASHED;
    if (dead && !pen_jobs_worker_ended(store, &report, &opened, st))
        return false;
    if (!pen_store_release_dead(store, &others, st))
        return false;
    if (opened > 0)
        pen_log(PEN_LOG_INFO, "took back %d batches of worker %s", opened, dead);
    if (others > 0)
        pen_log(PEN_LOG_INFO, "took back %d batches of workers that are no more", others);
    return true;
}

/* The batch in hand takes too long: its lease is given up here, the commit would be refused, and
 * the process ends under the render threads. */
static void give_up(struct pen_store *store, const struct work *work)
{
    struct pen_status st;
    struct pen_worker_death left = {.worker = work->options.id, .end = PEN_WORKER_LEFT};
    int opened;
    end_within(1);
    pen_log(PEN_LOG_WARN, "the batch in hand is given back unfinished");
    if (!pen_store_worker_ended(store, &left, &opened, &st))
        pen_log(PEN_LOG_ERROR, "%s", st.msg);
    _exit(0);
}

/* Handles events until the worker's thread has ended. */
static void attend(const struct pen_config *config, struct pen_event_source *watch,
                   struct work *work, struct pen_store *store)
{
    int64_t deadline_ns = INT64_MAX;
    for (;;) {
        struct pen_event event;
        int64_t left_ms = (deadline_ns - pen_clock_ns()) / 1000000;
        int timeout_ms = deadline_ns == INT64_MAX ? -1 : left_ms > 0 ? (int)left_ms : 0;
        pen_event_source_next(watch, timeout_ms, &event);
        if (event.kind == PEN_EVENT_WORK_END)
            return;
        if (event.kind == PEN_EVENT_TIMEOUT)
            give_up(store, work);
        if (event.kind == PEN_EVENT_LOG)
            reopen_log(config, event.text);
        bool lost = event.kind == PEN_EVENT_LOST;
        if (lost)
            pen_log(PEN_LOG_ERROR, "the supervisor is gone: ending");
        if (!lost && event.kind != PEN_EVENT_STOP)
            continue;
        int64_t until =
            pen_clock_ns() + (lost ? PEN_LOST_MS / 2 : PEN_DRAIN_WORKER_MS) * INT64_C(1000000);
        deadline_ns = until < deadline_ns ? until : deadline_ns;
        atomic_store(&work->stop, true);
        pen_store_wake(store, PEN_SIGNAL_WORK);
    }
}

/* Threads that nothing else can end. The store knows already that their batch is over. */
static void end_stuck(void *user)
{
    (void)user;
    _exit(0);
}

#ifndef __has_feature
#define __has_feature(name) 0 /* clang has it; gcc defines __SANITIZE_… instead */
#endif

/* Lets allocations fail from a limit on: `mib`, or most of what the machine has. Returns it in
 * bytes, 0 if there is none; sanitizers need more address space than any limit leaves. */
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

/* What tests change of a worker, by its environment: the length of leases, and a fault. */
static bool take_test_settings(struct pen_worker_options *options, struct pen_fault_hook *hook,
                               struct pen_status *st)
{
    const char *lease = getenv("PENUMBRA_LEASE_MS"), *fault = getenv("PENUMBRA_TEST_FAULT");
    if (lease)
        options->lease_ms = strtol(lease, NULL, 10);
    if (!fault || !*fault)
        return true;
    if (!pen_fault_parse(fault, hook, st))
        return false;
    options->fault = &hook->calls;
    return true;
}

static int work_until_told(const struct pen_config *config, struct pen_event_source *watch,
                           struct pen_store *store, const char *id)
{
    struct work work = {.watch = watch,
                        .options = {.store_url = config->store,
                                    .id = id,
                                    .threads = config->threads,
                                    .scene_cap_bytes = limit_memory(config->memory_limit) / 2,
                                    .trace = pen_crash_record_map(config->trace_fd),
                                    .stuck = end_stuck}};
    struct pen_fault_hook hook;
    struct pen_status st;
    pthread_t thread;
    if (work.options.trace)
        pen_crash_record_install(work.options.trace);
    if (!take_test_settings(&work.options, &hook, &st) || !release_dead(store, config, &st))
        return fail(&st);
    if (pthread_create(&thread, NULL, run_worker, &work) != 0) {
        pen_fail(&st, PEN_NO_MEMORY, "cannot start a thread");
        return fail(&st);
    }
    pen_log(PEN_LOG_INFO, "working as %s", id);
    pen_control_send(watch->control_fd, "ready");
    attend(config, watch, &work, store);
    pthread_join(thread, NULL);
    if (!work.ok)
        return fail(&work.st);
    pen_log(PEN_LOG_INFO, "ended");
    return 0;
}

int pen_role_worker(const struct pen_config *config)
{
    struct pen_event_source watch;
    struct pen_status st;
    char made[PEN_WORKER_ID_BYTES];
    const char *id = config->worker_name;
    pen_log_set_name("worker");
    prctl(PR_SET_NAME, PEN_WORKER_PROCESS);
    if (!id && !pen_worker_id_make(made, &st))
        return fail(&st);
    if (!pen_event_source_open(&watch, config->control_fd, &st))
        return fail(&st);
    struct pen_store *store = pen_store_open(config->store, &st);
    int code = store ? work_until_told(config, &watch, store, id ? id : made) : fail(&st);
    pen_store_close(store);
    pen_event_source_close(&watch);
    return code;
}
