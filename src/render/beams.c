/* SPDX-License-Identifier: MIT */
#include "render/internal/beam_bounds.h"

#include "math/fn.h"
#include <fenv.h>
#include <math.h>
#include <stdlib.h>

/* If bounds of bright things cover a larger share of a beam than this, samples of the whole beam
 * meet them too. */
static const double LARGE = 0.25;

/* The least own light of a bright primitive. */
static const double BRIGHT = 4;

/* A primitive is small if it is less than a pixel wide. If it is brighter than white by a factor,
 * this width is larger by that factor, but at most this number of pixels. */
static const double WIDTH_MOST = 8;

/* The most small things of a beam that is not a texture, and the most bounds that are sampled. */
enum { SMALL_MOST = 4, BOUNDS_MOST = 16 };

/* A material's own light; for a pattern, an upper bound of both colours. */
static struct pen_vec3 own_light(const struct pen_scene *scene, const struct pen_material *m)
{
    struct pen_vec3 sum = pen_add(m->emission, pen_mul(scene->ambient, m->ka));
    return m->patterns ? pen_scale(sum, 2) : sum;
}

struct pen_vec3 pen_beam_light_within(const struct pen_light *light, struct pen_box box)
{
    if (!light->positional)
        return light->intensity;
    const struct pen_vec3 p = light->position;
    const double x = pen_larger(0, pen_larger(box.lo.x - p.x, p.x - box.hi.x)),
                 y = pen_larger(0, pen_larger(box.lo.y - p.y, p.y - box.hi.y)),
                 z = pen_larger(0, pen_larger(box.lo.z - p.z, p.z - box.hi.z));
    const double dd = x * x + y * y + z * z, d = sqrt(dd);
    return pen_scale(light->intensity,
                     1 / pen_larger(light->kc + light->kl * d + light->kq * dd, 1e-6));
}

/* An upper bound of the light from all lights in a box. */
static struct pen_vec3 lights_within(const struct pen_scene *scene, struct pen_box box)
{
    struct pen_vec3 sum = {0, 0, 0};
    for (uint32_t i = 0; i < scene->light_count; i++)
        sum = pen_add(sum, pen_beam_light_within(&scene->lights[i], box));
    return sum;
}

static const struct pen_material *material_of(const struct pen_scene *scene, uint32_t prim)
{
    return pen_scene_material(scene, prim);
}

struct pen_vec3 pen_beam_light(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_material *m = material_of(scene, prim);
    const struct pen_vec3 lit =
        pen_mul(pen_add(m->kd, m->ks), lights_within(scene, pen_prim_bounds(&scene->prims, prim)));
    return pen_add(pen_add(own_light(scene, m), lit),
                   pen_mul(pen_add(m->kr, m->kt), scene->background));
}

/* The brightness of most of a primitive. Highlights are separate things. */
static double brightness(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_material *m = material_of(scene, prim);
    const struct pen_vec3 lit =
        pen_mul(m->kd, lights_within(scene, pen_prim_bounds(&scene->prims, prim)));
    return pen_beam_largest(pen_add(own_light(scene, m), lit));
}

