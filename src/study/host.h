/* SPDX-License-Identifier: MIT */
/* The host on which times are measured: what a report says of it, so that times of different hosts
 * or builds are told apart, and the time that a hypervisor gave to others. */
#ifndef PEN_STUDY_HOST_H
#define PEN_STUDY_HOST_H

#include <jansson.h>

/* What a report says of host and build: the members of pen_figure_host, and
 *   name       of the machine in its network, as uname(2) tells it
 *   id         of the machine: a hash of /etc/machine-id, which is not told
 *   microcode  of the processor
 *   governor   of its clock, such as "performance"
 *   kernel     the operating system's name and release
 *   compiler   that made this program
 *   build      the program's GNU build id, which changes with every change of its code
 * A text is "" where the system does not tell. Owns: the caller json_decref()s. Fails: NULL when
 * out of memory. */
json_t *pen_host_json(void);

/* The time that the processors of this machine were ready to run and a hypervisor ran others,
 * since the machine began. Units: ms, in steps of the kernel's clock tick, often 10 ms. Returns -1
 * where the system does not tell. */
double pen_host_steal_ms(void);

/* How many processors the machine has; pen_cpu_count may be fewer. */
int pen_host_processors(void);

#endif
