/* SPDX-License-Identifier: MIT */
/* One child process of the supervisor: starting it, recording its end, and the time of its next
 * start.
 *
 * The supervisor counts ends in a row. The count begins again when a process has lived for some
 * time, or when a worker has finished a batch as it should. An end that the process itself has not
 * caused does not count:
 *   - A worker's crash over a job is charged to that job (src/store/README.md). It counts once for
 *     each job. A job that crashes each worker is itself at fault, but a worker that crashes over
 *     one job after another is not sound.
 *   - A worker may end itself because its render threads do not stop after their job has ended. */
#ifndef PEN_CMD_DAEMON_CHILD_H
#define PEN_CMD_DAEMON_CHILD_H

#include <stdbool.h>
#include <stdint.h>
#include <sys/types.h>

#include "cmd/daemon/config.h"
#include "jobs/trace.h"
#include "store/store.h"

enum { PEN_CHILD_BLAMED = 8 };

struct pen_child {
    const char *role;    /* "api" or "worker" */
    pid_t pid;           /* 0: not running */
    int control_fd;      /* -1: not running, or the child closed its end */
    bool ready;          /* has sent "ready" since its start */
    bool answered;       /* has answered the last "ping" */
    bool stopping;       /* was sent "stop" */
    bool killed;         /* by the supervisor */
    int64_t started_ns;  /* the last start */
    int64_t start_at_ns; /* the next start, if it is not running; INT64_MAX: never */
    int failures;        /* ends in a row that count, see above */
    char blamed[PEN_CHILD_BLAMED][PEN_ID_BYTES]; /* the last jobs whose crashes have counted */
    int blamed_count;                            /* crashes of different jobs that have counted */
    char name[PEN_WORKER_ID_BYTES];              /* a worker's id in the store; "": it is an api */
    char last_end[96];                           /* "signal 11 (SIGSEGV)"; "": has not ended yet */
    char fault[PEN_MSG_BYTES]; /* the I/O error for which a process has ended, until its successor
                                  works; "": none */
    bool has_fault;            /* the fault is of this process, not of its predecessor */
    int signal_slot;           /* see pen_store_signals_join */
    int trace_fd;              /* a worker's crash record (crash_record.h); -1: none */
    struct pen_trace *trace;   /* the same, mapped; NULL: none */
    int64_t oom_kills;         /* pen_oom_kills at a worker's start */
    /* The last worker that ended with leases, until its successor has released them; name "":
     * none. */
    struct {
        char name[PEN_WORKER_ID_BYTES], how[96];
        enum pen_worker_end end;
        int trace_fd;
    } dead;
};

/* Initialises a child. `wanted`: the supervisor's role has such a child; else it is never
 * started. */
void pen_child_init(struct pen_child *child, const char *role, int signal_slot, bool wanted);

/* Starts the program in this role with this configuration. The child inherits listen_fd if that is
 * not -1. A failed start counts as an end, so the next start follows after a pause. */
void pen_child_start(struct pen_child *child, const struct pen_config *config, int listen_fd);

/* Notes that the child has sent "ready". A worker has then released the leases of its
 * predecessor. */
void pen_child_ready(struct pen_child *child);

/* Notes that the child ends because of an I/O error of the store. */
void pen_child_fault(struct pen_child *child, const char *why);

/* Returns when to call pen_child_reset_failures next; INT64_MAX if the child is not running or has
 * no failures. */
int64_t pen_child_check_at_ns(const struct pen_child *child);

/* Sets failures to 0 and forgets the fault, if the child has lived long enough or done enough not
 * to be in a crash loop. */
void pen_child_reset_failures(struct pen_child *child);

/* Records and logs the end of the process with this wait status, and sets the time of the next
 * start. It is now, or after a pause that doubles with each end that counts. */
void pen_child_ended(struct pen_child *child, int wait_status);

#endif
