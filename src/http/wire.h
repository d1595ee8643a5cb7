/* SPDX-License-Identifier: MIT */
/* HTTP/1.1 as bytes: the head of a request, and a body in chunks. Pure functions over what a client
 * sent, which trust none of it.
 *
 * Both readers are strict. Two programs that read one request differently can be played off against
 * each other, so whatever could be read in two ways is refused: a line that ends without CR, a line
 * that continues the one before, a space before a colon, a control character in a field.
 * Source: RFC 9112. */
#ifndef PEN_HTTP_WIRE_H
#define PEN_HTTP_WIRE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

enum { PEN_HEAD_BYTES = 32 << 10, PEN_HEAD_FIELDS = 100, PEN_TRAILER_BYTES = 8 << 10 };

/* How far a text has been searched for the end of a head; {0} is its beginning, {.begun = true}
 * that of a trailer, which has no request line and may be an empty line alone. */
struct pen_head_scan {
    size_t line, at; /* where the current line begins; the first byte that was not looked at */
    bool begun;      /* a line that is not empty was seen */
};

enum pen_head_found {
    PEN_HEAD_PART,  /* the head goes on */
    PEN_HEAD_WHOLE, /* *head_bytes is its length, with the empty line at its end */
    PEN_HEAD_BAD    /* a line ends in LF alone */
};

/* Looks for the end of a head at the beginning of a text, from where the last call ended. Empty
 * lines before the request line belong to the head. */
enum pen_head_found pen_head_find(const char *text, size_t bytes, struct pen_head_scan *scan,
                                  size_t *head_bytes);

/* Whether a head that pen_head_find has found says something of a body, also one that is malformed
 * and cannot be parsed. */
bool pen_head_announces_body(const char *text, size_t bytes);

struct pen_head_field {
    const char *name, *value; /* the value without spaces and tabs around it */
};

struct pen_head {
    const char *method, *target;
    int minor; /* of the version: HTTP/1.minor, 0 or 1 */
    int field_count;
    struct pen_head_field field[PEN_HEAD_FIELDS];
};

/* Parses a head that pen_head_find has found. The text is changed, and *head points into it.
 * Returns 0, or the status to answer with: 400, 431 (too many fields), 505 (version); *st then says
 * why. */
int pen_head_parse(char *text, size_t bytes, struct pen_head *head, struct pen_status *st);

/* Checks a trailer that pen_head_find has found: its fields are read as strictly as those of a
 * head, and none may say how long the body is. They are not kept. `bytes` is PEN_TRAILER_BYTES at
 * most. Returns 0, or the status to answer with, as pen_head_parse. */
int pen_trailer_check(const char *text, size_t bytes, struct pen_status *st);

/* Whether a list of tokens, separated by commas, has this one; upper and lower case are the same.
 */
bool pen_list_has_token(const char *list, const char *token);

/* The decoder of a body in chunks; {0} is its beginning. */
struct pen_chunks {
    enum {
        PEN_CHUNKS_SIZE,   /* in the line with a chunk's size */
        PEN_CHUNKS_DATA,   /* in a chunk */
        PEN_CHUNKS_END,    /* in the line end after a chunk */
        PEN_CHUNKS_TRAILER /* after the line of the last chunk: the trailer follows */
    } state;
    uint64_t left;                     /* bytes of the chunk that have not been read */
    unsigned line;                     /* bytes of the current line */
    bool digits, space, extension, cr; /* what the line with the size has had */
};

/* Reads the next bytes of a body: at most one piece of a chunk, which *data and *data_bytes become
 * (0 bytes: only framing was read). Returns the number of bytes read, which is 0 once the state is
 * PEN_CHUNKS_TRAILER; -1 if the framing is wrong. */
ptrdiff_t pen_chunks_read(struct pen_chunks *chunks, const char *text, size_t bytes,
                          const char **data, size_t *data_bytes);

#endif
