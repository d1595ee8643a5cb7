/* SPDX-License-Identifier: MIT */
/* One child process of the supervisor: how it is started, what its end means, and when it may be
 * started again. */
#ifndef PEN_CMD_DAEMON_CHILD_H
#define PEN_CMD_DAEMON_CHILD_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#include "cmd/daemon/config.h"
#include "store/store.h"

struct pen_child {
    const char *role;                /* "api" or "worker" */
    pid_t pid;                       /* 0: not running */
    int control_fd;                  /* -1: not running, or it closed its end */
    bool ready;                      /* said so since it was started */
    bool stopping;                   /* was told to end */
    bool killed;                     /* by the supervisor */
    int64_t started_ns, start_at_ns; /* when it was, or is to be started */
    int failures;                    /* ends in a row, each soon after the start */
    char name[PEN_WORKER_ID_BYTES];  /* worker: its id in the store, "": it makes one */
    char last_end[96];               /* "signal 11 (SIGSEGV)", "" at first */
    /* Of a worker; see crash_record.h and oom.h. */
    int trace_fd;      /* -1: none */
    int64_t oom_kills; /* when it was started */
    /* A predecessor whose leases are not taken back yet; name "": none. */
    struct {
        char name[PEN_WORKER_ID_BYTES], how[96];
        enum pen_worker_end end;
        int trace_fd;
    } dead;
};

void pen_child_init(struct pen_child *child, const char *role);

/* Starts the program again in this role. The child gets listen_fd if that is not -1. The call
 * never fails: a start that does not succeed is an end, with its pause. */
void pen_child_start(struct pen_child *child, const struct pen_config *config, int listen_fd);

/* Notes that it works: what it was told of its predecessor is settled. */
void pen_child_ready(struct pen_child *child);

/* When a child that is running will have lived long enough to count as no crash loop any more:
 * then its failures are forgotten. Returns the time, or INT64_MAX if there is nothing to forget. */
int64_t pen_child_forgives_at_ns(const struct pen_child *child);
void pen_child_forgive(struct pen_child *child);

/* Notes that the process has ended with this wait status, writes it to the log, and sets the time
 * of the next start: at once after a life of some length, else after a pause that doubles. */
void pen_child_ended(struct pen_child *child, int wait_status);

#endif
