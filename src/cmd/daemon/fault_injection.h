/* SPDX-License-Identifier: MIT */
/* For tests only: makes rendering fail at one pixel. The environment variable PENUMBRA_TEST_FAULT
 * of the daemon's worker is KIND@X,Y, or KIND@X,Y@NAME for jobs of that name alone. Without it no
 * function here is called.
 *
 *   segv    writes through a null pointer
 *   abort   calls abort
 *   exit    ends the process with code 1
 *   kill    ends the process by SIGKILL, as the kernel does when memory runs out
 *   alloc   takes all memory
 *   hang    never returns */
#ifndef PEN_CMD_DAEMON_FAULT_INJECTION_H
#define PEN_CMD_DAEMON_FAULT_INJECTION_H

#include "jobs/worker.h"

struct pen_fault_hook {
    struct pen_worker_fault calls; /* their user is this hook, so it must not move */
    int kind, x, y;
    const char *name; /* of the job, within the text; NULL: any job */
};

/* Reads the text of PENUMBRA_TEST_FAULT.
 * Fails: PEN_USAGE. */
bool pen_fault_parse(const char *text, struct pen_fault_hook *hook, struct pen_status *st);

#endif
