/* SPDX-License-Identifier: MIT */
/* The worker's crash record (struct pen_trace) in a memory file: the supervisor creates it, the
 * worker writes it, and the next worker reads it to report why its predecessor died. */
#ifndef PEN_CMD_DAEMON_CRASH_RECORD_H
#define PEN_CMD_DAEMON_CRASH_RECORD_H

#include "jobs/trace.h"

/* Makes a memory file for a record, all zeros. Returns its descriptor, or -1 on failure: then
 * reports of crashes lack pixel and log lines. */
int pen_crash_record_new(void);

/* Maps the record into this process, shared with all processes that map it, until the process ends
 * or unmaps it. Returns NULL if fd is -1 or cannot be mapped. */
struct pen_trace *pen_crash_record_map(int fd);
void pen_crash_record_unmap(struct pen_trace *trace); /* NULL: nothing */

/* Copies all further log lines to the record, and installs signal handlers that note in it which
 * thread crashed. Handlers that are already installed stay. */
void pen_crash_record_install(struct pen_trace *trace);

#endif
