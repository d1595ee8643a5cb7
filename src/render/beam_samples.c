/* SPDX-License-Identifier: MIT */
/* Samples that look for things, and the light that they may have missed. */
#include <math.h>

#include "math/fn.h"
#include "render/internal/beam_bounds.h"

static size_t pixel_at(const struct pen_beams *beams, int x, int y)
{
    return (size_t)y * (size_t)beams->width + (size_t)x;
}

enum pen_beam_things pen_beam_things(const struct pen_beams *beams, size_t pixel)
{
    if (!beams || beams->first[pixel + 1] == beams->first[pixel])
        return PEN_BEAM_NONE;
    for (uint32_t i = beams->first[pixel]; i < beams->first[pixel + 1]; i++)
        if (!beams->bounds[i].small)
            return PEN_BEAM_BRIGHT;
    return PEN_BEAM_SMALL;
}

/* Bounds as seen from a point of the lens; with a lens they are cut to the pixel. Returns the
 * density of their points, which is 1 for the whole beam; 0 if no part of them is seen from there.
 */
static double bounds_from(const struct pen_beams *beams, const struct bounds *b,
                          struct pen_point2 lens, struct bounds *seen)
{
    *seen = *b;
    if (!beams->lens)
        return 1 / b->share;
    if (lens.x < b->lens_lo.x || lens.x > b->lens_hi.x || lens.y < b->lens_lo.y ||
        lens.y > b->lens_hi.y)
        return 0;
    const double x = b->corner.x + b->shear.x * lens.x, y = b->corner.y + b->shear.y * lens.y;
    seen->corner = (struct pen_point2){pen_larger(0, x), pen_larger(0, y)};
    seen->a.x = pen_smaller(1, x + b->a.x) - seen->corner.x;
    seen->b.y = pen_smaller(1, y + b->b.y) - seen->corner.y;
    if (!(seen->a.x > 0) || !(seen->b.y > 0))
        return 0;
    const double lens_share =
        (b->lens_hi.x - b->lens_lo.x) * (b->lens_hi.y - b->lens_lo.y) / PEN_BEAM_PI;
    return 1 / (seen->a.x * seen->b.y * lens_share);
}

/* The density with which a point of the beam is drawn from bounds. */
static double density_at(const struct pen_beams *beams, const struct bounds *b, struct pen_point2 p,
                         struct pen_point2 lens)
{
    struct bounds seen;
    const double density = bounds_from(beams, b, lens, &seen);
    if (density == 0)
        return 0;
    const double x = p.x - seen.corner.x, y = p.y - seen.corner.y;
    const double area = seen.a.x * seen.b.y - seen.a.y * seen.b.x;
    const double i = (x * seen.b.y - y * seen.b.x) / area, k = (seen.a.x * y - seen.a.y * x) / area;
    return i >= 0 && i <= 1 && k >= 0 && k <= 1 ? density : 0;
}

/* A point of bounds, from a point of the unit square for the image and one for the lens. */
static void point_in(const struct pen_beams *beams, const struct bounds *b, struct pen_point2 s,
                     struct pen_point2 *p, struct pen_point2 *lens)
{
    struct bounds seen;
    if (beams->lens)
        *lens = (struct pen_point2){b->lens_lo.x + (b->lens_hi.x - b->lens_lo.x) * lens->x,
                                    b->lens_lo.y + (b->lens_hi.y - b->lens_lo.y) * lens->y};
    bounds_from(beams, b, *lens, &seen);
    p->x = seen.corner.x + s.x * seen.a.x + s.y * seen.b.x;
    p->y = seen.corner.y + s.x * seen.a.y + s.y * seen.b.y;
}

static bool in_beam(struct pen_point2 p, struct pen_point2 lens)
{
    return p.x >= 0 && p.x <= 1 && p.y >= 0 && p.y <= 1 && lens.x * lens.x + lens.y * lens.y <= 1;
}

