/* SPDX-License-Identifier: MIT */
/* GET /metrics: the state of the queue, of the store and of this process in Prometheus' text format
 * 0.0.4, with base units. Counters of work and of the store are sums over all processes of the
 * store. */
#include <math.h>
#include <stdio.h>
#include <unistd.h>

#include "http/internal/guard.h"
#include "http/internal/http.h"
#include "http/internal/request.h"
#include "http/internal/routes.h"

static void head(struct pen_buf *out, const char *name, const char *type, const char *help)
{
    pen_buf_printf(out, "# HELP %s %s\n# TYPE %s %s\n", name, help, name, type);
}

static void gauge(struct pen_buf *out, const char *name, const char *help, double value)
{
    head(out, name, "gauge", help);
    pen_buf_printf(out, "%s %.17g\n", name, value);
}

static void counter(struct pen_buf *out, const char *name, const char *help, uint64_t value)
{
    head(out, name, "counter", help);
    pen_buf_printf(out, "%s %llu\n", name, (unsigned long long)value);
}

static void add_queue(struct pen_buf *out, const struct pen_counts *counts, int64_t now_ms)
{
    const char *const jobs = "penumbra_jobs";
    const int64_t oldest_ms = counts->oldest_queued_ms;
    const double age = oldest_ms && now_ms > oldest_ms ? (double)(now_ms - oldest_ms) / 1000 : 0;
    head(out, jobs, "gauge", "Jobs in the store by state.");
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++)
        pen_buf_printf(out, "%s{state=\"%s\"} %lld\n", jobs,
                       pen_job_state_name((enum pen_job_state)i), (long long)counts->jobs[i]);
    gauge(out, "penumbra_queue_depth", "Jobs that wait for their first batch to be claimed.",
          (double)counts->jobs[PEN_JOB_QUEUED]);
    gauge(out, "penumbra_queue_oldest_seconds", "Age of the oldest job that waits.", age);
    gauge(out, "penumbra_batches_open", "Batches that a worker may claim.",
          (double)counts->open_batches);
    gauge(out, "penumbra_batches_leased", "Batches that workers hold.",
          (double)counts->leased_batches);
}

static void add_timing(struct pen_buf *out, const struct pen_counters *counters,
                       enum pen_timing timing, const char *name, const char *help)
{
    const uint64_t *const count =
        &counters->count[PEN_COUNT_TIMINGS + (int)timing * (PEN_TIMING_BUCKETS + 2)];
    uint64_t sum = 0;
    head(out, name, "histogram", help);
    for (int i = 0; i < PEN_TIMING_BUCKETS; i++) {
        sum += count[i];
        pen_buf_printf(out, "%s_bucket{le=\"%g\"} %llu\n", name, pen_timing_bounds_s[i],
                       (unsigned long long)sum);
    }
    sum += count[PEN_TIMING_BUCKETS];
    pen_buf_printf(out, "%s_bucket{le=\"+Inf\"} %llu\n%s_sum %.6f\n%s_count %llu\n", name,
                   (unsigned long long)sum, name, (double)count[PEN_TIMING_BUCKETS + 1] * 1e-6,
                   name, (unsigned long long)sum);
}

static void add_work(struct pen_buf *out, const struct pen_counters *counters)
{
    static const char *const results[] = {"ok", "duplicate", "stale"};
    const char *const commits = "penumbra_batch_commits_total";
    head(out, commits, "counter", "Commits of batches by what became of them.");
    for (int i = 0; i < 3; i++)
        pen_buf_printf(out, "%s{result=\"%s\"} %llu\n", commits, results[i],
                       (unsigned long long)counters->count[PEN_COUNT_COMMIT_OK + i]);
    add_timing(out, counters, PEN_TIMING_BATCH, "penumbra_batch_seconds",
               "Time that workers worked on the batches that were committed.");
    counter(out, "penumbra_rays_total", "Rays traced by render batches.",
            counters->count[PEN_COUNT_RAYS]);
    counter(out, "penumbra_leases_expired_total",
            "Leases that ran out or whose worker was found dead.",
            counters->count[PEN_COUNT_LEASES_LOST]);
    counter(out, "penumbra_worker_starts_total", "Worker processes that began to work.",
            counters->count[PEN_COUNT_WORKER_STARTS]);
}

