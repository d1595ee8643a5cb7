/* SPDX-License-Identifier: MIT */
#include "render/layer_file.h"

#include <stdio.h>
#include <string.h>

#include "film/encode.h"
#include "render/transfer.h"

/* Writes the number that white represents as text. */
static void describe(const struct pen_layer_task *task, double white, char *text, size_t bytes)
{
    const bool tests = task->cost == PEN_COST_TESTS;
    if (task->layer == PEN_LAYER_COST)
        snprintf(text, bytes,
                 "cost: white is %.4g %s per pixel, black none; colours go by the fourth root%s",
                 white, tests ? "box and primitive tests" : "nanoseconds",
                 tests ? "" : "; times are of blocks of 8 x 8 pixels, shared by their tests");
    else if (task->layer == PEN_LAYER_DEPTH)
        snprintf(
            text, bytes,
            "depth: white is a distance of %.6g; twice as far is half as bright; black is none",
            white);
    else
        snprintf(text, bytes, "%s: white is %.6g", pen_layer_name(task->layer), white);
}

bool pen_layer_encode(const struct pen_layer_task *task, const struct pen_film *film,
                      const char *format, struct pen_buf *out, double *white, struct pen_status *st)
{
    const bool colour = task->layer == PEN_LAYER_ALBEDO;
    char text[256];
    struct pen_png_options options = {.bits = strcmp(format, "png16") == 0 ? 16 : 8,
                                      .transfer = colour ? pen_settings_transfer(task->settings)
                                                         : PEN_TRANSFER_LINEAR};
    *white = 0;
    if (strcmp(format, "pfm") == 0)
        return pen_pfm_write(film, out, st);
    *white = pen_layer_show(task->layer, film->rgb, (size_t)film->width * (size_t)film->height);
    if (*white > 0) {
        describe(task, *white, text, sizeof text);
        options.description = text;
    }
    return pen_png_write(film, &options, out, st);
}
