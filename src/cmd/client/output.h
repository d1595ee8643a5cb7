/* SPDX-License-Identifier: MIT */
/* The formats of pictures and reports: their names, how an output's name gives its format, and
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

/* The choices of --format; NULL ends each. */
extern const char *const pen_output_formats[];     /* of pictures */
extern const char *const pen_output_all_formats[]; /* of pictures and reports */

/* The format of a picture: `format`, or if that is NULL the one that `path` ends in; PNG for "-",
 * standard output. Returns "png", "png16" or "pfm". Fails: NULL and PEN_USAGE, also for the format
 * of a report. */
const char *pen_output_format(const char *path, const char *format, struct pen_status *st);

/* The same for a report: "json", "csv", "md" or "html". Fails: NULL and PEN_USAGE, also for the
 * format of a picture. */
const char *pen_output_report_format(const char *path, const char *format, struct pen_status *st);

/* Whether one of the outputs is "-", standard output. */
bool pen_output_is_standard(const struct pen_option_list *outputs);

/* A picture file whose rows are encoded as they are finished. The bytes are appended to `out`,
 * which stays with the film until pen_output_release. */
struct pen_output {
    const struct pen_film *film;
    struct pen_buf *out;
    struct pen_png_writer *png; /* NULL for PFM, whose rows begin at the bottom */
};

/* Begins a file; `format` is one of pen_output_formats. Owns: release *output with
 * pen_output_release. Fails: PEN_NO_MEMORY. */
bool pen_output_begin(struct pen_output *output, const char *format, const struct pen_film *film,
                      const struct pen_settings *settings, struct pen_buf *out,
                      struct pen_status *st);

/* rows_done of a pen_render_task, whose rows_user is the output. */
void pen_output_rows(void *output, int rows);

/* Encodes what is left of the file. Fails: as pen_png_end. */
bool pen_output_end(struct pen_output *output, struct pen_status *st);
void pen_output_release(struct pen_output *output);

/* The values of one pixel of the film in the 8- and 16-bit formats. */
void pen_output_pixel(const float rgb[3], const struct pen_settings *settings, int png8[3],
                      int png16[3]);

#endif
