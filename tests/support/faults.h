/* SPDX-License-Identifier: MIT */
/* A disk that fails on request: a VFS of SQLite that calls the system's VFS. It counts the calls on
 * files; the armed plan decides which of them fail, and how. It can also remember the synced
 * contents, so that a test can cut the power: any part of the unsynced contents may then be lost.
 *
 * One plan per process; libcheck runs each test in its own process. */
#ifndef TESTS_SUPPORT_FAULTS_H
#define TESTS_SUPPORT_FAULTS_H

#include <stdbool.h>
#include <stdint.h>

enum fault_call {
    FAULT_WRITE = 1,
    FAULT_SYNC = 2,
    FAULT_READ = 4,
    FAULT_TRUNCATE = 8,
    FAULT_OPEN = 16,
    FAULT_SHM = 32, /* the shared memory of the write-ahead log's index */
    FAULT_ALL = 63
};

enum fault_mode {
    FAULT_ONCE,  /* the n-th call */
    FAULT_EVERY, /* every n-th */
    FAULT_FROM   /* the n-th and all later calls */
};

struct fault_plan {
    unsigned calls; /* of enum fault_call: the calls that count and fail */
    enum fault_mode mode;
    long n;    /* from 1 on */
    int error; /* the errno of the failure */
    bool torn; /* a write that fails has written half of its bytes */
};

/* Makes the VFS the default of the process. It does not pass syncs to the disk. */
void faults_install(void);

void faults_arm(const struct fault_plan *plan);

/* From now on remembers the synced contents, for faults_cut_power. Each sync costs a copy of the
 * file. */
void faults_remember(void);

/* Makes all calls succeed again. Returns how many have failed since faults_arm. */
long faults_disarm(void);

/* Returns true if any descriptor was synced again after a failed sync. */
bool faults_synced_again(void);

/* Gives every file written through the VFS contents that a disk may have after a power cut: the
 * synced contents, and a part of the others, drawn from the seed. Files must be closed. */
void faults_cut_power(uint64_t seed);

/* Forgets all files; call it when a folder was replaced. */
void faults_forget(void);

#endif
