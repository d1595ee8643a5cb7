/* SPDX-License-Identifier: MIT */
/* Files that are compiled into the programs and libpenumbra. deploy/embed.sh writes the tables when
 * the project is built. */
#ifndef PEN_BASE_EMBED_H
#define PEN_BASE_EMBED_H

#include <stddef.h>

/* One file. A zero byte follows its data; `bytes` does not count it. */
struct pen_embedded_file {
    const char *name;
    const unsigned char *data;
    size_t bytes;
};

/* The scenes of scenes/ *.json in order of name, their names without ".json". The last entry's name
 * is NULL. Part of libpenumbra. */
extern const struct pen_embedded_file pen_builtin_files[];

/* The files api/ *.yaml and *.json. The last entry's name is NULL. Not part of libpenumbra. */
extern const struct pen_embedded_file pen_api_files[];

/* The files of the page at "/": all of api/page but the template of reports. As pen_api_files. */
extern const struct pen_embedded_file pen_page_files[];
/* The files api/page/report.*: the template of reports. Not part of libpenumbra. */
extern const struct pen_embedded_file pen_report_files[];

#endif
