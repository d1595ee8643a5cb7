/* SPDX-License-Identifier: MIT */
/* The table of error codes, and the functions that fill a status. Names and exit codes are part of
 * the public interface (problem types, scripts): new ones may be added, none may change. */
#include "base/status.h"

#include <stdio.h>
#include <string.h>

#include "base/utf8.h"

/* Exit codes. The comments state what a script can do. */
enum {
    EXIT_OK = 0,
    EXIT_USAGE = 2,       /* correct the command */
    EXIT_INPUT = 3,       /* correct the scene, the job or the file */
    EXIT_STATE = 4,       /* the object does not exist, or its state does not allow this */
    EXIT_NETWORK = 5,     /* try again later, or check the daemon */
    EXIT_JOB = 6,         /* the job failed or was cancelled */
    EXIT_DIFFERENT = 7,   /* compared pictures differ */
    EXIT_STORAGE = 8,     /* check the disk */
    EXIT_MEMORY = 9,      /* provide more memory */
    EXIT_TIME = 10,       /* allow more time */
    EXIT_PERMISSION = 11, /* get a token */
    EXIT_BUG = 70         /* report it; EX_SOFTWARE of sysexits.h */
};

struct code_row {
    const char *name, *title;
    int http, exit;
};

static const struct code_row table[PEN_CODE_COUNT] = {
    [PEN_OK] = {"ok", "OK", 200, EXIT_OK},
    [PEN_USAGE] = {"usage", "Wrong parameter", 400, EXIT_USAGE},
    [PEN_SYNTAX] = {"syntax", "Malformed input", 400, EXIT_INPUT},
    [PEN_INVALID] = {"invalid-scene", "Invalid scene", 422, EXIT_INPUT},
    [PEN_UNSUPPORTED] = {"unsupported", "Not supported yet", 422, EXIT_INPUT},
    [PEN_TOO_LARGE] = {"too-large", "Too large", 413, EXIT_INPUT},
    [PEN_UNAUTHORIZED] = {"unauthorized", "Token needed", 401, EXIT_PERMISSION},
    [PEN_FORBIDDEN] = {"forbidden", "Not allowed", 403, EXIT_PERMISSION},
    [PEN_NOT_FOUND] = {"not-found", "Not found", 404, EXIT_STATE},
    [PEN_GONE] = {"gone", "Removed", 410, EXIT_STATE},
    [PEN_METHOD] = {"method-not-allowed", "Method not allowed", 405, EXIT_USAGE},
    [PEN_CONFLICT] = {"conflict", "Wrong state", 409, EXIT_STATE},
    [PEN_LENGTH] = {"length-required", "Length required", 411, EXIT_INPUT},
    [PEN_MEDIA_TYPE] = {"media-type", "Unsupported media type", 415, EXIT_INPUT},
    [PEN_ACCEPT] = {"not-acceptable", "Not acceptable", 406, EXIT_USAGE},
    [PEN_RANGE] = {"range", "Range not satisfiable", 416, EXIT_USAGE},
    [PEN_QUOTA] = {"quota", "Quota exceeded", 429, EXIT_NETWORK},
    [PEN_UNAVAILABLE] = {"unavailable", "Not ready", 503, EXIT_NETWORK},
    [PEN_STORAGE_FULL] = {"storage-full", "Storage full", 507, EXIT_STORAGE},
    [PEN_STORAGE] = {"storage", "Storage failed", 503, EXIT_STORAGE},
    [PEN_IO] = {"io", "Input or output failed", 500, EXIT_STORAGE},
    [PEN_NETWORK] = {"network", "Daemon out of reach", 502, EXIT_NETWORK},
    [PEN_NO_MEMORY] = {"no-memory", "Out of memory", 503, EXIT_MEMORY},
    [PEN_STALE] = {"stale", "Lease lost", 409, EXIT_STATE},
    [PEN_CANCELLED] = {"cancelled", "Cancelled", 409, EXIT_JOB},
    [PEN_TIMEOUT] = {"timeout", "Timed out", 504, EXIT_TIME},
    [PEN_RENDER_FAILED] = {"job-failed", "Job failed", 409, EXIT_JOB},
    [PEN_DIFFERENT] = {"different", "Pictures differ", 409, EXIT_DIFFERENT},
    [PEN_INTERNAL] = {"internal", "Internal error", 500, EXIT_BUG},
};

static const struct code_row *row(enum pen_code code)
{
    return (unsigned)code < PEN_CODE_COUNT ? &table[code] : &table[PEN_INTERNAL];
}

/* The arguments may point into *st, so the text is formatted before *st is written. */
static void fill(struct pen_status *st, enum pen_code code, const char *format, va_list args)
{
    char text[2 * PEN_MSG_BYTES];
    if (vsnprintf(text, sizeof text, format, args) < 0)
        text[0] = '\0';
    st->code = code;
    st->line = st->column = 0;
    st->at[0] = '\0';
    pen_utf8_copy(st->msg, sizeof st->msg, text);
}

bool pen_fail(struct pen_status *st, enum pen_code code, const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fill(st, code, format, args);
    va_end(args);
    return false;
}

bool pen_fail_at(struct pen_status *st, enum pen_code code, const char *at, const char *format, ...)
{
    static const char more[] = "\xE2\x80\xA6";
    char pointer[PEN_AT_BYTES];
    if (!pen_utf8_copy(pointer, sizeof pointer, at)) {
        pen_utf8_copy(pointer, sizeof pointer - (sizeof more - 1), at);
        strcat(pointer, more);
    }
    va_list args;
    va_start(args, format);
    fill(st, code, format, args);
    va_end(args);
    memcpy(st->at, pointer, sizeof pointer);
    return false;
}

bool pen_fail_line(struct pen_status *st, enum pen_code code, int line, int column,
                   const char *format, ...)
{
    va_list args;
    va_start(args, format);
    fill(st, code, format, args);
    va_end(args);
    st->line = line;
    st->column = column;
    return false;
}

void pen_errors_add(struct pen_errors *list, const struct pen_status *st)
{
    if (list->count < PEN_ERRORS_MAX)
        list->item[list->count++] = *st;
    list->total++;
}

const char *pen_code_name(enum pen_code code)
{
    return row(code)->name;
}

const char *pen_code_title(enum pen_code code)
{
    return row(code)->title;
}

int pen_code_http(enum pen_code code)
{
    return row(code)->http;
}

int pen_code_exit(enum pen_code code)
{
    return row(code)->exit;
}

enum pen_code pen_code_of_name(const char *name)
{
    for (int code = 0; code < PEN_CODE_COUNT; code++) {
        if (strcmp(table[code].name, name) == 0)
            return (enum pen_code)code;
    }
    return PEN_INTERNAL;
}
