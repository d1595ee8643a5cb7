/* SPDX-License-Identifier: MIT */
#include "render/internal/beams.h"

#include "math/fn.h"
#include <math.h>
#include <stdlib.h>

#include "render/internal/projection.h"
#include "render/transfer.h"

static const double PI = 3.14159265358979323846;

/* The part of a beam's samples that is drawn from the bounds of things. */
static const double PART = 0.5;

/* Bounds of bright things that take a larger share of a beam are met by samples of the whole beam
 * as well. */
static const double LARGE = 0.25;

/* Own light from which on a primitive is bright. */
static const double BRIGHT = 4;

/* The most small things of a beam that is no texture, and the most bounds that are sampled. */
enum { SMALL_MOST = 4, BOUNDS_MOST = 16 };

/* Bounds of a thing in one beam. With a lens: a rectangle, which moves with the point of the lens,
 * and the part of the lens from which it can be in the pixel. */
struct bounds {
    size_t pixel;
    struct pen_point2 corner, a, b; /* of a parallelogram, from the pixel's corner on: its edges */
    struct pen_shear shear;
    struct pen_point2 lens_lo, lens_hi;
    double share; /* of the beam */
    float light[3];
    bool small;
};

/* The things of a beam. */
struct met {
    float light[3], share; /* of bright ones: with n samples 1 / n of the sums is unseen */
    float small_light[3], small_share; /* of small ones, as their bounds have them */
};

struct pen_beams {
    int width, height;
    bool lens, any;
    uint64_t seed;
    enum pen_transfer transfer;
    struct met *met;       /* by pixel */
    struct bounds *bounds; /* sorted by pixel */
    size_t count, room;
    uint32_t *first; /* bounds of pixel i are first[i] to first[i + 1] - 1 */
};

/* A thing, while its beams are found. */
struct thing {
    struct pen_hull hull;
    struct pen_shear shear;
    struct bounds bounds; /* what all its bounds have in common */
};

static double largest(struct pen_vec3 c)
{
    return fmax(c.x, fmax(c.y, c.z));
}

/* What a material shines by itself; of a pattern, more than either of its two colours. */
static struct pen_vec3 own_light(const struct pen_scene *scene, const struct pen_material *m)
{
    struct pen_vec3 sum = pen_add(m->emission, pen_mul(scene->ambient, m->ka));
    return m->patterns ? pen_scale(sum, 2) : sum;
}

/* The most that a light brings to some of the bounds of a primitive, for a reflectance of 1. */
static struct pen_vec3 light_within(const struct pen_light *light, struct pen_box box)
{
    if (!light->positional)
        return light->intensity;
    const struct pen_vec3 p = light->position;
    const double x = fmax(0, fmax(box.lo.x - p.x, p.x - box.hi.x)),
                 y = fmax(0, fmax(box.lo.y - p.y, p.y - box.hi.y)),
                 z = fmax(0, fmax(box.lo.z - p.z, p.z - box.hi.z));
    const double dd = x * x + y * y + z * z, d = sqrt(dd);
    return pen_scale(light->intensity, 1 / fmax(light->kc + light->kl * d + light->kq * dd, 1e-6));
}

/* The most light of a primitive that is seen. */
static struct pen_vec3 light_of(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_material *m = &scene->materials[scene->prim_material[prim]];
    struct pen_vec3 sum = own_light(scene, m);
    const struct pen_vec3 factor = pen_add(m->kd, m->ks), on = pen_add(m->kr, m->kt);
    const struct pen_box box = pen_prim_bounds(&scene->prims, prim);
    for (uint32_t i = 0; i < scene->light_count; i++)
        sum = pen_add(sum, pen_mul(factor, light_within(&scene->lights[i], box)));
    return pen_add(sum, pen_mul(on, scene->background));
}

static bool add_bounds(struct pen_beams *beams, const struct bounds *bounds)
{
    if (beams->count == beams->room) {
        const size_t room = beams->room > 0 ? 2 * beams->room : 1024;
        struct bounds *more = realloc(beams->bounds, room * sizeof *more);
        if (!more)
            return false;
        beams->bounds = more;
        beams->room = room;
    }
    beams->bounds[beams->count++] = *bounds;
    return true;
}

/* Counts the light of a thing; `part` of the samples look for it. */
static void add_met(struct pen_beams *beams, const struct bounds *b, double part)
{
    struct met *met = &beams->met[b->pixel];
    const float times = (float)(b->small ? b->share : b->share / part);
    for (int c = 0; c < 3; c++)
        *(b->small ? &met->small_light[c] : &met->light[c]) += times * b->light[c];
    *(b->small ? &met->small_share : &met->share) += times;
}

static bool add_beam(struct pen_beams *beams, const struct bounds *b)
{
    if (b->small || b->share <= LARGE)
        return add_bounds(beams, b);
    add_met(beams, b, 1);
    beams->any = true;
    return true;
}

