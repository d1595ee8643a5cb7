/* SPDX-License-Identifier: MIT */
/* The log: one line per event on standard error, text or JSON lines, one write() each.
 * Its settings are the one mutable global of the library. Threads: all functions are thread-safe.
 */
#ifndef PEN_BASE_LOG_H
#define PEN_BASE_LOG_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum pen_log_level { PEN_LOG_DEBUG, PEN_LOG_INFO, PEN_LOG_WARN, PEN_LOG_ERROR };

/* Lines below this level are dropped; PEN_LOG_INFO at start. */
void pen_log_set_level(enum pen_log_level level);

/* JSON lines instead of text. */
void pen_log_set_json(bool json);

/* A name for this process, shown in each line ("api", "worker"); at most 15 bytes are kept. */
void pen_log_set_name(const char *name);

/* The last lines of a log, in memory that may be shared with another process and outlive this one;
 * all zeros at first. Lines that level suppresses are kept too. */
enum { PEN_LOG_RING_BYTES = 8192 };
struct pen_log_ring {
    atomic_size_t written; /* atomic: relaxed; bytes so far, the last of them are in text */
    char text[PEN_LOG_RING_BYTES];
};

/* Copies every line there from now on; NULL ends that. Owns: the ring stays the caller's. */
void pen_log_set_ring(struct pen_log_ring *ring);

/* Copies the last whole lines, `lines` at most, as far as `bytes` go. */
void pen_log_ring_last(const struct pen_log_ring *ring, int lines, char *out, size_t bytes);

/* Writes one line: time, level, process name, and the formatted message. */
void pen_log(enum pen_log_level level, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* What a line is about; what is unset is left out. Ids are of letters, digits and `.`, `_`, `-`,
 * 64 bytes at most: others are left out too. */
struct pen_log_about {
    const char *job, *request; /* NULL: none */
    int64_t batch, attempt;    /* 0: none */
};

/* As pen_log, with these as fields: `job=ID batch=N attempt=N request=ID` after the message, or
 * members of the JSON line. */
void pen_log_about(enum pen_log_level level, const struct pen_log_about *about, const char *format,
                   ...) __attribute__((format(printf, 3, 4)));

#endif
