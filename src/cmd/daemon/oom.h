/* SPDX-License-Identifier: MIT */
/* The kernel's count of processes that its OOM killer has ended: in the control group of this
 * process or, without one, on the whole machine. */
#ifndef PEN_CMD_DAEMON_OOM_H
#define PEN_CMD_DAEMON_OOM_H

#include <stdint.h>

/* The counter now, which only grows; -1 if the kernel has none. For tests, PENUMBRA_TEST_OOM names
 * a file to read it from instead. */
int64_t pen_oom_kills(void);

#endif
