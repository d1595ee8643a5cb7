/* SPDX-License-Identifier: MIT */
/* Images of things in surfaces: bright primitives in mirrors, and highlights, which are images of
 * lights. A flat mirror shows an image as far behind it as the thing is in front of it. A round
 * surface shows one where its normal halves the angle between the eye and the thing. */
#include <math.h>

#include "math/fn.h"
#include "render/internal/beam_bounds.h"

/* A flat mirror, with the width of the cone of its rays. */
struct mirror {
    struct pen_vec3 point, normal, kr;
    double blur; /* the tangent of the cone's half-angle */
    float near;  /* as in struct bounds */
};

/* The tangent of the half-angle of a material's reflected rays. */
static double blur_of(const struct pen_scene *scene, uint32_t prim)
{
    const double cosine = 1 - scene->blurs[pen_scene_material_of(scene, prim)].reflection;
    return sqrt(1 - cosine * cosine) / pen_larger(cosine, 1e-3);
}

static const struct pen_material *material_of(const struct pen_scene *scene, uint32_t prim)
{
    return pen_scene_material(scene, prim);
}

/* An upper bound of the light that a primitive mirrors. */
static struct pen_vec3 mirrored_by(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_material *m = material_of(scene, prim);
    return m->patterns ? pen_scale(m->kr, 2) : m->kr;
}

static bool is_mirror(const struct pen_kernel_input *input, uint32_t prim)
{
    return pen_beam_largest(material_of(input->scene, prim)->kr) >
           input->settings->min_contribution;
}

static bool mirror_of(const struct pen_kernel_input *input, uint32_t prim, struct mirror *mirror)
{
    struct pen_triangle room;
    const struct pen_scene *scene = input->scene;
    const struct pen_prim_ref ref = pen_prim_ref(&scene->prims, prim);
    if (!pen_prim_flat(ref.kind) || !is_mirror(input, prim))
        return false;
    const struct pen_outline outline = pen_prim_outline(&scene->prims, prim, &room);
    mirror->kr = mirrored_by(scene, prim);
    mirror->blur = blur_of(scene, prim);
    mirror->near = pen_prim_infinite(ref.kind)
                       ? 0
                       : pen_beam_depth(input, pen_prim_bounds(&scene->prims, prim));
    mirror->point = outline.count > 0 ? outline.v[0] : scene->prims.plane[ref.index].q;
    mirror->normal = pen_prim_normal(&scene->prims, (struct pen_hit){.prim = prim}, mirror->point);
    return true;
}

/* The radius of a sphere around a primitive. */
static double radius_around(const struct pen_scene *scene, uint32_t prim)
{
    const struct pen_box box = pen_prim_bounds(&scene->prims, prim);
    return pen_prim_kind(&scene->prims, prim) == PEN_PRIM_SPHERE
               ? 0.5 * (box.hi.x - box.lo.x)
               : 0.5 * pen_length(pen_sub(box.hi, box.lo));
}

static void set_light(struct bounds *b, struct pen_vec3 light)
{
    b->light[0] = (float)light.x;
    b->light[1] = (float)light.y;
    b->light[2] = (float)light.z;
}

/* Adds the image of a bright thing in a flat mirror: that of a sphere around it. A blurred image is
 * seen in a wider sphere. There a ray meets the thing with a probability of at most its share of
 * the cone, from the nearest place of the mirror. */
static bool add_mirrored(struct pen_beams *beams, const struct pen_kernel_input *input,
                         uint32_t prim, const struct mirror *mirror)
{
    const struct pen_vec3 center = pen_box_center(pen_prim_bounds(&input->scene->prims, prim));
    const double away = pen_dot(pen_sub(center, mirror->point), mirror->normal),
                 eye = pen_dot(pen_sub(input->pinhole.eye, mirror->point), mirror->normal);
    double radius = radius_around(input->scene, prim);
    struct pen_sphere picture;
    struct thing thing = {.fall = 0};
    if (away * eye <= 0)
        return true;
    const struct pen_vec3 c = pen_along(center, mirror->normal, -2 * away);
    const double ratio = radius / (pen_larger(fabs(away) - radius, 1e-9) * mirror->blur);
    radius += mirror->blur * pen_length(pen_sub(c, input->pinhole.eye));
    if (!pen_sphere_make(&picture, c, radius) ||
        !pen_project_sphere(input, &picture, &thing.hull, &thing.shear))
        return true;
    if (mirror->blur > 0)
        thing.bounds.most = (float)pen_smaller(1, ratio * ratio);
    thing.bounds.near = mirror->near;
    set_light(&thing.bounds, pen_mul(pen_beam_light(input->scene, prim), mirror->kr));
    return pen_beam_add_thing(beams, &thing);
}

