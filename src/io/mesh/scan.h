/* SPDX-License-Identifier: MIT */
/* Reading tokens and numbers of a model file from memory, and errors with their places. */
#ifndef PEN_IO_MESH_SCAN_H
#define PEN_IO_MESH_SCAN_H

#include <stdint.h>
#include <string.h>

#include "io/error/text.h"

struct pen_scan {
    const char *begin, *at, *end;
    bool binary; /* errors give the byte's offset, not line and column */
    struct pen_status *st;
};

/* A number of a file: its nearest double and its nearest float. */
struct pen_number {
    double d;
    float f;
};

/* Fails with the place of `at`. Returns false. */
bool pen_scan_fail(const struct pen_scan *s, enum pen_code code, const char *at, const char *format,
                   ...) __attribute__((format(printf, 4, 5)));

/* The token at `at` in quotes, or "the end of the file". */
struct pen_text pen_scan_found(const struct pen_scan *s, const char *at);

static inline bool pen_is_space(char c)
{
    return c == ' ' || (c >= '\t' && c <= '\r');
}

/* Moves over white space and line ends. Returns false at the end. */
static inline bool pen_scan_space(struct pen_scan *s)
{
    while (s->at < s->end && pen_is_space(*s->at))
        s->at++;
    return s->at < s->end;
}

/* Moves over blanks, and over line ends after a backslash. Returns false at the end of the
 * statement: a line end, a comment or the end. */
bool pen_scan_more(struct pen_scan *s);

/* Moves behind the line end of the statement. */
void pen_scan_next_line(struct pen_scan *s);

/* Moves to the next statement and behind its first word. Returns false at the end. */
bool pen_scan_statement(struct pen_scan *s, const char **word, size_t *length);

/* The rest of the line without blanks around it, which becomes empty at the line's end. */
size_t pen_scan_rest(struct pen_scan *s, const char **text);

/* Reads the word at the place, up to white space, and moves behind it. */
size_t pen_scan_word(struct pen_scan *s, const char **word);

static inline bool pen_word_is(const char *word, size_t length, const char *name)
{
    return strlen(name) == length && memcmp(word, name, length) == 0;
}

/* Reads the decimal number at the place and moves behind it. A word that is no finite decimal
 * number, or is too large for a float, is an error. */
bool pen_scan_number(struct pen_scan *s, struct pen_number *out);

#endif