/* The resident memory of this process; 0: unknown. */
static double resident_bytes(void)
{
    unsigned long long size, resident = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file || fscanf(file, "%llu %llu", &size, &resident) != 2)
        resident = 0;
    if (file)
        fclose(file);
    return (double)resident * (double)sysconf(_SC_PAGESIZE);
}

static void add_store(struct pen_buf *out, const struct pen_counters *counters, int64_t bytes)
{
    gauge(out, "penumbra_store_bytes", "Size of the store's files.", (double)bytes);
    add_timing(out, counters, PEN_TIMING_READ, "penumbra_store_read_seconds",
               "Time that reading transactions of all processes took.");
    add_timing(out, counters, PEN_TIMING_WRITE, "penumbra_store_write_seconds",
               "Time that writing transactions of all processes took, with the wait for others.");
}

static void add_connections(struct pen_buf *out, struct pen_http *http)
{
    static const char *const states[PEER_STATES] = {[PEER_IDLE] = "idle",
                                                    [PEER_HEAD] = "head",
                                                    [PEER_BODY] = "body",
                                                    [PEER_WORK] = "waiting",
                                                    [PEER_SEND] = "answering"};
    const char *const name = "penumbra_http_connections";
    int counts[PEER_STATES];
    pen_guard_count(http->guard, counts);
    head(out, name, "gauge", "Open connections by what they wait for.");
    for (int state = PEER_IDLE; state < PEER_STATES; state++)
        pen_buf_printf(out, "%s{state=\"%s\"} %d\n", name, states[state], counts[state]);
}

static unsigned long long count_of(const atomic_uint_least64_t *sum)
{
    return atomic_load_explicit(sum, memory_order_relaxed);
}

/* Adds counters of this process alone, since it started. */
static void add_refusals(struct pen_buf *out, const struct pen_http *http)
{
    const char *const refused = "penumbra_http_refused_requests_total";
    head(out, refused, "counter", "Requests that this api process refused for load, by status.");
    pen_buf_printf(out, "%s{code=\"429\"} %llu\n%s{code=\"503\"} %llu\n", refused,
                   count_of(&http->refused_429), refused, count_of(&http->refused_503));
    counter(out, "penumbra_http_failed_requests_total",
            "Requests that this api process answered with another status from 500 on.",
            count_of(&http->failed));
}

static void add_process(struct pen_buf *out, struct pen_http *http)
{
    const int polls = atomic_load_explicit(&http->polls, memory_order_relaxed),
              streams = atomic_load_explicit(&http->streams, memory_order_relaxed);
    const char *const requests = "penumbra_http_requests_in_progress";
    const int active = atomic_load_explicit(&http->active, memory_order_relaxed);
    head(out, requests, "gauge", "Requests that are not answered yet, by what they wait for.");
    pen_buf_printf(out, "%s{state=\"active\"} %d\n%s{state=\"poll\"} %d\n", requests,
                   active > polls + streams ? active - polls - streams : 0, requests, polls);
    gauge(out, "penumbra_sse_clients", "Open event streams.", streams);
    gauge(out, "process_resident_memory_bytes", "Resident memory of the api process.",
          resident_bytes());
    head(out, "penumbra_build_info", "gauge", "The version; always 1.");
    pen_buf_printf(out, "penumbra_build_info{version=\"%s\"} 1\n", PEN_VERSION);
}

enum outcome pen_http_handle_metrics(struct request *request, struct pen_jobs *jobs)
{
    struct pen_store *store = pen_jobs_store(jobs);
    struct pen_counts counts;
    struct pen_counters counters;
    struct pen_status st;
    struct pen_buf out = {0};
    int64_t now_ms;
    if (!pen_store_counts(store, &counts, &st) || !pen_store_counters(store, &counters, &st) ||
        !pen_store_now(store, &now_ms, &st))
        return pen_http_request_fail(request, &st);
    add_queue(&out, &counts, now_ms);
    add_work(&out, &counters);
    add_store(&out, &counters, counts.bytes);
    add_connections(&out, request->http);
    add_refusals(&out, request->http);
    add_process(&out, request->http);
    pen_http_reply_body(&request->reply, 200, pen_http_blob_take(&out),
                        "text/plain; version=0.0.4; charset=utf-8");
    pen_http_reply_field(&request->reply, "Cache-Control", "no-store");
    return OUTCOME_ANSWERED;
}
