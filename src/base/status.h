/* SPDX-License-Identifier: MIT */
/* Errors. One type is used for the library's callers, the command line's message and exit code, the
 * HTTP problem document and the error stored with a job. A code has one name, one exit code and one
 * HTTP status, all in the table of src/base/status.c.
 *
 * Convention: a function that can fail takes `struct pen_status *st` last. On failure it fills *st
 * and returns false or NULL. On success it leaves *st unchanged. st is never NULL. */
#ifndef PEN_BASE_STATUS_H
#define PEN_BASE_STATUS_H

#include <stdarg.h>
#include <stdbool.h>
#include <stddef.h>

enum pen_code {
    PEN_OK = 0,
    PEN_USAGE,         /* a command line or query parameter is wrong */
    PEN_SYNTAX,        /* malformed JSON, duplicate key, number out of range: line and column */
    PEN_INVALID,       /* well-formed, but not a valid scene or job: JSON Pointer */
    PEN_UNSUPPORTED,   /* known, not supported yet: JSON Pointer */
    PEN_TOO_LARGE,     /* a limit on bytes, pixels or work is exceeded */
    PEN_UNAUTHORIZED,  /* no valid token */
    PEN_FORBIDDEN,     /* token lacks the scope; Host not allowed */
    PEN_NOT_FOUND,     /* no such job, view, scene, file, route */
    PEN_GONE,          /* the job was removed */
    PEN_METHOD,        /* the route does not have this HTTP method */
    PEN_CONFLICT,      /* the object's state does not allow the operation */
    PEN_LENGTH,        /* no Content-Length */
    PEN_MEDIA_TYPE,    /* a body or file of an unknown type */
    PEN_ACCEPT,        /* the object is available, but in none of the requested types */
    PEN_RANGE,         /* the requested range lies outside the object */
    PEN_QUOTA,         /* queue or client quota full */
    PEN_UNAVAILABLE,   /* not ready, draining, busy */
    PEN_STORAGE_FULL,  /* the store's disk is full */
    PEN_STORAGE,       /* the store failed: I/O error, corrupt */
    PEN_IO,            /* a file cannot be read or written */
    PEN_NETWORK,       /* a daemon cannot be reached, or its answer is malformed */
    PEN_NO_MEMORY,     /* an allocation or an arena's cap */
    PEN_STALE,         /* a commit without a valid lease: discard the result */
    PEN_CANCELLED,     /* stopped on request */
    PEN_TIMEOUT,       /* took longer than allowed */
    PEN_RENDER_FAILED, /* the job ended as failed or cancelled */
    PEN_DIFFERENT,     /* compared pictures or counts differ by more than allowed */
    PEN_INTERNAL,      /* a bug in Penumbra */
    PEN_CODE_COUNT
};

enum { PEN_AT_BYTES = 256, PEN_MSG_BYTES = 512, PEN_ERRORS_MAX = 20 };

/* An error. `at` is a JSON Pointer into the input, or empty. line and column count from 1, and are
 * 0 if they do not apply. msg is one sentence without a full stop, in UTF-8. */
struct pen_status {
    enum pen_code code;
    int line, column;
    char at[PEN_AT_BYTES];
    char msg[PEN_MSG_BYTES];
};

/* Several errors of one document. The first PEN_ERRORS_MAX are kept, and all are counted. */
struct pen_errors {
    size_t count; /* kept in item[] */
    size_t total; /* found */
    struct pen_status item[PEN_ERRORS_MAX];
};

/* Fills *st with a code and a formatted message, and clears at, line and column. Text that does not
 * fit is cut at a UTF-8 character boundary. Returns false, so that callers can return the call. */
bool pen_fail(struct pen_status *st, enum pen_code code, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* As pen_fail, with a JSON Pointer. A pointer too long for `at` is cut and ends in "…". */
bool pen_fail_at(struct pen_status *st, enum pen_code code, const char *at, const char *format, ...)
    __attribute__((format(printf, 4, 5)));

/* As pen_fail, with a position in a text. */
bool pen_fail_line(struct pen_status *st, enum pen_code code, int line, int column,
                   const char *format, ...) __attribute__((format(printf, 5, 6)));

/* Counts one error, and keeps it if the list is not full. */
void pen_errors_add(struct pen_errors *list, const struct pen_status *st);

/* The code's name as it appears in messages and problem types, e.g. "invalid-scene". */
const char *pen_code_name(enum pen_code code);

/* The code's short title for people, e.g. "Invalid scene". */
const char *pen_code_title(enum pen_code code);

/* The HTTP status of a response with this code. */
int pen_code_http(enum pen_code code);

/* The exit code of a command with this code (documented in api/command-line.md). */
int pen_code_exit(enum pen_code code);

/* The code with this name, or PEN_INTERNAL if there is none. */
enum pen_code pen_code_of_name(const char *name);

#endif
