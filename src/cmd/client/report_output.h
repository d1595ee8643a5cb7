/* SPDX-License-Identifier: MIT */
/* Where a command writes its report: files, or standard output as text or JSON. */
#ifndef PEN_CMD_CLIENT_REPORT_OUTPUT_H
#define PEN_CMD_CLIENT_REPORT_OUTPUT_H

#include <jansson.h>

#include "base/buf.h"
#include "base/status.h"
#include "cmd/options.h"

struct pen_report_output {
    const struct pen_option_list *files; /* of -o */
    const char *format;                  /* of --format; NULL: the files' endings say it */
    bool json, quiet;
};

/* The output that a command's values say: members output, format, json and quiet. */
#define PEN_REPORT_OUTPUT_OF(values)                                                               \
    ((struct pen_report_output){.files = &(values)->output,                                        \
                                .format = (values)->format,                                        \
                                .json = (values)->json,                                            \
                                .quiet = (values)->quiet})

/* Checks the options, and that the files can be written. Fails: PEN_USAGE; as pen_file_check. */
bool pen_report_output_check(const struct pen_report_output *output, struct pen_status *st);

/* Writes one file. `figures`: as pen_report_write. Fails: as pen_report_write and pen_file_write.
 */
bool pen_report_output_file(const char *path, const char *format, const json_t *report,
                            const struct pen_buf *figures, struct pen_status *st);

/* Writes all files, and then what goes to standard output: a line of JSON, or text. */
bool pen_report_output_write(const struct pen_report_output *output, json_t *report,
                             const struct pen_buf *figures, struct pen_status *st);

#endif