/* The parallelogram around a polygon along one of its edges: from p, i times `along` and k times
 * across it. */
static double around(const struct pen_hull *part, struct pen_point2 along, struct bounds *b)
{
    double lo_i = INFINITY, hi_i = -INFINITY, lo_k = INFINITY, hi_k = -INFINITY;
    for (int i = 0; i < part->count; i++) {
        const struct pen_point2 p = part->p[i];
        const double u = p.x * along.x + p.y * along.y, v = p.y * along.x - p.x * along.y;
        lo_i = fmin(lo_i, u);
        hi_i = fmax(hi_i, u);
        lo_k = fmin(lo_k, v);
        hi_k = fmax(hi_k, v);
    }
    b->corner =
        (struct pen_point2){lo_i * along.x - lo_k * along.y, lo_i * along.y + lo_k * along.x};
    b->a = (struct pen_point2){(hi_i - lo_i) * along.x, (hi_i - lo_i) * along.y};
    b->b = (struct pen_point2){-(hi_k - lo_k) * along.y, (hi_k - lo_k) * along.x};
    return (hi_i - lo_i) * (hi_k - lo_k);
}

/* The direction of the longest edge of a polygon. */
static struct pen_point2 longest_edge(const struct pen_hull *part)
{
    struct pen_point2 along = {1, 0};
    double most = 0;
    for (int i = 0; i < part->count; i++) {
        const struct pen_point2 p = part->p[i], q = part->p[(i + 1) % part->count];
        const double x = q.x - p.x, y = q.y - p.y, length = sqrt(x * x + y * y);
        if (length > most) {
            most = length;
            along = (struct pen_point2){x / length, y / length};
        }
    }
    return along;
}

/* Adds the beam of a pinhole: the part of the polygon that is in the pixel at (x, y). */
static bool add_pixel(struct pen_beams *beams, const struct thing *thing,
                      const struct pen_hull *row, int x, int y)
{
    struct pen_hull part;
    struct bounds b = thing->bounds, oblique;
    pen_hull_clip(row, false, x, x + 1, &part);
    if (part.count < 3)
        return true;
    for (int i = 0; i < part.count; i++) {
        part.p[i].x -= x;
        part.p[i].y -= y;
    }
    oblique = b;
    b.share = around(&part, (struct pen_point2){1, 0}, &b);
    oblique.share = around(&part, longest_edge(&part), &oblique);
    if (oblique.share < 0.9 * b.share)
        b = oblique;
    b.pixel = (size_t)y * (size_t)beams->width + (size_t)x;
    return !(b.share > 0) || add_beam(beams, &b);
}

/* Which places of the lens, along one axis, bring lo to hi into 0 to 1. */
static bool lens_range(double lo, double hi, double shear, double *from, double *to)
{
    *from = -1;
    *to = 1;
    if (fabs(shear) < 1e-12)
        return hi > 0 && lo < 1;
    const double a = -hi / shear, b = (1 - lo) / shear;
    *from = fmax(-1, fmin(a, b));
    *to = fmin(1, fmax(a, b));
    return *from < *to;
}

/* Adds the beam of a lens, whose rectangle is lo to hi from the corner of the pixel on. */
static bool add_lens_pixel(struct pen_beams *beams, const struct thing *thing, struct pen_point2 lo,
                           struct pen_point2 hi, int x, int y)
{
    struct bounds b = thing->bounds;
    lo.x -= x, hi.x -= x;
    lo.y -= y, hi.y -= y;
    if (!lens_range(lo.x, hi.x, thing->shear.x, &b.lens_lo.x, &b.lens_hi.x) ||
        !lens_range(lo.y, hi.y, thing->shear.y, &b.lens_lo.y, &b.lens_hi.y))
        return true;
    /* The place of the rectangle of the lens that is nearest its middle. */
    const double u = fmax(0, fmax(b.lens_lo.x, -b.lens_hi.x)),
                 v = fmax(0, fmax(b.lens_lo.y, -b.lens_hi.y));
    if (u * u + v * v >= 1)
        return true;
    b.corner = lo;
    b.a = (struct pen_point2){hi.x - lo.x, 0};
    b.b = (struct pen_point2){0, hi.y - lo.y};
    b.shear = thing->shear;
    b.share = fmin(1, b.a.x) * fmin(1, b.b.y) *
              fmin(1, (b.lens_hi.x - b.lens_lo.x) * (b.lens_hi.y - b.lens_lo.y) / PI);
    b.pixel = (size_t)y * (size_t)beams->width + (size_t)x;
    return add_beam(beams, &b);
}

static int pixel_within(double at, int count)
{
    return at > 0 ? at < count - 1 ? (int)at : count - 1 : 0;
}

