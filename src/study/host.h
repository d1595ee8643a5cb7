/* SPDX-License-Identifier: MIT */
/* The host on which times are measured. A report describes it, so that times of different hosts or
 * builds are not confused. Also the processor time that a hypervisor gave to other machines. */
#ifndef PEN_STUDY_HOST_H
#define PEN_STUDY_HOST_H

#include <jansson.h>

/* The description of host and build in a report: the members of pen_figure_host, and
 *    name       of the machine in its network, from uname(2)
 *    id         of the machine: a hash of /etc/machine-id, which itself is not shown
 *    microcode  of the processor
 *    governor   of the processor's clock, such as "performance"
 *    kernel     the operating system's name and release
 *    compiler   that built this program
 *    build      the program's GNU build id, which changes with every change of its code
 * A text is "" if the system does not provide it.
 * Owns: the caller json_decref()s.
 * Fails: NULL when out of memory. */
json_t *pen_host_json(void);

/* The steal time of this machine since it booted, summed over its processors. In steal time a
 * processor is ready to run, but the hypervisor runs another machine. Returns -1 if the system does
 * not report it.
 * Units: ms, in steps of the kernel's clock tick, often 10 ms. */
double pen_host_steal_ms(void);

/* The number of processors that are online. pen_cpu_count may be smaller. */
int pen_host_processors(void);

#endif