bool pen_beam_bright(const struct pen_scene *scene, uint32_t prim)
{
    return pen_beam_largest(own_light(scene, material_of(scene, prim))) > BRIGHT;
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

/* Adds a thing that covers a whole beam, whose samples meet it. It is not kept as bounds, because a
 * picture may contain very many. */
static bool add_beam(struct pen_beams *beams, const struct bounds *b)
{
    static const double all = 0.999;
    struct met *met = &beams->met[b->pixel];
    beams->any = true;
    if (b->deep) {
        pen_beam_add_depth(met, b);
        return true;
    }
    if (b->most == 0 && (b->small || b->share < all))
        return add_bounds(beams, b);
    if (b->most == 0)
        add_met(beams, b, 1);
    for (int c = 0; c < 3 && b->most > 0; c++) {
        met->blurred[c] += b->light[c];
        met->most[c] += b->light[c] * b->most;
    }
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
        lo_i = pen_smaller(lo_i, u);
        hi_i = pen_larger(hi_i, u);
        lo_k = pen_smaller(lo_k, v);
        hi_k = pen_larger(hi_k, v);
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

static bool is_dim(const struct bounds *b)
{
    return pen_larger((double)b->light[0], pen_larger((double)b->light[1], (double)b->light[2])) <=
           BRIGHT;
}

static double outside(double from, double to, double at)
{
    return pen_larger(0, pen_larger(from - at, at - to));
}

/* Lowers the light of a thing whose light falls off to the most that it may have in the pixel at
 * (x, y). */
static void fall_to(const struct thing *thing, struct bounds *b, int x, int y)
{
    const struct pen_point2 lo = pen_hull_least(&thing->hull), hi = pen_hull_largest(&thing->hull);
    const double u = outside(x, x + 1, 0.5 * (lo.x + hi.x)) / (0.5 * (hi.x - lo.x)),
                 v = outside(y, y + 1, 0.5 * (lo.y + hi.y)) / (0.5 * (hi.y - lo.y));
    const double off = pen_larger(u, v);
    const float left = (float)pen_pow(thing->fall, off * off);
    for (int c = 0; c < 3; c++)
        b->light[c] *= left;
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
    if (thing->fall > 0) {
        fall_to(thing, &b, x, y);
        b.small = is_dim(&b);
    }
    return !(b.share > 0) || add_beam(beams, &b);
}

/* The places of the lens, along one axis, from which lo to hi is within 0 to 1. */
static bool lens_range(double lo, double hi, double shear, double *from, double *to)
{
    *from = -1;
    *to = 1;
    if (fabs(shear) < 1e-12)
        return hi > 0 && lo < 1;
    const double a = -hi / shear, b = (1 - lo) / shear;
    *from = pen_larger(-1, pen_smaller(a, b));
    *to = pen_smaller(1, pen_larger(a, b));
    return *from < *to;
}

/* Adds the beam of a lens, whose rectangle is lo to hi relative to the corner of the pixel. */
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
    const double u = pen_larger(0, pen_larger(b.lens_lo.x, -b.lens_hi.x)),
                 v = pen_larger(0, pen_larger(b.lens_lo.y, -b.lens_hi.y));
    if (u * u + v * v >= 1)
        return true;
    b.corner = lo;
    b.a = (struct pen_point2){hi.x - lo.x, 0};
    b.b = (struct pen_point2){0, hi.y - lo.y};
    b.shear = thing->shear;
    b.share =
        pen_smaller(1, b.a.x) * pen_smaller(1, b.b.y) *
        pen_smaller(1, (b.lens_hi.x - b.lens_lo.x) * (b.lens_hi.y - b.lens_lo.y) / PEN_BEAM_PI);
    b.pixel = (size_t)y * (size_t)beams->width + (size_t)x;
    b.small |= thing->fall > 0 && is_dim(&b);
    return add_beam(beams, &b);
}

static int pixel_within(double at, int count)
{
    return at > 0 ? at < count - 1 ? (int)at : count - 1 : 0;
}

bool pen_beam_add_thing(struct pen_beams *beams, const struct thing *thing)
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

/* Whether a polygon's mean width is less than this number of pixels. */
static bool is_thin(const struct pen_hull *hull, double pixels)
{
    const struct pen_point2 lo = pen_hull_least(hull), hi = pen_hull_largest(hull);
    const double x = hi.x - lo.x, y = hi.y - lo.y;
    return pen_hull_area(hull) < pixels * pen_larger(pixels, sqrt(x * x + y * y));
}

/* Whether a sphere is certainly no thing unless it is bright: a fast test of the usual case. */
static bool is_wide(const struct pen_kernel_input *input, uint32_t prim)
{
    const struct pen_pinhole *p = &input->pinhole;
    const struct pen_prim_ref ref = pen_prim_ref(&input->scene->prims, prim);
    if (ref.kind != PEN_PRIM_SPHERE)
        return false;
    const struct pen_sphere *s = &input->scene->prims.sphere[ref.index];
    const struct pen_vec3 to = pen_sub(s->c, p->eye);
    return s->rr * pen_dot(p->middle, p->middle) >
           WIDTH_MOST * WIDTH_MOST * pen_dot(to, to) * pen_dot(p->dx, p->dx);
}

static bool share_a_corner(struct pen_outline a, struct pen_outline b)
{
    for (uint32_t i = 0; i < a.count; i++)
        for (uint32_t k = 0; k < b.count; k++)
            if (a.v[i].x == b.v[k].x && a.v[i].y == b.v[k].y && a.v[i].z == b.v[k].z)
                return true;
    return false;
}

/* Whether a flat primitive is part of a surface: it shares a corner with one that is near it in the
 * document. Small primitives of a surface are no things. */
static bool is_facet(const struct pen_prims *prims, uint32_t prim)
{
    struct pen_triangle room;
    enum { NEAR = 4 };
    const struct pen_outline own = pen_prim_outline(prims, prim, &room);
    const uint32_t first = prim > NEAR ? prim - NEAR : 0;
    for (uint32_t i = first; i < prims->count && i <= prim + NEAR; i++)
        if (i != prim && share_a_corner(own, pen_prim_outline(prims, i, &room)))
            return true;
    return false;
}

/* Adds a primitive if it is a thing. */
static bool add_prim(struct pen_beams *beams, const struct pen_kernel_input *input, uint32_t prim)
{
    const struct pen_scene *scene = input->scene;
    const uint32_t kind = pen_prim_kind(&scene->prims, prim);
    const bool shines = pen_beam_bright(scene, prim);
    struct thing thing = {.fall = 0};
    if (pen_prim_infinite(kind) || (!shines && is_wide(input, prim)) ||
        (!shines && pen_prim_flat(kind) && is_facet(&scene->prims, prim)))
        return true;
    if (!pen_project(input, prim, &thing.hull, &thing.shear) || thing.hull.count < 3)
        return true;
    const double bright = brightness(scene, prim);
    const double wide = pen_larger(1, pen_smaller(bright, WIDTH_MOST));
    if (!shines && !is_thin(&thing.hull, wide))
        return true;
    const struct pen_vec3 light = pen_beam_light(scene, prim);
    thing.bounds =
        (struct bounds){.light = {(float)light.x, (float)light.y, (float)light.z},
                        .near = pen_beam_depth(input, pen_prim_bounds(&scene->prims, prim)),
                        .small = !shines && bright <= BRIGHT};
    return pen_beam_add_thing(beams, &thing);
}

/* Sorts the bounds by pixel. */
static bool sort_bounds(struct pen_beams *beams)
{
    const size_t pixels = (size_t)beams->width * (size_t)beams->height;
    struct bounds *sorted = malloc((beams->count + 1) * sizeof *sorted);
    beams->first = calloc(pixels + 2, sizeof *beams->first);
    if (!sorted || !beams->first) {
        free(sorted);
        return false;
    }
    uint32_t *next = beams->first + 1; /* this array becomes `first` */
    for (size_t i = 0; i < beams->count; i++)
        next[beams->bounds[i].pixel + 1]++;
    for (size_t i = 0; i < pixels; i++)
        next[i + 1] += next[i];
    for (size_t i = 0; i < beams->count; i++)
        sorted[next[beams->bounds[i].pixel]++] = beams->bounds[i];
    free(beams->bounds);
    beams->bounds = sorted;
    return true;
}

/* Keeps the bounds of a pixel from which samples are drawn, from number `count` on. Of the others
 * only the light counts. */
static void keep_bounds(struct pen_beams *beams, const struct bounds *from, size_t n, size_t count)
{
    int small = 0, kept = 0;
    for (size_t i = 0; i < n; i++)
        small += from[i].small && from[i].share > 0;
    for (size_t i = 0; i < n; i++) {
        const struct bounds b = from[i];
        if (b.share == 0 || (b.small && small > SMALL_MOST))
            continue;
        if (!b.small && b.share > LARGE)
            add_met(beams, &b, 1);
        else if (kept == BOUNDS_MOST)
            add_met(beams, &b, 1 - PEN_BEAM_PART);
        else
            beams->bounds[count + (size_t)kept++] = b;
    }
    for (int i = 0; i < kept; i++)
        add_met(beams, &beams->bounds[count + (size_t)i], PEN_BEAM_PART / kept);
    beams->count = count + (size_t)kept;
}

static void keep_all_bounds(struct pen_beams *beams)
{
    const size_t pixels = (size_t)beams->width * (size_t)beams->height;
    size_t from = 0;
    beams->count = 0;
    for (size_t pixel = 0; pixel < pixels; pixel++) {
        const size_t end = beams->first[pixel + 1];
        beams->first[pixel] = (uint32_t)beams->count;
        keep_bounds(beams, &beams->bounds[from], end - from, beams->count);
        from = end;
    }
    beams->first[pixels] = (uint32_t)beams->count;
}

static bool fill(struct pen_beams *beams, const struct pen_kernel_input *input,
                 struct pen_thread_pool *pool)
{
    beams->met = calloc((size_t)beams->width * (size_t)beams->height, sizeof *beams->met);
    if (!beams->met)
        return false;
    for (uint32_t i = 0; i < input->scene->prims.count; i++)
        if (!add_prim(beams, input, i))
            return false;
    if (!pen_beam_add_images(beams, input) || !pen_beam_add_depths(beams, input) ||
        !sort_bounds(beams))
        return false;
    if (beams->count > 0)
        pen_beam_hide(beams, input, pool);
    keep_all_bounds(beams);
    return true;
}

bool pen_beams_new(const struct pen_kernel_input *input, struct pen_thread_pool *pool,
                   struct pen_beams **out, struct pen_status *st)
{
    const struct pen_settings *s = input->settings;
    struct pen_beams *beams = calloc(1, sizeof *beams);
    fenv_t caller;
    bool ok = false;
    *out = NULL;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    if (beams) {
        *beams = (struct pen_beams){.width = s->width,
                                    .height = s->height,
                                    .lens = input->lens.open,
                                    .seed = s->seed,
                                    .transfer = pen_settings_transfer(s)};
        ok = fill(beams, input, pool);
    }
    fesetenv(&caller);
    if (ok && beams->any)
        *out = beams;
    else
        pen_beams_free(beams);
    return ok ||
           pen_fail(st, PEN_NO_MEMORY, "out of memory for the small and bright things of a view");
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