/* Adds all beams that may meet a thing. */
static bool add_thing(struct pen_beams *beams, const struct thing *thing)
{
    struct pen_point2 lo = pen_hull_least(&thing->hull), hi = pen_hull_largest(&thing->hull);
    const struct pen_point2 own_lo = lo, own_hi = hi;
    lo.x -= fabs(thing->shear.x), hi.x += fabs(thing->shear.x);
    lo.y -= fabs(thing->shear.y), hi.y += fabs(thing->shear.y);
    if (hi.x < 0 || hi.y < 0 || lo.x > beams->width || lo.y > beams->height)
        return true;
    const int left = pixel_within(lo.x, beams->width), right = pixel_within(hi.x, beams->width);
    for (int y = pixel_within(lo.y, beams->height); y <= pixel_within(hi.y, beams->height); y++) {
        struct pen_hull row;
        if (beams->lens) {
            for (int x = left; x <= right; x++)
                if (!add_lens_pixel(beams, thing, own_lo, own_hi, x, y))
                    return false;
            continue;
        }
        pen_hull_clip(&thing->hull, true, y, y + 1, &row);
        if (row.count < 3)
            continue;
        const int end = pixel_within(pen_hull_largest(&row).x, beams->width);
        for (int x = pixel_within(pen_hull_least(&row).x, beams->width); x <= end; x++)
            if (!add_pixel(beams, thing, &row, x, y))
                return false;
    }
    return true;
}

/* Whether a polygon is less than a pixel wide in the mean. */
static bool is_thin(const struct pen_hull *hull)
{
    const struct pen_point2 lo = pen_hull_least(hull), hi = pen_hull_largest(hull);
    const double x = hi.x - lo.x, y = hi.y - lo.y;
    return pen_hull_area(hull) < fmax(1, sqrt(x * x + y * y));
}

/* Whether a sphere certainly is no thing unless it is bright: the usual case, told quickly. */
static bool is_wide(const struct pen_kernel_input *input, uint32_t prim)
{
    const struct pen_pinhole *p = &input->pinhole;
    const struct pen_prim_ref ref = input->scene->prims.ref[prim];
    if (ref.kind != PEN_PRIM_SPHERE)
        return false;
    const struct pen_sphere *s = &input->scene->prims.sphere[ref.index];
    const struct pen_vec3 to = pen_sub(s->c, p->eye);
    return s->rr * pen_dot(p->middle, p->middle) > 4 * pen_dot(to, to) * pen_dot(p->dx, p->dx);
}

/* Adds a primitive if it is a thing. */
static bool add_prim(struct pen_beams *beams, const struct pen_kernel_input *input, uint32_t prim)
{
    const struct pen_scene *scene = input->scene;
    const struct pen_material *m = &scene->materials[scene->prim_material[prim]];
    const uint32_t kind = scene->prims.ref[prim].kind;
    const bool bright = largest(own_light(scene, m)) > BRIGHT;
    struct thing thing;
    if (pen_prim_infinite(kind) || (!bright && is_wide(input, prim)) ||
        (pen_prim_flat(kind) && !bright))
        return true;
    if (!pen_project(input, prim, &thing.hull, &thing.shear) || thing.hull.count < 3)
        return true;
    if (!bright && !is_thin(&thing.hull))
        return true;
    const struct pen_vec3 light = light_of(scene, prim);
    thing.bounds = (struct bounds){.light = {(float)light.x, (float)light.y, (float)light.z},
                                   .small = !bright};
    return add_thing(beams, &thing);
}

/* Sorts the bounds by pixel, and leaves out those of beams that have too many. */
static bool sort_bounds(struct pen_beams *beams)
{
    const size_t pixels = (size_t)beams->width * (size_t)beams->height;
    struct bounds *sorted = malloc((beams->count + 1) * sizeof *sorted);
    beams->first = calloc(pixels + 2, sizeof *beams->first);
    if (!sorted || !beams->first) {
        free(sorted);
        return false;
    }
    uint32_t *next = beams->first + 1; /* becomes first */
    for (size_t i = 0; i < beams->count; i++)
        next[beams->bounds[i].pixel + 1]++;
    for (size_t i = 0; i < pixels; i++)
        next[i + 1] += next[i];
    for (size_t i = 0; i < beams->count; i++)
        sorted[next[beams->bounds[i].pixel]++] = beams->bounds[i];
    size_t count = 0, from = 0;
    for (size_t pixel = 0; pixel < pixels; pixel++) {
        const size_t end = beams->first[pixel + 1];
        int small = 0, kept = 0;
        for (size_t i = from; i < end; i++)
            small += sorted[i].small;
        beams->first[pixel] = (uint32_t)count;
        for (size_t i = from; i < end; i++) {
            if (sorted[i].small && small > SMALL_MOST)
                continue;
            if (kept == BOUNDS_MOST) {
                add_met(beams, &sorted[i], 1 - PART);
                continue;
            }
            beams->bounds[count++] = sorted[i];
            kept++;
        }
        for (int i = 0; i < kept; i++)
            add_met(beams, &beams->bounds[count - 1 - (size_t)i], PART / kept);
        from = end;
    }
    beams->first[pixels] = (uint32_t)count;
    beams->count = count;
    beams->any |= count > 0;
    free(sorted);
    return true;
}

