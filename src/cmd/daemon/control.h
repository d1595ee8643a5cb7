/* SPDX-License-Identifier: MIT */
/* Between the supervisor and a child: a socket pair carrying short texts, and the end of which
 * tells either side that the other is gone. A process waits for such texts and for its signals in
 * one place, pen_event_source_next.
 *
 *   supervisor to child:  "drain"                   take no new jobs, answer everything else
 *                         "stop"                    finish or give back what is in hand, and end
 *                         "log LEVEL FORMAT FILE"   open the log anew, FILE may be empty
 *                         "state TEXT"              (api) why the daemon is not ready, or nothing
 *   child to supervisor:  "ready"                   works; leases of its predecessor are swept */
#ifndef PEN_CMD_DAEMON_CONTROL_H
#define PEN_CMD_DAEMON_CONTROL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum { PEN_CONTROL_BYTES = 1024 };

/* Sends one text. A full or broken channel loses it: what matters is sent again or is noticed by
 * the end of the process. fd -1 is allowed. */
void pen_control_send(int fd, const char *text);

enum pen_event_kind {
    PEN_EVENT_TIMEOUT,
    PEN_EVENT_STOP,    /* SIGTERM, SIGINT, or "stop" */
    PEN_EVENT_DRAIN,   /* "drain" */
    PEN_EVENT_LOG,     /* "log …": text is what follows; SIGHUP: text is empty */
    PEN_EVENT_STATE,   /* "state …": text is what follows */
    PEN_EVENT_LOST,    /* the supervisor is gone */
    PEN_EVENT_WORK_END /* the worker's thread has ended */
};

struct pen_event {
    enum pen_event_kind kind;
    char text[PEN_CONTROL_BYTES];
};

/* What a child process waits for. */
struct pen_event_source {
    int signal_fd, control_fd, end_fd; /* -1: none */
    bool supervised;
};

/* Blocks the signals it will report, for this thread and those started later. A supervised
 * process ignores SIGINT: the terminal sends it to all, and the supervisor decides.
 * Fails: PEN_IO. */
bool pen_event_source_open(struct pen_event_source *watch, int control_fd, struct pen_status *st);
void pen_event_source_close(struct pen_event_source *watch);

/* Lets another thread end the waiting. Threads: any. */
void pen_event_source_work_ended(const struct pen_event_source *watch);

/* Waits for the next event, at most timeout_ms (-1: as long as it takes). */
void pen_event_source_next(struct pen_event_source *watch, int timeout_ms, struct pen_event *event);

#endif
