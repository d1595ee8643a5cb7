/* SPDX-License-Identifier: MIT */
/* Files that are compiled into the programs and libpenumbra: deploy/embed.sh writes the tables at
 * build time. */
#ifndef PEN_BASE_EMBED_H
#define PEN_BASE_EMBED_H

#include <stddef.h>

/* One file: its name and its bytes, which a zero byte follows that `bytes` does not count. */
struct pen_embedded_file {
    const char *name;
    const unsigned char *data;
    size_t bytes;
};

/* The scenes of scenes/ *.json in order of name, without ".json"; the last entry has a null name.
 * Part of libpenumbra. */
extern const struct pen_embedded_file pen_builtin_files[];

/* The files api/ *.yaml and *.json; the last entry has a null name. Not part of libpenumbra. */
extern const struct pen_embedded_file pen_api_files[];

#endif
