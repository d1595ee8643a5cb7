/* SPDX-License-Identifier: MIT */
/* The tables of a store: schema.sql, which the build embeds. */
#ifndef PEN_STORE_INTERNAL_SCHEMA_H
#define PEN_STORE_INTERNAL_SCHEMA_H

#include "base/embed.h"

/* Grows with every change of schema.sql. A build opens only stores of its own version. */
enum { PEN_SCHEMA_VERSION = 19 };

struct pen_buf;

/* A word in braces in schema.sql, and an engine's text for it. */
struct pen_word {
    const char *word, *text;
};

/* Appends the tables, with an engine's words. `words` ends with a NULL word. */
void pen_schema_write(const struct pen_word *words, struct pen_buf *out);

extern const struct pen_embedded_file pen_store_schema[];

#endif
