/* SPDX-License-Identifier: MIT */
/* The worker's crash record (struct pen_trace) in a memory file: the supervisor creates it, the
 * worker writes it, and the next worker reads it to report why its predecessor died. */
#ifndef PEN_CMD_DAEMON_CRASH_RECORD_H
#define PEN_CMD_DAEMON_CRASH_RECORD_H

#include "jobs/trace.h"

/* Makes one, all zeros. Returns -1 if there can be none: then less will be known. */
int pen_crash_record_new(void);

/* The trace behind a descriptor, shared with all who have it, until the process ends; NULL if fd is
 * -1 or cannot be mapped. */
struct pen_trace *pen_crash_record_map(int fd);

/* From now on the log goes there too, and a crash of this process is noted in it. Handlers that
 * somebody else has installed stay. */
void pen_crash_record_install(struct pen_trace *trace);

#endif
