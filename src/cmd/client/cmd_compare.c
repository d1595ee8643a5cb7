/* SPDX-License-Identifier: MIT */
/* `penumbra compare`: measures the difference of two picture files. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "film/metrics.h"

struct values {
    double max_rmse, max_error, tolerance;
    bool json, quiet;
};

static const struct pen_option options[] = {
    {.name = "max-rmse",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, max_rmse),
     .value = "E",
     .max = 1,
     .help = "fail if the root mean square error is larger"},
    {.name = "max-error",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, max_error),
     .value = "E",
     .max = 1,
     .help = "fail if any value differs by more; 0: the pictures must be equal"},
    {.name = "tolerance",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, tolerance),
     .value = "E",
     .max = 1,
     .help = "also count the pixels that differ by more, and print the RMSE of the others"},
    PEN_QUIET_OPTION(struct values, "print nothing; the exit code is the answer"),
    PEN_JSON_OPTION(struct values, "print the figures as a line of JSON"),
    {0}};

static struct pen_picture *read_picture(const char *path, struct pen_status *st)
{
    struct pen_source source; /* a path or - */
    struct pen_picture *picture = NULL;
    if (pen_source_read(&source, path, 0, st))
        picture = pen_picture_read(source.text.data, source.text.bytes, st);
    pen_source_release(&source);
    return picture;
}

/* JSON has no infinity: the PSNR of equal pictures is null. */
static json_t *real_or_null(double value)
{
    return isfinite(value) ? json_real(value) : json_null();
}

static void print_json(const struct pen_difference *d, int64_t pixels)
{
    pen_report_exact(json_pack("{s:f, s:o, s:f, s:[i, i], s:I, s:I, s:I, s:f}", "rmse", d->rmse,
                               "psnr", real_or_null(d->psnr), "max_error", d->max_error, "max_at",
                               d->max_x, d->max_y, "pixels", (json_int_t)pixels, "differing",
                               (json_int_t)d->differing, "over_tolerance", (json_int_t)d->over,
                               "rmse_within", d->rmse_within));
}

static void print_text(const struct pen_difference *d, int64_t pixels, const struct values *values)
{
    printf("rmse       %.9g\n", d->rmse);
    printf("psnr       %.6g dB\n", d->psnr);
    printf("max error  %.9g", d->max_error);
    if (d->max_error > 0)
        printf(" at %d,%d", d->max_x, d->max_y);
    printf("\ndiffering  %" PRId64 " of %" PRId64 " pixels\n", d->differing, pixels);
    if (values->tolerance >= 0)
        printf("beyond %g  %" PRId64 " pixels, rmse of the others %.9g\n", values->tolerance,
               d->over, d->rmse_within);
}

static bool within(const struct pen_difference *d, const struct values *values,
                   struct pen_status *st)
{
    if (values->max_rmse >= 0 && !(d->rmse <= values->max_rmse))
        return pen_fail(st, PEN_DIFFERENT, "the pictures differ: rmse %.6g, allowed is %g", d->rmse,
                        values->max_rmse);
    if (values->max_error >= 0 && !(d->max_error <= values->max_error))
        return pen_fail(st, PEN_DIFFERENT, "the pictures differ: by %.6g at %d,%d, allowed is %g",
                        d->max_error, d->max_x, d->max_y, values->max_error);
    return true;
}

static int compare(const struct pen_picture *a, const struct pen_picture *b,
                   const struct values *values)
{
    struct pen_status st;
    struct pen_difference difference;
    double tolerance = values->tolerance >= 0 ? values->tolerance : 0;
    if (!pen_picture_compare(a, b, tolerance, &difference, &st))
        return pen_report_json(NULL, values->json, &st);
    int64_t pixels = (int64_t)pen_picture_width(a) * pen_picture_height(a);
    if (values->json)
        print_json(&difference, pixels);
    else if (!values->quiet)
        print_text(&difference, pixels, values);
    if (within(&difference, values, &st))
        return 0;
    return values->quiet ? pen_code_exit(st.code) : pen_report("penumbra", NULL, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {.max_rmse = -1, .max_error = -1, .tolerance = -1};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_compare, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    struct pen_status st;
    struct pen_picture *a = read_picture(parsed.args[0], &st);
    struct pen_picture *b = a ? read_picture(parsed.args[1], &st) : NULL;
    if (b)
        code = compare(a, b, &values);
    else
        code = pen_report_json(parsed.args[a ? 1 : 0], values.json, &st);
    pen_picture_free(a);
    pen_picture_free(b);
    return code;
}

const struct pen_command pen_command_compare = {
    .program = "penumbra",
    .name = "compare",
    .arguments = "A B",
    .summary = "Measures the difference of two pictures.",
    .details = "A and B are PNG or PFM files of the same size. The figures are about sRGB-encoded "
               "values from 0 to 1. Without --max-rmse and --max-error the command accepts any "
               "difference.",
    .options = options,
    .min_args = 2,
    .max_args = 2,
    .run = run,
};
