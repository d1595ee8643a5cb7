/* SPDX-License-Identifier: MIT */
/* The formats of pictures and reports: their names, how an output's name gives its format, and
 * encoding a picture. */
#ifndef PEN_CMD_CLIENT_OUTPUT_H
#define PEN_CMD_CLIENT_OUTPUT_H

#include <stdbool.h>

#include "base/buf.h"
#include "base/status.h"
#include "film/film.h"
#include "scene/settings.h"

/* The choices of --format and --layer; NULL ends each. */
extern const char *const pen_output_formats[];     /* of pictures */
extern const char *const pen_output_all_formats[]; /* of pictures and reports */
extern const char *const pen_output_layers[];

/* The format of a picture: `format`, or if that is NULL the one that `path` ends in. Returns "png",
 * "png16" or "pfm". Fails: NULL and PEN_USAGE, also for the format of a report. */
const char *pen_output_format(const char *path, const char *format, struct pen_status *st);

/* The same for a report: "json", "csv", "md" or "html". Fails: NULL and PEN_USAGE, also for the
 * format of a picture. */
const char *pen_output_report_format(const char *path, const char *format, struct pen_status *st);

/* Refuses every layer that is not supported yet. Fails: PEN_UNSUPPORTED. */
bool pen_output_layer_check(const char *layer, struct pen_status *st);

/* Appends the bytes of a picture file to `out`. `format` is one of pen_output_formats. */
bool pen_output_encode(const char *format, const struct pen_film *film,
                       const struct pen_settings *settings, struct pen_buf *out,
                       struct pen_status *st);

/* The values of one pixel of the film in the 8- and 16-bit formats. */
void pen_output_pixel(const float rgb[3], const struct pen_settings *settings, int png8[3],
                      int png16[3]);

#endif
