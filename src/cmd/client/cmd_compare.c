/* SPDX-License-Identifier: MIT */
/* `penumbra compare`: measures the difference of two picture files, and draws a map of it.
 * report_source.c compares two reports of benchmarks. */
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "cmd/client/commands.h"
#include "cmd/client/common_options.h"
#include "cmd/client/output.h"
#include "cmd/client/report_source.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "film/ssim.h"
#include "jobs/comparison.h"

struct values {
    double max_rmse, max_flip, min_ssim, max_error, tolerance;
    const char *output, *format;
    bool json, quiet, time;
};

static const struct pen_option options[] = {
    {.name = "max-rmse",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, max_rmse),
     .value = "E",
     .max = 1,
     .help = "fail if the root mean square error is larger"},
    {.name = "max-flip",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, max_flip),
     .value = "E",
     .max = 1,
     .help = "fail if the mean of FLIP is larger"},
    {.name = "min-ssim",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, min_ssim),
     .value = "S",
     .min = -1,
     .max = 1,
     .help = "fail if SSIM is smaller"},
    {.name = "max-error",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, max_error),
     .value = "E",
     .max = 1e30,
     .help = "fail if any value differs by more, which can be beyond 1 for two PFM files; 0: the "
             "pictures must be equal"},
    {.name = "tolerance",
     .kind = PEN_OPTION_NUMBER,
     .offset = offsetof(struct values, tolerance),
     .value = "E",
     .max = 1e30,
     .help = "also count the pixels that differ by more, and print the RMSE of the others"},
    PEN_OUTPUT_OPTION(struct values, "OUT",
                      "draw FLIP's error of each pixel, from black (none) to pale yellow (1), as "
                      "OUT.png; OUT.pfm has the numbers"),
    PEN_FORMAT_OPTION(struct values, "png|png16|pfm", pen_output_formats),
    {.name = "time",
     .kind = PEN_OPTION_FLAG,
     .offset = offsetof(struct values, time),
     .help = "of two reports: fail also if a row is slower"},
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

static void print_text(const struct pen_comparison *f, const struct values *values)
{
    const struct pen_difference *d = &f->difference;
    printf("rmse          %.9g\n", d->rmse);
    printf("relative mse  %.9g\n", d->relative_mse);
    printf("psnr          %.6g dB\n", d->psnr);
    printf("ssim          %.9g\n", f->ssim);
    printf("flip          %.9g, weighted median %.6g, largest %.6g\n", f->flip.mean,
           f->flip.weighted_median, f->flip.max);
    printf("max error     %.9g", d->max_error);
    if (d->max_error > 0)
        printf(" at %d,%d", d->max_x, d->max_y);
    printf("\ndiffering     %" PRId64 " of %" PRId64 " pixels\n", d->differing,
           (int64_t)f->width * f->height);
    if (d->alpha > 0)
        printf("alpha         differs in %" PRId64 " pixel%s\n", d->alpha, d->alpha > 1 ? "s" : "");
    if (f->tags_differ)
        printf("tags          differ, and the values are equal\n");
    if (values->tolerance >= 0)
        printf("beyond %g  %" PRId64 " pixels, rmse of the others %.9g\n", values->tolerance,
               d->over, d->rmse_within);
}

static bool within(const struct pen_comparison *f, const struct values *values,
                   struct pen_status *st)
{
    const struct pen_difference *d = &f->difference;
    if (d->alpha > 0)
        return pen_fail(st, PEN_DIFFERENT,
                        "the pictures differ: in the alpha of %" PRId64 " pixel%s", d->alpha,
                        d->alpha > 1 ? "s" : "");
    if (values->max_rmse >= 0 && !(d->rmse <= values->max_rmse))
        return pen_fail(st, PEN_DIFFERENT, "the pictures differ: rmse %.6g, allowed is %g", d->rmse,
                        values->max_rmse);
    if (values->max_flip >= 0 && !(f->flip.mean <= values->max_flip))
        return pen_fail(st, PEN_DIFFERENT, "the pictures differ: flip %.6g, allowed is %g",
                        f->flip.mean, values->max_flip);
    if (values->min_ssim >= -1 && !(f->ssim >= values->min_ssim))
        return pen_fail(st, PEN_DIFFERENT, "the pictures differ: ssim %.6g, allowed is %g or more",
                        f->ssim, values->min_ssim);
    if (values->max_error >= 0 && !(d->max_error <= values->max_error))
        return pen_fail(st, PEN_DIFFERENT, "the pictures differ: by %.6g at %d,%d, allowed is %g",
                        d->max_error, d->max_x, d->max_y, values->max_error);
    return true;
}

