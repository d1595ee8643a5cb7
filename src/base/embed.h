/* SPDX-License-Identifier: MIT */
/* Files carried inside the programs: the tables are written by deploy/embed.sh at build time. */
#ifndef PEN_BASE_EMBED_H
#define PEN_BASE_EMBED_H

#include <stddef.h>

/* One file: its base name and its bytes (followed by a zero byte that `bytes` does not count). */
struct pen_embedded_file {
    const char *name;
    const unsigned char *data;
    size_t bytes;
};

/* scenes/ *.json, in order of name; the last entry has a null name. Part of libpenumbra.a. */
extern const struct pen_embedded_file pen_builtin_files[];

/* api/ *.yaml and *.json; the last entry has a null name. Not part of libpenumbra.a. */
extern const struct pen_embedded_file pen_api_files[];

#endif