double pen_beam_sample(const struct pen_beams *beams, const struct pen_camera_sample *sample,
                       struct pen_camera_point *at)
{
    const size_t pixel = pixel_at(beams, sample->x, sample->y);
    const struct bounds *bounds = &beams->bounds[beams->first[pixel]];
    const int count = (int)(beams->first[pixel + 1] - beams->first[pixel]);
    struct pen_sample_key key = {.seed = beams->seed,
                                 .x = (uint32_t)sample->x,
                                 .y = (uint32_t)sample->y,
                                 .purpose = PEN_PURPOSE_PIXEL};
    struct pen_point2 p, s = pen_sobol2(pen_sample_hash(&key), sample->index), lens = {0, 0};
    if (beams->lens) {
        key.purpose = PEN_PURPOSE_LENS;
        lens = pen_sobol2(pen_sample_hash(&key), sample->index);
    }
    if (s.x < PEN_BEAM_PART) {
        const double place = s.x / PEN_BEAM_PART * count;
        const int i = (int)place;
        s.x = place - i;
        point_in(beams, &bounds[i], s, &p, &lens);
    } else {
        p = (struct pen_point2){(s.x - PEN_BEAM_PART) / (1 - PEN_BEAM_PART), s.y};
        lens = beams->lens ? pen_disk_of_square(lens) : lens;
    }
    const bool within = in_beam(p, lens);
    if (!within)
        p = lens = (struct pen_point2){0, 0};
    *at = (struct pen_camera_point){sample->x + p.x, sample->y + p.y, lens};
    double density = 1 - PEN_BEAM_PART;
    for (int i = 0; i < count; i++)
        density += PEN_BEAM_PART / count * density_at(beams, &bounds[i], p, lens);
    return within ? 1 / density : 0;
}

/* The rays of a blurred mirror for each camera ray: pen_settings_sampling. */
static const double BLURRED_RAYS = 4;

/* A thing at an unknown place counts as seen if this number of samples of a pixel agree. With as
 * many samples in each neighbour, a thing that covers a thirtieth of these pixels is missed with a
 * probability of 0.01. */
static const double ENOUGH = 16;

/* The mean square change of a pixel's values if a share of this light is added, or lost. */
static double change(const struct pen_beams *beams, const double linear[3], const double light[3],
                     double share, double lost)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double value = pen_encode_unit_near(linear[c], beams->transfer);
        const double more = pen_larger(0, light[c] - share * linear[c]);
        const double up = pen_encode_unit_near(linear[c] + more, beams->transfer) - value,
                     down = value - pen_encode_unit_near(linear[c] * (1 - lost), beams->transfer);
        const double off = pen_larger(up, down);
        sum += off * off / 3;
    }
    return sum;
}

double pen_beam_unseen(const struct pen_beams *beams, size_t pixel, const double linear[3],
                       const struct pen_beam_view *view)
{
    const struct met *met = &beams->met[pixel];
    const double part = view->times / view->samples;
    double small = 0;
    if (met->small_share > 0 && view->agree)
        small = pen_smaller(1, part / (double)met->small_share);
    /* A convex thing covers at least half of the least rectangle around it. So each sample of its
     * bounds halves the probability that it is unseen, unless others hide it. */
    const double bounds = beams->first[pixel + 1] - beams->first[pixel];
    if (met->small_share > 0 && view->looks)
        small = pen_smaller(1, view->times * pen_pow(2, -PEN_BEAM_PART * view->samples / bounds));
    const double deep = view->same && view->samples < ENOUGH ? part : 0;
    if (met->share == 0 && small == 0 && met->most[0] + met->most[1] + met->most[2] == 0 &&
        deep * (double)(met->deep[0] + met->deep[1] + met->deep[2]) == 0)
        return 0;
    double light[3];
    for (int c = 0; c < 3; c++)
        light[c] = part * (double)met->light[c] + small * (double)met->small_light[c] +
                   deep * (double)met->deep[c] +
                   pen_smaller(part / BLURRED_RAYS * (double)met->blurred[c], (double)met->most[c]);
    const double lost = pen_smaller(1, small * (double)met->small_share);
    return change(beams, linear, light, part * (double)met->share + lost, lost);
}
