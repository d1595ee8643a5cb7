/* SPDX-License-Identifier: MIT */
/* A disk that fails while a store is made or migrated: a new store is then whole or not there, a
 * migrated one is whole and of the old schema or the new. */
#include <sqlite3.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/fault_bed.h"
#include "support/random.h"
#include "support/store_sql.h"
#include "support/suite.h"

static struct fault_bed disk;

static void remove_store(void)
{
    fault_bed_renew(&disk);
    unlink(disk.bed.url);
}

/* A new store is whole or not there. */
static bool make_faulty(const struct fault_plan *plan)
{
    struct pen_status st = {0};
    struct stat info;
    remove_store();
    faults_arm(plan);
    disk.bed.store = pen_store_open(disk.bed.url, &st);
    bool failed = faults_disarm() > 0;
    bool there = stat(disk.bed.url, &info) == 0;
    ck_assert(there || !disk.bed.store);
    if (!disk.bed.store)
        fault_bed_check_refusal(&disk, plan, &st, "make");
    pen_store_close(disk.bed.store);
    disk.bed.store = store_bed_handle(&disk.bed);
    ck_assert(!there || pen_store_check(disk.bed.store, &st));
    store_audit_clean(disk.bed.store);
    pen_store_close(disk.bed.store);
    return failed;
}

START_TEST(test_faults_open__making_a_store)
{
    fault_bed_open(&disk);
    for (int k = 0; k < FAULT_PLANS; k++) {
        struct fault_plan plan = fault_plans[k];
        for (plan.n = 1; make_faulty(&plan); plan.n = fault_next(plan.n, k))
            continue;
    }
    fault_bed_close(&disk);
}
END_TEST

static bool migrate_faulty(const struct fault_plan *plan)
{
    struct pen_status st = {0};
    fault_bed_renew(&disk);
    faults_arm(plan);
    disk.bed.store = pen_store_open(disk.bed.url, &st);
    bool failed = faults_disarm() > 0;
    if (!disk.bed.store)
        fault_bed_check_refusal(&disk, plan, &st, "migrate");
    pen_store_close(disk.bed.store);
    disk.bed.store = store_bed_handle(&disk.bed);
    store_worker_seen(disk.bed.store, "w");
    ck_assert_int_eq(store_job_state(disk.bed.store, fault_bed_id(FAULT_HALF)), PEN_JOB_RUNNING);
    ck_assert_int_eq(store_job_state(disk.bed.store, fault_bed_id(FAULT_ENDED)), PEN_JOB_SUCCEEDED);
    store_audit_clean(disk.bed.store);
    pen_store_close(disk.bed.store);
    return failed;
}

START_TEST(test_faults_open__migration)
{
    fault_bed_open(&disk);
    store_downgrade(disk.template, 3);
    for (int k = 0; k < FAULT_PLANS; k++) {
        struct fault_plan plan = fault_plans[k];
        for (plan.n = 1; migrate_faulty(&plan); plan.n = fault_next(plan.n, k))
            continue;
    }
    fault_bed_close(&disk);
}
END_TEST

PEN_SUITE("store faults when opened", test_faults_open__making_a_store, test_faults_open__migration)