/* Adds the images of bright things in flat mirrors. */
static bool add_mirrors(struct pen_beams *beams, const struct pen_kernel_input *input)
{
    enum { MIRRORS_MOST = 16 };
    const struct pen_scene *scene = input->scene;
    struct mirror mirror[MIRRORS_MOST];
    int count = 0;
    for (uint32_t i = 0; i < scene->prims.count && count < MIRRORS_MOST; i++)
        count += mirror_of(input, i, &mirror[count]);
    for (uint32_t i = 0; count > 0 && i < scene->prims.count; i++) {
        if (pen_prim_infinite(pen_prim_kind(&scene->prims, i)) || !pen_beam_bright(scene, i))
            continue;
        for (int k = 0; k < count; k++)
            if (!add_mirrored(beams, input, i, &mirror[k]))
                return false;
    }
    return true;
}

/* The thing or light whose image a surface shows. */
struct source {
    bool far;
    struct pen_vec3 at; /* its middle; the direction to it if it is far */
};

/* The place of a surface at which it shows the image. */
struct place {
    struct pen_vec3 p, normal, along; /* a point, and unit vectors; `along` is a tangent */
    double curved[2];                 /* the curvature along that tangent, and across it */
};

static struct pen_vec3 direction_to(const struct source *source, struct pen_vec3 p)
{
    return source->far ? source->at : pen_normalize(pen_sub(source->at, p));
}

static struct pen_vec3 halfway(const struct pen_kernel_input *input, const struct source *source,
                               struct pen_vec3 p)
{
    return pen_add(pen_normalize(pen_sub(input->pinhole.eye, p)), direction_to(source, p));
}

static struct pen_vec3 any_tangent(struct pen_vec3 n)
{
    const struct pen_vec3 axis = fabs(n.x) < 0.6 ? pen_vec3(1, 0, 0) : pen_vec3(0, 1, 0);
    return pen_normalize(pen_cross(n, axis));
}

/* Steps that approach a place of a round surface. */
enum { STEPS = 50 };

static bool is_there(struct pen_vec3 a, struct pen_vec3 b)
{
    return pen_norm1(pen_sub(a, b)) < 1e-9;
}

static void place_on_sphere(const struct pen_kernel_input *input, const struct pen_sphere *sphere,
                            const struct source *source, struct place *at)
{
    struct pen_vec3 next = {0, 0, 0};
    at->p = sphere->c;
    for (int i = 0; i < STEPS; i++) {
        next = pen_normalize(halfway(input, source, at->p));
        if (i > 0 && is_there(at->normal, next))
            break;
        at->normal = next;
        at->p = pen_along(sphere->c, next, sphere->r);
    }
    at->along = any_tangent(at->normal);
    at->curved[0] = at->curved[1] = 1 / sphere->r;
}

static struct pen_vec3 across(struct pen_vec3 v, struct pen_vec3 axis)
{
    return pen_along(v, axis, -pen_dot(v, axis));
}

/* The place on a line: rays to the eye and to the source have the same slope there. */
static double along_line(struct pen_vec3 eye, struct pen_vec3 source, bool far,
                         struct pen_vec3 axis)
{
    const double de = pen_length(across(eye, axis)), ds = pen_length(across(source, axis)),
                 ze = pen_dot(eye, axis), zs = pen_dot(source, axis);
    return far ? ze + de * zs / pen_larger(ds, 1e-9)
               : (ze * ds + zs * de) / pen_larger(de + ds, 1e-300);
}

static void place_on_cylinder(const struct pen_kernel_input *input,
                              const struct pen_cylinder_side *side, const struct source *source,
                              struct place *at)
{
    const struct pen_vec3 axis = pen_normalize(side->a);
    at->p = side->q;
    for (int i = 0; i < STEPS; i++) {
        const struct pen_vec3 next = pen_normalize(across(halfway(input, source, at->p), axis));
        if (i > 0 && is_there(at->normal, next))
            break;
        at->normal = next;
        const struct pen_vec3 from = pen_along(side->q, next, side->r);
        const struct pen_vec3 to = source->far ? source->at : pen_sub(source->at, from);
        at->p = pen_along(from, axis,
                          along_line(pen_sub(input->pinhole.eye, from), to, source->far, axis));
    }
    at->along = axis;
    at->curved[0] = 0;
    at->curved[1] = 1 / side->r;
}

