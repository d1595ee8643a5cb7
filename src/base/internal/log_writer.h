/* SPDX-License-Identifier: MIT */
/* The thread that writes the lines of a process (pen_log_writer_start), and the lines that wait for
 * it: at most 256 KiB. Further lines are lost and counted.
 * Threads: any. */
#ifndef PEN_BASE_INTERNAL_LOG_WRITER_H
#define PEN_BASE_INTERNAL_LOG_WRITER_H

#include <stdbool.h>
#include <stddef.h>

enum { PEN_LOG_LINE_BYTES = 4096 }; /* of the longest line */

/* Passes a line to the thread, or counts it as lost. Returns false if this process has no such
 * thread; then the caller writes the line. */
bool pen_log_writer_take(const char *line, size_t bytes);

/* Writes lines to standard error. Blocks until standard error accepts them. */
void pen_log_write(const char *lines, size_t bytes);

#endif
