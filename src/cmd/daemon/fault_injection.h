/* SPDX-License-Identifier: MIT */
/* For tests only: a renderer that fails at one pixel. What to do is a text, KIND@X,Y or
 * KIND@X,Y@NAME (only in jobs of that name), which the daemon's worker takes from
 * PENUMBRA_TEST_FAULT. Without it nothing here is ever called.
 *
 *   segv    writes through a null pointer
 *   abort   calls abort
 *   exit    ends the process with code 1
 *   kill    ends the process by SIGKILL, as the kernel does when memory runs out
 *   alloc   takes memory until there is none
 *   hang    never comes back */
#ifndef PEN_CMD_DAEMON_FAULT_INJECTION_H
#define PEN_CMD_DAEMON_FAULT_INJECTION_H

#include "jobs/worker.h"

struct pen_fault_hook {
    struct pen_worker_fault calls; /* of this hook, which must stay where it is */
    int kind, x, y;
    const char *name; /* within the text; NULL: any job */
};

/* Fails: PEN_USAGE. */
bool pen_fault_parse(const char *text, struct pen_fault_hook *hook, struct pen_status *st);

#endif