static bool check_values(const struct values *v, struct pen_status *st)
{
    if (v->format && !v->output)
        return pen_fail(st, PEN_USAGE, "--format: needs -o OUT");
    if (!v->output)
        return true;
    if (strcmp(v->output, "-") == 0 && (v->json || !v->quiet))
        return pen_fail(st, PEN_USAGE,
                        "-o -: standard output is also where the figures go, except with --quiet");
    return pen_output_format(v->output, v->format, st) && pen_file_check(v->output, st);
}

/* Measures what will be printed or checked; ssim and flip otherwise stay 0. `errors` may be
 * NULL. */
static bool measure(const struct pen_picture *a, const struct pen_picture *b,
                    const struct values *values, struct pen_comparison *f, float *errors,
                    struct pen_status *st)
{
    const double tolerance = values->tolerance >= 0 ? values->tolerance : 0;
    const bool print = !values->quiet || values->json;
    return pen_picture_compare(a, b, tolerance, &f->difference, st) &&
           (!(print || values->min_ssim >= -1) || pen_picture_ssim(a, b, &f->ssim, st)) &&
           (!(print || errors || values->max_flip >= 0) ||
            pen_picture_flip(a, b, errors, &f->flip, st));
}

static bool write_map(const float *errors, const struct pen_comparison *f,
                      const struct values *values, struct pen_status *st)
{
    const char *format = pen_output_format(values->output, values->format, st);
    struct pen_buf bytes = {0};
    const bool ok = format && pen_comparison_map(errors, f->width, f->height, format, &bytes, st) &&
                    pen_file_write(values->output, bytes.data, bytes.bytes, st);
    pen_buf_release(&bytes);
    return ok;
}

/* Measures and draws. */
static bool make_results(const struct pen_picture *a, const struct pen_picture *b,
                         const struct values *values, struct pen_comparison *f,
                         struct pen_status *st)
{
    *f = (struct pen_comparison){.width = pen_picture_width(a), .height = pen_picture_height(a)};
    if (!values->output)
        return measure(a, b, values, f, NULL, st);
    float *errors = malloc((size_t)f->width * (size_t)f->height * sizeof *errors);
    if (!errors)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for the errors of %d x %d pixels", f->width,
                        f->height);
    const bool ok = measure(a, b, values, f, errors, st) && write_map(errors, f, values, st);
    free(errors);
    return ok;
}

static int compare(struct pen_picture *a, struct pen_picture *b, const struct values *values)
{
    struct pen_status st;
    struct pen_comparison figures;
    const bool tags_differ = pen_picture_match(a, b);
    if (!make_results(a, b, values, &figures, &st))
        return pen_report_json(NULL, values->json, &st);
    figures.tags_differ = tags_differ;
    if (values->json)
        pen_report_exact(pen_comparison_json(&figures));
    else if (!values->quiet)
        print_text(&figures, values);
    if (within(&figures, values, &st))
        return 0;
    return values->quiet ? pen_code_exit(st.code) : pen_report("penumbra", NULL, &st);
}

static int run(int argc, char **argv)
{
    struct values values = {
        .max_rmse = -1, .max_flip = -1, .min_ssim = -2, .max_error = -1, .tolerance = -1};
    struct pen_parsed parsed;
    int code = pen_command_begin(&pen_command_compare, argc, argv, &values, &parsed);
    if (code >= 0)
        return code;
    if (pen_report_source_is_json(parsed.args[0]) && pen_report_source_is_json(parsed.args[1]))
        return pen_report_compare(&(struct pen_report_compare){.before = parsed.args[0],
                                                               .after = parsed.args[1],
                                                               .time = values.time,
                                                               .json = values.json,
                                                               .quiet = values.quiet});
    struct pen_status st;
    if (!check_values(&values, &st))
        return pen_report_json(NULL, values.json, &st);
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
    .summary = "Measures the difference of two pictures, or compares two reports.",
    .details =
        "A and B are PNG or PFM files of the same size. These figures are about sRGB-encoded "
        "values from 0 to 1: the root mean square error and its PSNR, SSIM of luma (1: equal), "
        "FLIP at 67 pixels per degree (0: looks equal), and the largest difference of a value. For "
        "two PFM files, the largest difference also counts values beyond 0 and 1. The relative "
        "mean square error is about linear values; B is its reference. A picture with transfer "
        "display has values for a screen, and so has the PFM beside it. Files with equal values "
        "are equal; the command reports if their tags differ. "
        "Without a bound (--max-rmse, --max-flip, --min-ssim, --max-error) the command accepts "
        "any difference of colours. If their alpha differs, the pictures differ, and the exit code "
        "is 7; a file without alpha is opaque. Two reports of benchmarks or accuracy studies, as "
        "JSON, are compared row by row. If counts or pictures differ, the exit code is 7. Times "
        "are shown, with a verdict if both reports are of one host.",
    .options = options,
    .min_args = 2,
    .max_args = 2,
    .run = run,
};