/* The place on a plane through q: it is on the line from the eye's image behind the plane to the
 * source. */
static bool place_on_plane(const struct pen_kernel_input *input, struct pen_vec3 q,
                           struct pen_vec3 normal, const struct source *source, struct place *at)
{
    const double height = pen_dot(pen_sub(input->pinhole.eye, q), normal);
    const struct pen_vec3 behind = pen_along(input->pinhole.eye, normal, -2 * height);
    const struct pen_vec3 to = source->far ? source->at : pen_sub(source->at, behind);
    const double rise = pen_dot(to, normal);
    if (!(height * rise > 0))
        return false;
    at->p = pen_along(behind, to, height / rise);
    if (!source->far && !(height * pen_dot(pen_sub(source->at, q), normal) > 0))
        return false;
    at->normal = height > 0 ? normal : pen_neg(normal);
    at->along = any_tangent(normal);
    at->curved[0] = at->curved[1] = 0;
    return true;
}

static bool place_on(const struct pen_kernel_input *input, uint32_t prim,
                     const struct source *source, struct place *at)
{
    struct pen_triangle room;
    const struct pen_prims *prims = &input->scene->prims;
    const struct pen_prim_ref ref = pen_prim_ref(prims, prim);
    const struct pen_outline outline = pen_prim_outline(prims, prim, &room);
    if (ref.kind == PEN_PRIM_SPHERE)
        place_on_sphere(input, &prims->sphere[ref.index], source, at);
    else if (ref.kind == PEN_PRIM_CYLINDER)
        place_on_cylinder(input, &prims->cylinder[ref.index].round, source, at);
    else if (ref.kind == PEN_PRIM_INFINITE_CYLINDER)
        place_on_cylinder(input, &prims->infinite_cylinder[ref.index].round, source, at);
    else if (ref.kind == PEN_PRIM_PLANE || outline.count > 0) {
        const struct pen_vec3 q = outline.count > 0 ? outline.v[0] : prims->plane[ref.index].q;
        return place_on_plane(input, q, pen_prim_normal(prims, (struct pen_hit){.prim = prim}, q),
                              source, at);
    } else
        return false;
    return true;
}

/* How far an image extends from its place along a tangent with this curvature. The mirrored ray is
 * off by twice the angle of the normal, and by the angles at the eye and at the source. */
static double reach(const struct place *at, const struct pen_kernel_input *input,
                    const struct source *source, double angle, double curved)
{
    static const double grazing = 0.05;
    const struct pen_vec3 to_eye = pen_sub(input->pinhole.eye, at->p);
    const double distance = pen_length(to_eye), cosine = pen_dot(to_eye, at->normal) / distance;
    const double from = source->far ? 0 : 1 / pen_length(pen_sub(source->at, at->p));
    return angle / (pen_larger(cosine, grazing) * (2 * curved + 1 / distance + from));
}

static bool is_near(struct pen_box box, struct pen_vec3 p, double distance)
{
    return p.x >= box.lo.x - distance && p.x <= box.hi.x + distance && p.y >= box.lo.y - distance &&
           p.y <= box.hi.y + distance && p.z >= box.lo.z - distance && p.z <= box.hi.z + distance;
}

static struct pen_vec3 absolute(struct pen_vec3 v)
{
    return pen_vec3(fabs(v.x), fabs(v.y), fabs(v.z));
}

/* The bounds of an image with this half-angle as seen from its place. Returns false if the
 * primitive does not show it. */
static bool image_in(const struct pen_kernel_input *input, uint32_t prim,
                     const struct source *source, const struct place *at, double angle,
                     struct thing *thing)
{
    const struct pen_prims *prims = &input->scene->prims;
    const struct pen_vec3 half = pen_normalize(halfway(input, source, at->p));
    if (!(pen_dot(half, at->normal) > 0) || !(pen_dot(direction_to(source, at->p), at->normal) > 0))
        return false;
    angle += 2 * pen_length(pen_sub(half, at->normal)); /* for steps that end before the place */
    const double i = reach(at, input, source, angle, at->curved[0]),
                 k = reach(at, input, source, angle, at->curved[1]);
    const struct pen_vec3 axes[] = {
        pen_scale(at->along, i), pen_scale(pen_cross(at->normal, at->along), k),
        pen_scale(at->normal, 0.5 * (i * i * at->curved[0] + k * k * at->curved[1]))};
    const struct pen_vec3 off =
        pen_add(pen_add(absolute(axes[0]), absolute(axes[1])), absolute(axes[2]));
    thing->bounds.near =
        pen_beam_depth(input, (struct pen_box){pen_sub(at->p, off), pen_add(at->p, off)});
    if (!pen_prim_infinite(pen_prim_kind(prims, prim)) &&
        !is_near(pen_prim_bounds(prims, prim), at->p, i + k))
        return false;
    return pen_project_box(input, at->p, axes, &thing->hull, &thing->shear) &&
           thing->hull.count >= 3;
}