static bool fill(struct pen_beams *beams, const struct pen_kernel_input *input)
{
    beams->met = calloc((size_t)beams->width * (size_t)beams->height, sizeof *beams->met);
    if (!beams->met)
        return false;
    for (uint32_t i = 0; i < input->scene->prims.count; i++)
        if (!add_prim(beams, input, i))
            return false;
    return sort_bounds(beams);
}

bool pen_beams_new(const struct pen_kernel_input *input, struct pen_beams **out,
                   struct pen_status *st)
{
    const struct pen_settings *s = input->settings;
    struct pen_beams *beams = calloc(1, sizeof *beams);
    *out = NULL;
    if (beams) {
        *beams = (struct pen_beams){.width = s->width,
                                    .height = s->height,
                                    .lens = input->lens.open,
                                    .seed = s->seed,
                                    .transfer = pen_settings_transfer(s)};
        if (fill(beams, input)) {
            *out = beams->any ? beams : NULL;
            if (!beams->any)
                pen_beams_free(beams);
            return true;
        }
    }
    pen_beams_free(beams);
    return pen_fail(st, PEN_NO_MEMORY, "out of memory for the small and bright things of a view");
}

void pen_beams_free(struct pen_beams *beams)
{
    if (!beams)
        return;
    free(beams->met);
    free(beams->bounds);
    free(beams->first);
    free(beams);
}

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

/* Bounds as seen from a point of the lens: those of a lens are cut to the pixel. Returns the
 * density of their points, for which the whole beam has 1; 0: nothing of them is seen from there.
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
    seen->corner = (struct pen_point2){fmax(0, x), fmax(0, y)};
    seen->a.x = fmin(1, x + b->a.x) - seen->corner.x;
    seen->b.y = fmin(1, y + b->b.y) - seen->corner.y;
    if (!(seen->a.x > 0) || !(seen->b.y > 0))
        return 0;
    const double lens_share = (b->lens_hi.x - b->lens_lo.x) * (b->lens_hi.y - b->lens_lo.y) / PI;
    return 1 / (seen->a.x * seen->b.y * lens_share);
}

/* The density with which bounds give a point of the beam. */
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

/* A point of bounds, by a point of the unit square for the image and one for the lens. */
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
    if (s.x < PART) {
        const double place = s.x / PART * count;
        const int i = (int)place;
        s.x = place - i;
        point_in(beams, &bounds[i], s, &p, &lens);
    } else {
        p = (struct pen_point2){(s.x - PART) / (1 - PART), s.y};
        lens = beams->lens ? pen_disk_of_square(lens) : lens;
    }
    const bool within = in_beam(p, lens);
    if (!within)
        p = lens = (struct pen_point2){0, 0};
    *at = (struct pen_camera_point){sample->x + p.x, sample->y + p.y, lens};
    double density = 1 - PART;
    for (int i = 0; i < count; i++)
        density += PART / count * density_at(beams, &bounds[i], p, lens);
    return within ? 1 / density : 0;
}

/* The mean square of what values change if a share of so much light is added, or lost. */
static double change(const struct pen_beams *beams, const double linear[3], const double light[3],
                     double share, double lost)
{
    double sum = 0;
    for (int c = 0; c < 3; c++) {
        const double value = pen_encode_unit_near(linear[c], beams->transfer);
        const double more = fmax(0, light[c] - share * linear[c]);
        const double up = pen_encode_unit_near(linear[c] + more, beams->transfer) - value,
                     down = value - pen_encode_unit_near(linear[c] * (1 - lost), beams->transfer);
        const double off = fmax(up, down);
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
        small = fmin(1, part / (double)met->small_share);
    /* A convex thing takes half of the least rectangle around it or more: so each sample of its
     * bounds halves the probability that it is unseen, unless others hide it. */
    const double bounds = beams->first[pixel + 1] - beams->first[pixel];
    if (met->small_share > 0 && view->looks)
        small = fmin(1, view->times * pen_pow(2, -PART * view->samples / bounds));
    if (met->share == 0 && small == 0)
        return 0;
    double light[3];
    for (int c = 0; c < 3; c++)
        light[c] = part * (double)met->light[c] + small * (double)met->small_light[c];
    const double lost = fmin(1, small * (double)met->small_share);
    return change(beams, linear, light, part * (double)met->share + lost, lost);
}
