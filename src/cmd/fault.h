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
#ifndef CMD_FAULT_H
#define CMD_FAULT_H

#include <stdbool.h>

#include "pen/base/status.h"

struct pen_fault {
    int kind, x, y;
    const char *name; /* within the text; NULL: any job */
};

/* Fails: PEN_USAGE. */
bool pen_fault_parse(const char *text, struct pen_fault *fault, struct pen_status *st);

/* Whether jobs of this name (NULL: none) are meant. */
bool pen_fault_applies(const struct pen_fault *fault, const char *job_name);

/* Does what is to be done at this pixel. Returns false when memory ran out. */
bool pen_fault_at(const struct pen_fault *fault, int x, int y);

#endif
