/* SPDX-License-Identifier: MIT */
/* The contents of a benchmark's report. */
#include <string.h>

#include "report/internal/kind.h"

static void write_method(const json_t *report, struct pen_buf *out)
{
    const int repeats = pen_report_whole(report, "repeats"),
              warmup = pen_report_whole(report, "warmup");
    pen_buf_printf(out,
                   "Milliseconds to build the tree and render%s, median of %d run%s of each row, "
                   "interleaved in a random order (least and largest beside it)",
                   json_array_size(json_object_get(report, "views")) > 1 ? " all views" : "",
                   repeats, repeats == 1 ? "" : "s");
    if (warmup > 0)
        pen_buf_printf(out, ", after %d that %s not counted", warmup, warmup == 1 ? "is" : "are");
    pen_buf_puts(out, ". Time ratio: a row's time over that of the baseline, median of the pairs "
                      "of one repeat, with its 95 % interval");
    if (pen_report_has_number(report, "least_effect"))
        pen_buf_printf(out, "; what differs by less than %g %% counts as the same",
                       pen_report_number(report, "least_effect") * 100);
    pen_buf_puts(out, ".\n");
}

/* Appends the reason why the repeats ended, if narrow intervals were requested. */
static void write_end(const json_t *report, struct pen_buf *out)
{
    const char *end = pen_report_string(report, "ended_by");
    if (!pen_report_has_number(report, "interval"))
        return;
    if (strcmp(end, "budget") == 0)
        pen_buf_printf(out, " The budget of %g s ended before all intervals were",
                       pen_report_number(report, "budget_seconds"));
    else
        pen_buf_puts(out, strcmp(end, "interval") == 0
                              ? " All intervals are"
                              : " After the most repeats not all intervals were");
    pen_buf_printf(out, " as narrow as %g.", pen_report_number(report, "interval"));
}

static void write_noise(const json_t *report, struct pen_buf *out)
{
    const json_t *noise = json_object_get(report, "noise");
    if (pen_report_has_number(noise, "median")) {
        pen_buf_puts(out, "Noise floor: the baseline against itself ");
        pen_write_ratio(noise, out);
        if (pen_report_has_number(noise, "half_width"))
            pen_buf_printf(out, ", that is \xC2\xB1%.2g %%",
                           pen_report_number(noise, "half_width") * 100);
        pen_buf_puts(out, ".");
    } else {
        pen_buf_puts(out, "Noise floor: not measured, which takes 10 repeats or an interval.");
    }
    write_end(report, out);
    pen_buf_puts(out, "\n");
}

static void write_notes(const json_t *report, struct pen_buf *out)
{
    write_method(report, out);
    write_noise(report, out);
    pen_write_list(json_object_get(report, "notes"), "note: ", out);
    pen_write_host(report, out);
    pen_write_shared(report, out);
}

static void write_picture(const json_t *row, struct pen_buf *out)
{
    const int with = pen_report_whole(row, "compared_with");
    if (with == pen_report_whole(row, "row"))
        pen_buf_puts(out, "reference");
    else if (json_is_true(pen_report_member(row, "identical")))
        pen_buf_printf(out, "identical to row %d", with);
    else
        pen_buf_printf(out, "max %.3g, rmse %.3g from row %d",
                       pen_report_number(row, "max_difference"), pen_report_number(row, "rmse"),
                       with);
}

static void write_speedup(const json_t *row, struct pen_buf *out)
{
    const double times = pen_report_number(row, "speedup");
    pen_buf_printf(out, "%.*f\xC3\x97", times < 0.1 ? 3 : times < 100 ? 2 : 0, times);
}

static void write_ratio(const json_t *row, struct pen_buf *out)
{
    pen_write_ratio(json_object_get(row, "ratio"), out);
}

