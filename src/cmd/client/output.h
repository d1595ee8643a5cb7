/* SPDX-License-Identifier: MIT */
/* The formats of pictures and reports: their names, the format of an output by its name, and
 * encoding a picture. */
#ifndef PEN_CMD_CLIENT_OUTPUT_H
#define PEN_CMD_CLIENT_OUTPUT_H

#include <stdbool.h>

#include "base/buf.h"
#include "base/status.h"
#include "cmd/options.h"
#include "film/encode.h"
#include "film/film.h"
#include "scene/settings.h"

/* The choices of --format; each list ends with NULL. */
extern const char *const pen_output_formats[];     /* of pictures */
extern const char *const pen_output_all_formats[]; /* of pictures and reports */

/* Returns the format of a picture, "png", "png16" or "pfm". It is `format`; if that is NULL, `path`
 * ends in it. For "-", standard output, PNG is the default.
 * Fails: NULL and PEN_USAGE, also for the format of a report. */
const char *pen_output_format(const char *path, const char *format, struct pen_status *st);

/* Returns the format of a report in the same way: "json", "csv", "md" or "html".
 * Fails: NULL and PEN_USAGE, also for the format of a picture. */
const char *pen_output_report_format(const char *path, const char *format, struct pen_status *st);

/* Returns true if one of the outputs is "-", standard output. */
bool pen_output_is_standard(const struct pen_option_list *outputs);

/* A picture file whose rows are encoded as they are finished. The bytes are appended to `out`. The
 * film and `out` must live until pen_output_release. */
struct pen_output {
    const struct pen_film *film;
    struct pen_buf *out;
    struct pen_png_writer *png; /* NULL for PFM, whose first row is the bottom row */
};

/* Begins a file; `format` is one of pen_output_formats.
 * Owns: release *output with pen_output_release.
 * Fails: PEN_NO_MEMORY. */
bool pen_output_begin(struct pen_output *output, const char *format, const struct pen_film *film,
                      const struct pen_settings *settings, struct pen_buf *out,
                      struct pen_status *st);

/* rows_done of a pen_render_task, whose rows_user is the output. */
void pen_output_rows(void *output, int rows);

/* Encodes the rest of the file.
 * Fails: as pen_png_end. */
bool pen_output_end(struct pen_output *output, struct pen_status *st);
void pen_output_release(struct pen_output *output);

/* Returns the values of one pixel of the film in the 8-bit and 16-bit formats. */
void pen_output_pixel(const float rgb[3], const struct pen_settings *settings, int png8[3],
                      int png16[3]);

#endif
