/* SPDX-License-Identifier: MIT */
/* Whether the kernel has ended processes for want of memory: its own counter, of the control group
 * this process is in or, where there is none, of the whole machine. */
#ifndef PEN_CMD_DAEMON_OOM_H
#define PEN_CMD_DAEMON_OOM_H

#include <stdint.h>

/* The counter now; -1 where the kernel has none. It only grows. For tests, PENUMBRA_TEST_OOM names
 * a file to read it from instead. */
int64_t pen_oom_kills(void);

#endif
