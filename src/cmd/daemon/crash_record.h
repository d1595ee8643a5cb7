/* SPDX-License-Identifier: MIT */
/* The worker's crash record (struct pen_trace) in a memory file. The supervisor creates it and the
 * worker writes it. The next worker reads it to report why its predecessor died. */
#ifndef PEN_CMD_DAEMON_CRASH_RECORD_H
#define PEN_CMD_DAEMON_CRASH_RECORD_H

#include "jobs/trace.h"

/* Makes a memory file for a record, all zeros. Returns its descriptor, or -1 on failure. Reports of
 * crashes then lack pixel and log lines. */
int pen_crash_record_new(void);

/* Maps the record into this process, until the process ends or unmaps it. All processes that map it
 * share it. Returns NULL if fd is -1 or cannot be mapped. */
struct pen_trace *pen_crash_record_map(int fd);
void pen_crash_record_unmap(struct pen_trace *trace); /* NULL: nothing */

/* Copies all further log lines to the record. Also installs signal handlers, which note there which
 * thread crashed. Handlers that are already installed stay. */
void pen_crash_record_install(struct pen_trace *trace);

#endif
