/* SPDX-License-Identifier: MIT */
/* A disk that fails while a store is made. The store is then whole or missing, and the next call
 * makes it. */
#include <glob.h>
#include <stdio.h>
#include <sys/stat.h>
#include <unistd.h>

#include "support/fault_bed.h"
#include "support/suite.h"

static struct fault_bed disk;

static void remove_store(void)
{
    fault_bed_renew(&disk);
    unlink(disk.bed.url);
}

static void expect_no_part(void)
{
    glob_t found;
    char pattern[160];
    snprintf(pattern, sizeof pattern, "%s.new-*", disk.bed.url);
    ck_assert_int_eq(glob(pattern, 0, NULL, &found), GLOB_NOMATCH);
}

static bool make_faulty(const struct fault_plan *plan)
{
    struct pen_status st = {0};
    struct stat info;
    bool finished;
    remove_store();
    faults_arm(plan);
    disk.bed.store = pen_store_open(disk.bed.url, true, &st);
    bool failed = faults_disarm() > 0;
    bool there = stat(disk.bed.url, &info) == 0;
    ck_assert(there || !disk.bed.store);
    expect_no_part();
    if (!disk.bed.store)
        fault_bed_check_refusal(&disk, plan, &st, "make");
    pen_store_close(disk.bed.store);
    disk.bed.store = store_bed_handle(&disk.bed);
    store_must(pen_store_check(disk.bed.store, 0, &finished, &st), &st, "check");
    ck_assert(finished);
    ck_assert_int_eq(store_work_off(disk.bed.store, "w"), 0);
    pen_store_close(disk.bed.store);
    return failed;
}

START_TEST(test_sqlite_faults_open__making_a_store)
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

PEN_SUITE("store faults when opened", test_sqlite_faults_open__making_a_store)
