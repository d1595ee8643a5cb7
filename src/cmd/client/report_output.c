/* SPDX-License-Identifier: MIT */
#include "cmd/client/report_output.h"

#include <stdio.h>
#include <string.h>

#include "cmd/client/output.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "report/report.h"

bool pen_report_output_check(const struct pen_report_output *output, struct pen_status *st)
{
    if (output->format && output->files->count != 1)
        return pen_fail(st, PEN_USAGE, "--format: needs one -o OUT");
    for (int i = 0; i < output->files->count; i++) {
        const char *path = output->files->item[i];
        if (!pen_output_report_format(path, output->format, st))
            return false;
        if (strcmp(path, "-") == 0 && output->json)
            return pen_fail(st, PEN_USAGE, "-o -: standard output is also what --json uses");
        if (!pen_file_check(path, st))
            return false;
    }
    return true;
}

bool pen_report_output_file(const char *path, const char *format, const json_t *report,
                            const struct pen_buf *figures, struct pen_status *st)
{
    struct pen_buf text = {0};
    const bool ok = pen_report_write(report, format, figures, &text, st) &&
                    pen_file_write(path, text.data, text.bytes, st);
    pen_buf_release(&text);
    return ok;
}

static void print(const struct pen_report_output *output, json_t *report)
{
    struct pen_buf text = {0};
    struct pen_status ignored;
    if (output->json)
        pen_report_line(json_incref(report));
    else if (!output->quiet && !pen_output_is_standard(output->files) &&
             pen_report_write(report, "text", NULL, &text, &ignored))
        pen_report_show(stdout, (const char *)text.data);
    pen_buf_release(&text);
}

bool pen_report_output_write(const struct pen_report_output *output, json_t *report,
                             const struct pen_buf *figures, struct pen_status *st)
{
    for (int i = 0; i < output->files->count; i++) {
        const char *path = output->files->item[i];
        const char *format = pen_output_report_format(path, output->format, st);
        if (!format || !pen_report_output_file(path, format, report, figures, st))
            return false;
    }
    print(output, report);
    return true;
}
