/* SPDX-License-Identifier: MIT */
/* A disk that fails on request, below SQLite: a VFS that passes on to the system's. Calls on files
 * are counted by kind; from an armed plan follows which of them fail, and how. It can also remember
 * what was synced, so that a test cuts the power: all that was not synced may be lost, in any part.
 *
 * One plan per process; libcheck runs each test in its own. */
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
    FAULT_SHM = 32, /* the shared memory of the log's index */
    FAULT_ALL = 63
};

enum fault_mode {
    FAULT_ONCE,  /* the n-th call */
    FAULT_EVERY, /* every n-th */
    FAULT_FROM   /* the n-th and all after it */
};

struct fault_plan {
    unsigned calls; /* of enum fault_call: these are counted, and fail */
    enum fault_mode mode;
    long n;    /* from 1 */
    int error; /* errno */
    bool torn; /* a write that fails has written half */
};

/* Makes the VFS the default of the process; syncs are not passed on to the disk. */
void faults_install(void);

void faults_arm(const struct fault_plan *plan);

/* From now on what is synced is remembered, for faults_cut_power: each sync costs a copy of its
 * file. */
void faults_remember(void);

/* Returns how many calls have failed since. */
long faults_disarm(void);

/* Whether ever a descriptor was asked to sync after it had failed to. */
bool faults_synced_again(void);

/* Turns every file written through the VFS into what a disk may hold after a power cut: what was
 * synced, and of the rest any part, by the seed. Files must be closed. */
void faults_cut_power(uint64_t seed);

/* Forgets the files; called when a folder was made anew. */
void faults_forget(void);

#endif
