/* SPDX-License-Identifier: MIT */
/* The log: one line for each event on standard error, as text or JSON. Its settings, and the lines
 * that wait for its thread, are the library's only mutable global state.
 * Threads: all functions are thread-safe. */
#ifndef PEN_BASE_LOG_H
#define PEN_BASE_LOG_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum pen_log_level { PEN_LOG_DEBUG, PEN_LOG_INFO, PEN_LOG_WARN, PEN_LOG_ERROR };

/* Lines below this level are not written. Initially PEN_LOG_INFO. */
void pen_log_set_level(enum pen_log_level level);

/* Selects JSON lines instead of text. */
void pen_log_set_json(bool json);

/* Sets the name of this process in each line ("api", "worker"); at most 15 bytes are kept. */
void pen_log_set_name(const char *name);

/* A ring buffer of the last lines, including lines below the level. It may be in memory that is
 * shared with another process and outlives this one. Initially all zeros. */
enum { PEN_LOG_RING_BYTES = 8192 };
struct pen_log_ring {
    atomic_size_t written; /* atomic: relaxed. The number of bytes written so far; text has the last
                              of them */
    char text[PEN_LOG_RING_BYTES];
};

/* Copies every further line to the ring; NULL ends that.
 * Owns: the ring belongs to the caller. */
void pen_log_set_ring(struct pen_log_ring *ring);

/* Copies the last whole lines that fit into `bytes`, at most `lines` of them. */
void pen_log_ring_last(const struct pen_log_ring *ring, int lines, char *out, size_t bytes);

/* Starts a thread that writes the further lines of this process. Then logging never blocks, even if
 * no process reads standard error. Lines wait for the thread in 256 KiB of memory. Lines beyond
 * that are lost; when half of it is free, a line states their number. A process that ends without
 * pen_log_writer_stop loses the waiting lines. A forked process writes its lines itself.
 * Fails: returns false, and lines are written as before. */
bool pen_log_writer_start(void);

/* Ends the thread after it has written all lines. If that takes longer than a second, the thread is
 * left running.
 * Threads: only the one that started it. */
void pen_log_writer_stop(void);

/* Writes one line: time, level, process name, and the formatted message. */
void pen_log(enum pen_log_level level, const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The subject of a line. Unset fields are left out. Ids are left out if they are longer than 64
 * bytes or have characters other than letters, digits and `.`, `_`, `-`. */
struct pen_log_about {
    const char *job, *request; /* NULL: none */
    int64_t batch, attempt;    /* 0: none */
};

/* As pen_log, with these fields: `job=ID batch=N attempt=N request=ID` after the message, or
 * members of the JSON line. */
void pen_log_about(enum pen_log_level level, const struct pen_log_about *about, const char *format,
                   ...) __attribute__((format(printf, 3, 4)));

#endif