static const struct pen_column columns[] = {
    {"threads_worked", NULL, "threads", .cell = PEN_CELL_NUMBER},
    {"median_ms", "median ms", "median_ms", .cell = PEN_CELL_NUMBER},
    {"min_ms", "range", "min_ms", .to = "max_ms"},
    {"max_ms", NULL, "max_ms", .cell = PEN_CELL_NUMBER},
    {"speedup", "speed-up", "speedup", .write = write_speedup},
    {"ratio", "time ratio", "ratio.median", .write = write_ratio},
    {"ratio_low", NULL, "ratio.low", .cell = PEN_CELL_NUMBER},
    {"ratio_high", NULL, "ratio.high", .cell = PEN_CELL_NUMBER},
    {"pairs", NULL, "ratio.pairs", .cell = PEN_CELL_NUMBER},
    {"spoiled_pairs", NULL, "ratio.spoiled", .cell = PEN_CELL_NUMBER},
    {"verdict", "verdict", "verdict", .cell = PEN_CELL_TEXT},
    {"build_ms", "build ms", "build_ms", .cell = PEN_CELL_NUMBER},
    {"render_ms", NULL, "render_ms", .cell = PEN_CELL_NUMBER},
    {"cpu_ms", "cpu ms", "cpu_ms", .cell = PEN_CELL_NUMBER},
    {"cpu_share", NULL, "cpu_share", .cell = PEN_CELL_NUMBER},
    {"steal_ms", NULL, "steal_ms", .cell = PEN_CELL_NUMBER},
    {"rays_primary", "primary rays", "rays.primary", .cell = PEN_CELL_COUNT, .aside = true},
    {"rays_shadow", "shadow", "rays.shadow", .cell = PEN_CELL_COUNT, .aside = true},
    {"rays_reflection", "reflection", "rays.reflection", .cell = PEN_CELL_COUNT, .aside = true},
    {"rays_transmission", "transmission", "rays.transmission", .cell = PEN_CELL_COUNT,
     .aside = true},
    {"rays_total", "all rays", "rays.total", .cell = PEN_CELL_COUNT, .aside = true},
    {"mrays_per_second", "Mray/s", "mrays_per_second", .cell = PEN_CELL_NUMBER},
    {"box_tests", NULL, "tests.boxes", .cell = PEN_CELL_NUMBER},
    {"primitive_tests", NULL, "tests.primitives", .cell = PEN_CELL_NUMBER},
    {"box_tests_per_ray", "boxes/ray", "accelerator.box_tests_per_ray", .cell = PEN_CELL_NUMBER},
    {"primitive_tests_per_ray", "primitives/ray", "accelerator.primitive_tests_per_ray",
     .cell = PEN_CELL_NUMBER},
    {"nodes", "nodes", "accelerator.nodes", .cell = PEN_CELL_COUNT, .aside = true},
    {"leaves", "leaves", "accelerator.leaves", .cell = PEN_CELL_COUNT, .aside = true},
    {"depth", "depth", "accelerator.depth", .cell = PEN_CELL_COUNT, .aside = true},
    {"tree_bytes", "tree bytes", "accelerator.bytes", .cell = PEN_CELL_COUNT, .aside = true},
    {"sah_cost", NULL, "accelerator.sah_cost", .cell = PEN_CELL_NUMBER},
    {"tree_build_ms", NULL, "accelerator.build_ms", .cell = PEN_CELL_NUMBER},
    {"kernel", NULL, "kernel", .cell = PEN_CELL_TEXT},
    {"compared_with", "picture", "compared_with", .cell = PEN_CELL_TEXT, .write = write_picture},
    {"identical", NULL, "identical", .cell = PEN_CELL_NUMBER},
    {"max_difference", NULL, "max_difference", .cell = PEN_CELL_NUMBER},
    {"rmse", NULL, "rmse", .cell = PEN_CELL_NUMBER},
    {"picture_hash", "picture hash", "picture_hash", .cell = PEN_CELL_TEXT},
    {0}};

const struct pen_report_kind pen_kind_benchmark = {.name = "benchmark",
                                                   .title = "Benchmark",
                                                   .columns = columns,
                                                   .caption = "Times, tests and pictures",
                                                   .aside = "Rays by kind, and the accelerator",
                                                   .notes = write_notes};