/* Adds the highlight of a light on a primitive if it is only some pixels wide: the part that is at
 * least as bright as FAINT. */
static bool add_highlight(struct pen_beams *beams, const struct pen_kernel_input *input,
                          uint32_t prim, const struct pen_light *light)
{
    static const double faint = 0.003, wide = 64;
    const struct pen_material *m = material_of(input->scene, prim);
    const struct source source = {!light->positional,
                                  light->positional ? light->position : pen_neg(light->direction)};
    struct place at;
    struct thing thing = {.fall = 0};
    if (!place_on(input, prim, &source, &at))
        return true;
    const struct pen_vec3 brought =
        pen_mul(m->ks, pen_beam_light_within(light, (struct pen_box){at.p, at.p}));
    const double most = pen_beam_largest(brought);
    if (!(most > faint))
        return true;
    const double angle = sqrt(2 * (1 - pen_pow(faint / most, 1 / m->shininess)));
    if (!(angle < 0.2) || !image_in(input, prim, &source, &at, angle, &thing) ||
        pen_hull_area(&thing.hull) > wide)
        return true;
    thing.fall = faint / most;
    set_light(&thing.bounds, brought);
    return pen_beam_add_thing(beams, &thing);
}

static bool add_highlights(struct pen_beams *beams, const struct pen_kernel_input *input)
{
    const struct pen_scene *scene = input->scene;
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        const struct pen_material *m = material_of(scene, i);
        for (uint32_t k = 0; pen_beam_largest(m->ks) > 0 && m->shininess >= PEN_BEAM_NARROW &&
                             k < scene->light_count;
             k++)
            if (!add_highlight(beams, input, i, &scene->lights[k]))
                return false;
    }
    return true;
}

/* Adds the image of a bright primitive in a round one. */
static bool add_image(struct pen_beams *beams, const struct pen_kernel_input *input,
                      uint32_t mirror, uint32_t prim)
{
    const struct pen_scene *scene = input->scene;
    const double radius = radius_around(scene, prim), blur = blur_of(scene, mirror);
    const struct source source = {false, pen_box_center(pen_prim_bounds(&scene->prims, prim))};
    struct place at;
    struct thing thing = {.fall = 0};
    if (mirror == prim || !place_on(input, mirror, &source, &at))
        return true;
    const double distance = pen_length(pen_sub(source.at, at.p));
    const double angle = radius / pen_larger(distance - radius, 1e-9);
    if (!image_in(input, mirror, &source, &at, angle + blur, &thing))
        return true;
    if (blur > 0)
        thing.bounds.most = (float)pen_smaller(1, angle * angle / (blur * blur));
    set_light(&thing.bounds, pen_mul(pen_beam_light(scene, prim), mirrored_by(scene, mirror)));
    return pen_beam_add_thing(beams, &thing);
}

/* Adds the images of bright things in round mirrors. */
static bool add_round_mirrors(struct pen_beams *beams, const struct pen_kernel_input *input)
{
    const struct pen_scene *scene = input->scene;
    for (uint32_t i = 0; i < scene->prims.count; i++) {
        if (pen_prim_infinite(pen_prim_kind(&scene->prims, i)) || !pen_beam_bright(scene, i))
            continue;
        for (uint32_t k = 0; k < scene->prims.count; k++)
            if (!pen_prim_flat(pen_prim_kind(&scene->prims, k)) && is_mirror(input, k) &&
                !add_image(beams, input, k, i))
                return false;
    }
    return true;
}

bool pen_beam_add_images(struct pen_beams *beams, const struct pen_kernel_input *input)
{
    return add_mirrors(beams, input) && add_round_mirrors(beams, input) &&
           add_highlights(beams, input);
}
