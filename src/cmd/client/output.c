/* SPDX-License-Identifier: MIT */
#include "cmd/client/output.h"

#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "cmd/files.h"
#include "render/transfer.h"
#include "report/report.h"

const char *const pen_output_formats[] = {"png", "png16", "pfm", NULL};
const char *const pen_output_all_formats[] = {"png", "png16", "pfm",  "json",
                                              "csv", "md",    "html", NULL};

/* Finds the name in names[] that equals `format`; if that is NULL, the name that `path` ends in.
 * Returns NULL if there is none. */
static const char *find_format(const char *path, const char *format, const char *const *names)
{
    for (int i = 0; names[i]; i++) {
        char ending[8];
        snprintf(ending, sizeof ending, ".%s", names[i]);
        if (format ? strcmp(format, names[i]) == 0 : pen_name_ends_in(path, ending))
            return names[i];
    }
    return NULL;
}

const char *pen_output_format(const char *path, const char *format, struct pen_status *st)
{
    static const char *const endings[] = {"png", "pfm", NULL};
    if (!format && strcmp(path, "-") == 0)
        return endings[0];
    const char *found = find_format(path, format, format ? pen_output_formats : endings);
    if (!found && format)
        pen_fail(st, PEN_USAGE, "--format: a picture is png, png16 or pfm, not %s", format);
    else if (!found)
        pen_fail(st, PEN_USAGE,
                 "--output: found \"%s\", allowed is a name ending in .png or .pfm, or any name "
                 "with --format png, png16 or pfm",
                 path);
    return found;
}

const char *pen_output_report_format(const char *path, const char *format, struct pen_status *st)
{
    const char *found = find_format(path, format, pen_report_formats);
    if (!found && format)
        pen_fail(st, PEN_USAGE, "--format: a report is json, csv, md or html, not %s", format);
    else if (!found)
        pen_fail(
            st, PEN_USAGE,
            "--output: found \"%s\", allowed is a name ending in .json, .csv, .md or .html, or "
            "any name with --format json, csv, md or html",
            path);
    return found;
}

bool pen_output_is_standard(const struct pen_option_list *outputs)
{
    for (int i = 0; i < outputs->count; i++)
        if (strcmp(outputs->item[i], "-") == 0)
            return true;
    return false;
}

bool pen_output_begin(struct pen_output *output, const char *format, const struct pen_film *film,
                      const struct pen_settings *settings, struct pen_buf *out,
                      struct pen_status *st)
{
    struct pen_png_options options = {.bits = strcmp(format, "png16") == 0 ? 16 : 8,
                                      .transfer = pen_settings_transfer(settings)};
    *output = (struct pen_output){.film = film, .out = out};
    if (strcmp(format, "pfm") == 0)
        return true;
    output->png = pen_png_begin(film, &options, out, st);
    return output->png != NULL;
}

void pen_output_rows(void *output, int rows)
{
    struct pen_output *o = output;
    if (o->png)
        pen_png_rows(o->png, rows);
}

bool pen_output_end(struct pen_output *output, struct pen_status *st)
{
    return output->png ? pen_png_end(output->png, st)
                       : pen_pfm_write(output->film, output->out, st);
}

void pen_output_release(struct pen_output *output)
{
    pen_png_free(output->png);
    output->png = NULL;
}

void pen_output_pixel(const float rgb[3], const struct pen_settings *settings, int png8[3],
                      int png16[3])
{
    unsigned char narrow[3];
    uint16_t wide[3];
    pen_encode_8(rgb, 3, pen_settings_transfer(settings), narrow);
    pen_encode_16(rgb, 3, pen_settings_transfer(settings), wide);
    for (int c = 0; c < 3; c++) {
        png8[c] = narrow[c];
        png16[c] = wide[c];
    }
}
