/* SPDX-License-Identifier: MIT */
/* A worker on a disk with too little space for one job's result: it goes on with others, and stores
 * that result when there is space. Takes root's rights; without them nothing is tested. */
#include <stdatomic.h>
#include <string.h>
#include <unistd.h>

#include "support/jobs.h"
#include "support/small_disk.h"
#include "support/suite.h"

static struct jobs_bed bed;

static bool open_small_disk(int mib)
{
    struct pen_status st;
    store_bed_make(&bed.bed);
    if (!small_disk_mount(bed.bed.folder, mib))
        return false;
    jobs_bed_open(&bed);
    store_must(pen_store_reserve(bed.bed.store, &st), &st, "reserve");
    return true;
}

static void close_small_disk(void)
{
    jobs_worker_stop(&bed);
    pen_jobs_close(bed.jobs);
    store_audit_clean(bed.bed.store);
    pen_store_close(bed.bed.store);
    small_disk_unmount(bed.bed.folder);
}

/* `large`: a job whose batch is more than can be stored. Another one is submitted while the worker
 * is at it. */
static void wait_for_space(const char *large)
{
    enum { DISK_MIB = 64, FREE_BYTES = 3 << 19 };
    static const char small[] =
        "{\"scene\": \"builtin:spheres\", \"render\": {\"width\": 16, \"height\": 12}}";
    char large_id[PEN_ID_BYTES], small_id[PEN_ID_BYTES];
    if (!open_small_disk(DISK_MIB))
        return;
    jobs_submit(&bed, large, large_id);
    jobs_submit(&bed, small, small_id);
    small_disk_fill(bed.bed.folder, FREE_BYTES);
    bed.batch_ms = 600000; /* however slow the build, it is one batch and not several that fit */
    jobs_worker_start(&bed);
    ck_assert_int_eq(jobs_wait(&bed, small_id), PEN_JOB_SUCCEEDED);
    ck_assert_int_eq(store_job_state(bed.bed.store, large_id), PEN_JOB_RUNNING);
    small_disk_free(bed.bed.folder);
    ck_assert_int_eq(jobs_wait(&bed, large_id), PEN_JOB_SUCCEEDED);
    struct pen_job_record job = store_job_get(bed.bed.store, large_id);
    ck_assert_int_eq(job.attempts, 1);
    pen_job_record_release(&job);
    close_small_disk();
}

START_TEST(test_small_disk__large_picture_waits_and_others_go_on)
{
    wait_for_space("{\"scene\": \"builtin:patterns\", \"priority\": 5, \"render\":"
                   " {\"width\": 900, \"height\": 700, \"samples_per_pixel\": 1}}");
}
END_TEST

/* Layers are stored before the commit. */
START_TEST(test_small_disk__large_layer_waits_and_others_go_on)
{
    wait_for_space("{\"scene\": \"builtin:spheres\", \"priority\": 5, \"layers\":"
                   " [\"beauty\", \"depth\"], \"render\":"
                   " {\"width\": 400, \"height\": 400, \"samples_per_pixel\": 1}}");
}
END_TEST

/* How many jobs that come before the slow one were submitted, and how many of them were begun. */
static atomic_int urgent_sent, urgent_begun;

static bool is_slow(void *user, const char *job_name)
{
    (void)user;
    const bool slow = job_name && strcmp(job_name, "slow") == 0;
    if (!slow)
        atomic_store(&urgent_begun, atomic_load(&urgent_sent));
    return slow;
}

/* Twice, the slow job waits for another one to give way to, and takes much longer then than the
 * worker takes to look for it. */
static bool begin_slowly(void *user, int x, int y)
{
    enum { SLOW_ONES = 2 };
    const int begun = atomic_load(&urgent_begun);
    (void)user;
    (void)x;
    (void)y;
    if (begun >= SLOW_ONES)
        return true;
    while (atomic_load(&urgent_sent) == begun)
        usleep(1000);
    usleep(300);
    return true;
}

/* A view in rounds whose state has no room on the disk: jobs of higher priority, of which the next
 * comes as soon as the last one is done, get their turn, and it gets its own in the end. */
START_TEST(test_small_disk__rounds_without_room_give_way_and_end)
{
    enum { DISK_MIB = 64, FREE_BYTES = 3 << 20, URGENT_MAX = 40 };
    static const struct pen_worker_fault slow = {.wanted = is_slow, .pixel = begin_slowly};
    static const char lengthy[] = "{\"scene\": \"builtin:spheres\", \"name\": \"slow\","
                                  " \"render\": {\"width\": 260, \"height\": 260, \"tile\": 16,"
                                  " \"target_error\": 0.0005, \"max_samples\": 16}}",
                      urgent[] = "{\"scene\": \"builtin:spheres\", \"priority\": 5, \"render\":"
                                 " {\"width\": 16, \"height\": 12}}";
    char id[PEN_ID_BYTES], other[PEN_ID_BYTES];
    int urgent_ones = 0;
    if (!open_small_disk(DISK_MIB))
        return;
    bed.patience_ms = 50;
    bed.fault = &slow;
    jobs_submit(&bed, lengthy, id);
    small_disk_fill(bed.bed.folder, FREE_BYTES);
    jobs_worker_start(&bed);
    while (store_job_state(bed.bed.store, id) == PEN_JOB_QUEUED)
        usleep(10000);
    while (store_job_state(bed.bed.store, id) == PEN_JOB_RUNNING) {
        jobs_submit(&bed, urgent, other);
        atomic_fetch_add(&urgent_sent, 1);
        ck_assert_int_eq(jobs_wait(&bed, other), PEN_JOB_SUCCEEDED);
        ck_assert(!jobs_has_kept(&bed, id, PEN_KEPT_STATE));
        urgent_ones++;
        ck_assert_int_lt(urgent_ones, URGENT_MAX);
    }
    ck_assert_int_ge(urgent_ones, 2);
    ck_assert_int_eq(store_job_state(bed.bed.store, id), PEN_JOB_SUCCEEDED);
    struct pen_job_record job = store_job_get(bed.bed.store, id);
    ck_assert_int_eq(job.attempts, 1); /* nothing was charged */
    pen_job_record_release(&job);
    bed.fault = NULL;
    close_small_disk();
}
END_TEST

PEN_SUITE("worker on a small disk", test_small_disk__large_picture_waits_and_others_go_on,
          test_small_disk__rounds_without_room_give_way_and_end,
          test_small_disk__large_layer_waits_and_others_go_on)
