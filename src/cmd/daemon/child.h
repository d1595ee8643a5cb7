/* SPDX-License-Identifier: MIT */
/* One child process of the supervisor: starting it, recording its end, and the time of the next
 * start. */
#ifndef PEN_CMD_DAEMON_CHILD_H
#define PEN_CMD_DAEMON_CHILD_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#include "cmd/daemon/config.h"
#include "store/store.h"

struct pen_child {
    const char *role;               /* "api" or "worker" */
    pid_t pid;                      /* 0: not running */
    int control_fd;                 /* -1: not running, or the child closed its end */
    bool ready;                     /* has sent "ready" since its start */
    bool answered;                  /* has answered the last "ping" */
    bool stopping;                  /* was sent "stop" */
    bool killed;                    /* by the supervisor */
    int64_t started_ns;             /* the last start */
    int64_t start_at_ns;            /* the next start, if it is not running */
    int failures;                   /* ends in a row, each soon after its start */
    char name[PEN_WORKER_ID_BYTES]; /* a worker's id in the store; "": the worker makes its own */
    char last_end[96];              /* "signal 11 (SIGSEGV)"; "": has not ended yet */
    int trace_fd;                   /* a worker's crash record (crash_record.h); -1: none */
    int64_t oom_kills;              /* pen_oom_kills at a worker's start */
    /* The last worker that ended with leases, until its successor has released them. name "":
     * none. */
    struct {
        char name[PEN_WORKER_ID_BYTES], how[96];
        enum pen_worker_end end;
        int trace_fd;
    } dead;
};

void pen_child_init(struct pen_child *child, const char *role);

/* Starts the program in this role. The child inherits listen_fd if that is not -1. A start that
 * fails counts as an end: the next one follows after a pause. */
void pen_child_start(struct pen_child *child, const struct pen_config *config, int listen_fd);

/* Notes that the child has sent "ready": a worker has released the leases of its predecessor. */
void pen_child_ready(struct pen_child *child);

/* The time from which on a running child has lived long enough not to be in a crash loop. Returns
 * INT64_MAX if it is not running or has no failures. */
int64_t pen_child_stable_at_ns(const struct pen_child *child);

/* Sets failures to 0 once that time has come. */
void pen_child_reset_failures(struct pen_child *child);

/* Records the end of the process with this wait status, logs it, and sets the time of the next
 * start: now, or after a pause that doubles with each end soon after a start. */
void pen_child_ended(struct pen_child *child, int wait_status);

#endif
