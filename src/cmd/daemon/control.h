/* SPDX-License-Identifier: MIT */
/* The control channel between the supervisor and a child: a socket pair for short texts. When one
 * process ends, the other sees the channel closed. A terminal and systemd send SIGTERM, SIGINT and
 * SIGHUP to all processes. A child has them blocked, because its supervisor handles them. So the
 * api answers until the worker has ended.
 *
 *   supervisor to child:  "drain"                   take no new jobs, answer all other requests
 *                         "stop"                    finish the batch or give it back, and end
 *                         "log LEVEL FORMAT FILE"   open the log again; FILE may be empty
 *                         "state TEXT"              (api) why the daemon is not ready; "": it is
 *                         "ping"                    answer "pong", if events are handled
 *   child to supervisor:  "pong"
 *                         "ready"                   it works; a worker has released the leases of
 *                                                   its predecessor
 *                         "fault TEXT"              it ends, because its store has this I/O error
 *                         "idle"                    (worker) it ends, because it found no work for
 *                                                   the time of --until-idle */
#ifndef PEN_CMD_DAEMON_CONTROL_H
#define PEN_CMD_DAEMON_CONTROL_H

#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum { PEN_CONTROL_BYTES = 1024 };

/* Sends one text; does nothing if fd is -1. A full or broken channel loses the text. This does no
 * harm: the channel is full only if the other process hangs, and a drain kills such a child. */
void pen_control_send(int fd, const char *text);

enum pen_event_kind {
    PEN_EVENT_TIMEOUT,
    PEN_EVENT_STOP,    /* "stop" */
    PEN_EVENT_DRAIN,   /* "drain" */
    PEN_EVENT_LOG,     /* "log TEXT" */
    PEN_EVENT_STATE,   /* "state TEXT" */
    PEN_EVENT_LOST,    /* the supervisor has ended */
    PEN_EVENT_WORK_END /* pen_event_source_work_ended was called */
};

struct pen_event {
    enum pen_event_kind kind;
    char text[PEN_CONTROL_BYTES];
};

/* The descriptors that a child process waits for. */
struct pen_event_source {
    int control_fd, end_fd; /* -1: none */
};

/* Opens the descriptors.
 * Owns: control_fd.
 * Fails: PEN_IO. */
bool pen_event_source_open(struct pen_event_source *source, int control_fd, struct pen_status *st);
void pen_event_source_close(struct pen_event_source *source);

/* Makes pen_event_source_next return PEN_EVENT_WORK_END. Threads: any. */
void pen_event_source_work_ended(const struct pen_event_source *source);

/* Waits for the next event, at most timeout_ms (-1: without limit). */
void pen_event_source_next(struct pen_event_source *source, int timeout_ms,
                           struct pen_event *event);

#endif
