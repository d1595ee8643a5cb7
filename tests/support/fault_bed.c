/* SPDX-License-Identifier: MIT */
#include "support/fault_bed.h"

#include <check.h>
#include <errno.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "base/log.h"
#include "support/random.h"

const struct fault_plan fault_plans[] = {
    {.calls = FAULT_WRITE, .mode = FAULT_ONCE, .error = ENOSPC},
    {.calls = FAULT_WRITE, .mode = FAULT_FROM, .error = ENOSPC, .torn = true},
    {.calls = FAULT_WRITE, .mode = FAULT_ONCE, .error = EIO, .torn = true},
    {.calls = FAULT_WRITE, .mode = FAULT_EVERY, .error = EIO},
    {.calls = FAULT_WRITE | FAULT_SYNC, .mode = FAULT_FROM, .error = EIO},
    {.calls = FAULT_SYNC, .mode = FAULT_ONCE, .error = EIO},
    {.calls = FAULT_SYNC, .mode = FAULT_EVERY, .error = EIO},
    {.calls = FAULT_SYNC, .mode = FAULT_FROM, .error = ENOSPC},
    {.calls = FAULT_READ, .mode = FAULT_ONCE, .error = EIO},
    {.calls = FAULT_READ, .mode = FAULT_FROM, .error = EIO},
    {.calls = FAULT_TRUNCATE | FAULT_SHM, .mode = FAULT_ONCE, .error = EIO},
    {.calls = FAULT_ALL, .mode = FAULT_FROM, .error = EIO},
};
_Static_assert(sizeof fault_plans / sizeof fault_plans[0] == FAULT_PLANS, "the plans");

long fault_next(long n, int k)
{
    enum { FIRST = 4, STEP = 7 };
    const bool each = random_all() || n < FIRST + k % STEP;
    return n + random_stride() * (each ? 1 : STEP);
}

static void copy_file(const char *from, const char *to)
{
    static char data[1 << 20];
    FILE *in = fopen(from, "rb"), *out = fopen(to, "wb");
    ck_assert(in && out);
    size_t bytes = fread(data, 1, sizeof data, in);
    ck_assert(bytes > 0 && bytes < sizeof data && fwrite(data, 1, bytes, out) == bytes);
    fclose(in);
    ck_assert_int_eq(fclose(out), 0);
}

/* A small one: what it frees is no matter here, but its use must not hide or repeat a failure. */
static void make_reserve(const struct fault_bed *b)
{
    static const char zeros[64 << 10];
    char path[160];
    snprintf(path, sizeof path, "%s-reserve", b->bed.url);
    FILE *file = fopen(path, "wb");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(zeros, sizeof zeros, 1, file), 1);
    ck_assert_int_eq(fclose(file), 0);
}

void fault_bed_renew(struct fault_bed *b)
{
    static const char *const ends[] = {"-wal", "-shm", "-journal"};
    char path[160];
    for (size_t i = 0; i < sizeof ends / sizeof ends[0]; i++) {
        snprintf(path, sizeof path, "%s%s", b->bed.url, ends[i]);
        unlink(path);
    }
    faults_forget();
    copy_file(b->template, b->bed.url);
    make_reserve(b);
}

void fault_bed_open(struct fault_bed *b)
{
    pen_log_set_level(PEN_LOG_ERROR + 1); /* the failures would log thousands of lines */
    faults_install();
    struct store_job in;
    store_bed_open(&b->bed);
    snprintf(b->template, sizeof b->template, "%s/template", b->bed.folder);
    store_job_init(&in, FAULT_ENDED, 1, 1);
    store_job_submit(b->bed.store, &in);
    store_work_off(b->bed.store, "w");
    store_job_init(&in, FAULT_LAST, 1, 2);
    store_job_submit(b->bed.store, &in);
    for (int i = 0; i < 2; i++) {
        struct pen_claim claim = store_claim(b->bed.store, "w");
        ck_assert_int_eq(store_commit(b->bed.store, &claim), PEN_OK);
    }
    b->held[2] = store_claim(b->bed.store, "w");
    store_job_init(&in, FAULT_HALF, 1, 2);
    store_job_submit(b->bed.store, &in);
    b->held[0] = store_claim(b->bed.store, "w");
    b->held[1] = store_claim(b->bed.store, "gone");
    store_job_init(&in, FAULT_QUEUED, 1, 1);
    store_job_submit(b->bed.store, &in);
    store_worker_seen(b->bed.store, "w");
    pen_store_close(b->bed.store); /* which copies the log */
    copy_file(b->bed.url, b->template);
}

void fault_bed_close(struct fault_bed *b)
{
    fault_bed_renew(b);
    unlink(b->template);
    b->bed.store = store_bed_handle(&b->bed);
    store_bed_close(&b->bed);
}

const char *fault_bed_id(int n)
{
    static char id[PEN_ID_BYTES];
    struct store_job in;
    store_job_init(&in, n, 1, 1);
    memcpy(id, in.id, sizeof id);
    return id;
}

void fault_bed_check_refusal(const struct fault_bed *b, const struct fault_plan *plan,
                             const struct pen_status *st, const char *what)
{
    /* What a sync could not write is lost, whatever the reason. */
    const bool full = plan->error == ENOSPC && (plan->calls & FAULT_WRITE);
    ck_assert_msg(st->code == (full ? PEN_STORAGE_FULL : PEN_STORAGE), "%s: %s: %s", what,
                  pen_code_name(st->code), st->msg);
    ck_assert_msg(strstr(st->msg, b->bed.url) != NULL, "%s: %s", what, st->msg);
}
