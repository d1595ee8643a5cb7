/* SPDX-License-Identifier: MIT */
#include "cmd/client/pixel_report.h"

#include <inttypes.h>
#include <stdio.h>

#include "cmd/client/output.h"

bool pen_pixel_parse(const char *text, int *x, int *y, struct pen_status *st)
{
    char rest;
    if (sscanf(text, "%d,%d%c", x, y, &rest) == 2 && *x >= 0 && *y >= 0)
        return true;
    return pen_fail(st, PEN_USAGE,
                    "--pixel: found \"%s\", allowed is X,Y in pixels from the top left, such as "
                    "100,20",
                    text);
}

/* The pixel's values in each output format. */
struct outputs {
    float film[3];
    int png8[3], png16[3];
};

static struct outputs outputs_of(const struct pen_pixel *pixel, const struct pen_settings *settings)
{
    struct outputs out;
    for (int c = 0; c < 3; c++)
        out.film[c] = (float)pixel->rgb[c];
    pen_output_pixel(out.film, settings, out.png8, out.png16);
    return out;
}

void pen_pixel_print(const struct pen_pixel *pixel, const struct pen_settings *settings)
{
    const double *v = pixel->rgb;
    const struct pen_ray_counts *rays = &pixel->rays;
    struct outputs out = outputs_of(pixel, settings);
    printf("pixel   %d,%d of %d x %d, view %s\n", pixel->x, pixel->y, settings->width,
           settings->height, pixel->view);
    printf("linear  %.17g %.17g %.17g\n", v[0], v[1], v[2]);
    printf("        %a %a %a\n", v[0], v[1], v[2]);
    printf("film    %.9g %.9g %.9g\n", (double)out.film[0], (double)out.film[1],
           (double)out.film[2]);
    printf("        %a %a %a\n", (double)out.film[0], (double)out.film[1], (double)out.film[2]);
    printf("png     %d %d %d\n", out.png8[0], out.png8[1], out.png8[2]);
    printf("png16   %d %d %d\n", out.png16[0], out.png16[1], out.png16[2]);
    printf("rays    primary %" PRIu64 ", shadow %" PRIu64 ", reflection %" PRIu64
           ", transmission %" PRIu64 "\n",
           rays->primary, rays->shadow, rays->reflection, rays->transmission);
    if (rays->truncated_paths)
        printf("        %" PRIu64 " paths cut off\n", rays->truncated_paths);
    if (rays->unmatched_exits)
        printf("        %" PRIu64 " paths leave a solid that they have not entered\n",
               rays->unmatched_exits);
}

static json_t *reals(const double v[3])
{
    return json_pack("[f, f, f]", v[0], v[1], v[2]);
}

static json_t *hex(const double v[3])
{
    char text[3][40];
    for (int c = 0; c < 3; c++)
        snprintf(text[c], sizeof text[c], "%a", v[c]);
    return json_pack("[s, s, s]", text[0], text[1], text[2]);
}

json_t *pen_pixel_json(const struct pen_pixel *pixel, const struct pen_settings *settings)
{
    const struct pen_ray_counts *rays = &pixel->rays;
    struct outputs out = outputs_of(pixel, settings);
    double film[3] = {(double)out.film[0], (double)out.film[1], (double)out.film[2]};
    return json_pack("{s:i, s:i, s:s, s:o, s:o, s:o, s:o, s:[i, i, i], s:[i, i, i], "
                     "s:{s:I, s:I, s:I, s:I}, s:I, s:I}",
                     "x", pixel->x, "y", pixel->y, "view", pixel->view, "linear", reals(pixel->rgb),
                     "linear_hex", hex(pixel->rgb), "film", reals(film), "film_hex", hex(film),
                     "png", out.png8[0], out.png8[1], out.png8[2], "png16", out.png16[0],
                     out.png16[1], out.png16[2], "rays", "primary", (json_int_t)rays->primary,
                     "shadow", (json_int_t)rays->shadow, "reflection", (json_int_t)rays->reflection,
                     "transmission", (json_int_t)rays->transmission, "truncated_paths",
                     (json_int_t)rays->truncated_paths, "unmatched_exits",
                     (json_int_t)rays->unmatched_exits);
}
