/* SPDX-License-Identifier: MIT */
/* The kernel's count of processes that its OOM killer has ended, in the control group of this
 * process. Without a control group it is the count of the whole machine. */
#ifndef PEN_CMD_DAEMON_OOM_H
#define PEN_CMD_DAEMON_OOM_H

#include <stdint.h>

/* Returns the counter, which only grows; -1 if the kernel has none. Tests may set PENUMBRA_TEST_OOM
 * to a file to read it from instead. */
int64_t pen_oom_kills(void);

#endif
