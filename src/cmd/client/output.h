/* SPDX-License-Identifier: MIT */
/* Pictures as command lines ask for them: settings, the format that an output takes, and the
 * pixels in it. */
#ifndef PEN_CMD_CLIENT_OUTPUT_H
#define PEN_CMD_CLIENT_OUTPUT_H

#include <stdbool.h>

#include "base/buf.h"
#include "base/status.h"
#include "film/film.h"
#include "scene/settings.h"

/* What --format and --layer take; for struct pen_option. */
extern const char *const pen_output_formats[];
extern const char *const pen_output_layers[];
extern const char *const pen_output_all_formats[]; /* of pictures and reports */

/* The format of a picture: `format` if given, else by the ending of `path`; a path without a
 * known ending needs a format. Returns "png", "png16" or "pfm". Fails: PEN_USAGE, also for the
 * format of a report. */
const char *pen_output_format(const char *path, const char *format, struct pen_status *st);

/* The form of a report: `form` if given, else by the ending of `path`: .json, .csv, .md or .html.
 * Fails: PEN_USAGE, also for the format of a picture. */
const char *pen_output_report_format(const char *path, const char *form, struct pen_status *st);

/* Refuses the layers that are still to come. Fails: PEN_UNSUPPORTED. */
bool pen_output_layer_check(const char *layer, struct pen_status *st);

/* Applies one --set KEY=VALUE. Fails: PEN_USAGE, naming the option. */
bool pen_output_set(struct pen_settings *settings, const char *assignment, struct pen_status *st);

/* Appends the file's bytes, in one of the formats above, to `out`. */
bool pen_output_encode(const char *format, const struct pen_film *film,
                       const struct pen_settings *settings, struct pen_buf *out,
                       struct pen_status *st);

/* What one pixel of the film is in the 8- and 16-bit formats. */
void pen_output_pixel(const float rgb[3], const struct pen_settings *settings, int png8[3],
                      int png16[3]);

#endif
