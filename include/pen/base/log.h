/* SPDX-License-Identifier: MIT */
/* The log: one line per event on standard error, text or JSON lines, one write() each.
 * Its settings are the one mutable global of the library. Threads: all functions are thread-safe.
 */
#ifndef PEN_BASE_LOG_H
#define PEN_BASE_LOG_H

#include <stdbool.h>

enum pen_log_level { PEN_LOG_DEBUG, PEN_LOG_INFO, PEN_LOG_WARN, PEN_LOG_ERROR };

/* Lines below this level are dropped; PEN_LOG_INFO at start. */
void pen_log_set_level(enum pen_log_level level);

/* JSON lines instead of text. */
void pen_log_set_json(bool json);

/* A name for this process, shown in each line ("api", "worker"); at most 15 bytes are kept. */
void pen_log_set_name(const char *name);

/* Writes one line: time, level, process name, and the formatted message. */
void pen_log(enum pen_log_level level, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

#endif
