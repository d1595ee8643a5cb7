/* SPDX-License-Identifier: MIT */
/* Translates a scene (standard input, JSON or XML) into a scene for POV-Ray 3.7 (standard output)
 * with the same primitives, camera, lights and size. So both renderers do the same work. The
 * pictures are close, but not equal.
 *
 * These are translated exactly: primitives with the transforms of their groups, the view, point,
 * spot and directional lights with or without shadows, attenuation with kl = 0, the diffuse and
 * Phong terms, mirrors, transparency, and the limits of depth and contribution.
 *
 * These are approximated:
 *   - kl > 0: matched at the light's distance from the middle of the scene;
 *   - coloured kt: POV-Ray's filter also colours the diffuse term;
 *   - coloured ks: its brightness is used;
 *   - ambient light, which POV-Ray shows in mirrors too;
 *   - refraction: POV-Ray has Fresnel's reflection or that by kr, not both;
 *   - lights with a radius: a circular area light that faces the point, with the same number of
 *     samples, none left out.
 *
 * usage: to_pov < SCENE > SCENE.pov      the first line states width and height */
#include "bench/load_scene.h"
#include "math/exact.h"

/* POV-Ray scales a layer's own light by its opacity, so that none may be fully clear. */
#define FULLY_CLEAR 0.98

struct camera {
    struct pen_camera_frame frame;
    double distance, width, height;
    struct pen_vec3 middle; /* of the scene, roughly */
};

static void put(const char *before, struct pen_vec3 v)
{
    printf("%s<%.17g, %.17g, %.17g>", before, v.x, v.y, v.z);
}

static double most(struct pen_vec3 v)
{
    return fmax(v.x, fmax(v.y, v.z));
}

static double sum(struct pen_vec3 v)
{
    return v.x + v.y + v.z;
}

/* The finish's own light: emission, and ambient light as far as the material sends it back. */
static struct pen_vec3 glow_of(const struct pen_material *m, struct pen_vec3 ambient)
{
    return pen_vec3(m->emission.x + ambient.x * m->ka.x, m->emission.y + ambient.y * m->ka.y,
                    m->emission.z + ambient.z * m->ka.z);
}

static double own(double glow, double pigment, double opacity)
{
    return glow / (pigment * opacity);
}

static void put_texture(const struct pen_material *m, uint32_t number, struct pen_vec3 ambient)
{
    double clear = fmin(most(m->kt), FULLY_CLEAR), opacity = 1 - clear, diffuse = 1;
    bool coloured = m->kt.x != m->kt.y || m->kt.y != m->kt.z;
    struct pen_vec3 pigment = pen_scale(m->kd, 1 / opacity), glow = glow_of(m, ambient);
    if (coloured) { /* the pigment must carry the colour of kt */
        pigment = pen_scale(m->kt, 1 / most(m->kt));
        diffuse = sum(m->kd) / fmax(sum(pigment) * opacity, 1e-9);
    }
    pigment = pen_vec3(fmax(pigment.x, 1e-4), fmax(pigment.y, 1e-4), fmax(pigment.z, 1e-4));
    printf("#declare Texture%u = texture { pigment { color rgb ", (unsigned)number);
    put("", pigment);
    printf(" %s %.9g } finish { ambient 0 diffuse %.9g emission rgb ",
           coloured ? "filter" : "transmit", clear, diffuse);
    put("", pen_vec3(own(glow.x, pigment.x, opacity), own(glow.y, pigment.y, opacity),
                     own(glow.z, pigment.z, opacity)));
    if (most(m->ks) > 0)
        printf(" phong %.9g phong_size %.9g", sum(m->ks) / 3, fmax(m->shininess, 1e-3));
    if (most(m->kr) > 0) {
        put(" reflection { rgb ", m->kr);
        printf(" }");
    } else if (m->ior != 1) {
        printf(" reflection { 0, 1 fresnel on } conserve_energy");
    }
    printf(" } }\n");
}

/* The material of an object, and what it is made of. */
static void put_material(const struct pen_material *materials, int number)
{
    printf("texture { Texture%d }", number);
    if (materials[number].ior != 1)
        printf(" interior { ior %.17g }", materials[number].ior);
    printf(" }\n");
}

static void put_flat(const struct pen_object_desc *o, const struct pen_transform *t)
{
    uint32_t count = o->u.polygon.count;
    if (o->kind == PEN_OBJECT_TRIANGLE)
        printf("triangle { ");
    else
        printf("polygon { %u, ", (unsigned)count + 1);
    for (uint32_t i = 0; i < count; i++)
        put(i ? ", " : "", pen_transform_point(t, o->u.polygon.vertices[i]));
    if (o->kind != PEN_OBJECT_TRIANGLE)
        put(", ", pen_transform_point(t, o->u.polygon.vertices[0]));
    printf(" ");
}

/* |x - o|^2 - (a.(x - o))^2 = r^2 as POV-Ray's ten coefficients. */
static void put_tube(struct pen_vec3 origin, struct pen_vec3 axis, double radius)
{
    struct pen_vec3 a = pen_normalize(axis), o = pen_along(origin, a, -pen_dot(origin, a));
    put("quadric { ", pen_vec3(1 - a.x * a.x, 1 - a.y * a.y, 1 - a.z * a.z));
    put(", ", pen_vec3(-2 * a.x * a.y, -2 * a.x * a.z, -2 * a.y * a.z));
    put(", ", pen_scale(o, -2));
    printf(", %.17g ", pen_dot(o, o) - radius * radius);
}

static struct pen_vec3 top_of(struct pen_vec3 base, struct pen_vec3 axis, double height)
{
    return pen_along(base, pen_normalize(axis), height);
}

/* A primitive without its closing brace. */
static void put_primitive(const struct pen_object_desc *o, const struct pen_transform *t)
{
    double scale = 1;
    pen_transform_similarity(t, &scale);
    switch (o->kind) {
    case PEN_OBJECT_SPHERE:
        put("sphere { ", pen_transform_point(t, o->u.sphere.center));
        printf(", %.17g ", o->u.sphere.radius * scale);
        break;
    case PEN_OBJECT_PLANE: {
        struct pen_vec3 n = pen_normalize(pen_transform_normal(t, o->u.plane.normal));
        put("plane { ", n);
        printf(", %.17g ", pen_dot(n, pen_transform_point(t, o->u.plane.point)));
        break;
    }
    case PEN_OBJECT_TRIANGLE:
    case PEN_OBJECT_POLYGON:
        put_flat(o, t);
        break;
    case PEN_OBJECT_INFINITE_CYLINDER:
        put_tube(pen_transform_point(t, o->u.infinite_cylinder.origin),
                 pen_transform_vector(t, o->u.infinite_cylinder.axis),
                 o->u.infinite_cylinder.radius * scale);
        break;
    case PEN_OBJECT_CYLINDER:
        put("cylinder { ", pen_transform_point(t, o->u.cylinder.base));
        put(", ", pen_transform_point(
                      t, top_of(o->u.cylinder.base, o->u.cylinder.axis, o->u.cylinder.height)));
        printf(", %.17g %s", o->u.cylinder.radius * scale, o->u.cylinder.caps ? "" : "open ");
        break;
    case PEN_OBJECT_CONE:
        put("cone { ", pen_transform_point(t, o->u.cone.base));
        printf(", %.17g", o->u.cone.radius * scale);
        put(", ", pen_transform_point(t, top_of(o->u.cone.base, o->u.cone.axis, o->u.cone.height)));
        printf(", %.17g %s", o->u.cone.top_radius * scale, o->u.cone.caps ? "" : "open ");
        break;
    case PEN_OBJECT_GROUP:
    case PEN_OBJECT_MESH:
        break;
    }
}

static void put_objects(const struct pen_object_desc *objects, uint32_t count,
                        const struct pen_material *materials, const struct pen_transform *t)
{
    for (uint32_t i = 0; i < count; i++) {
        const struct pen_object_desc *o = &objects[i];
        if (o->kind == PEN_OBJECT_GROUP) {
            struct pen_transform inner =
                o->u.group.has_transform ? pen_transform_compose(t, &o->u.group.transform) : *t;
            put_objects(o->u.group.objects, o->u.group.count, materials, &inner);
        } else if (!o->left_out) {
            put_primitive(o, t);
            if (o->material < 0)
                printf("texture { pigment { color rgb 0 } } }\n");
            else
                put_material(materials, o->material);
        }
    }
}

/* POV-Ray's light fades as I * 2 / (1 + (d / fade_distance)^2). */
static void put_faded(const struct pen_light_desc *light, struct pen_vec3 middle)
{
    double kc = light->attenuation[0], kl = light->attenuation[1], kq = light->attenuation[2];
    struct pen_vec3 apart = pen_sub(light->position, middle);
    if (kl > 0) /* the same light in the middle of the scene, all of the fall-off in kq */
        kq += kl / fmax(sqrt(pen_dot(apart, apart)), 1e-6);
    put("", light->position);
    if (kq == 0) {
        put(" color rgb ", pen_scale(light->intensity, 1 / kc));
        return;
    }
    kc = fmax(kc, 1e-6 * kq);
    put(" color rgb ", pen_scale(light->intensity, 0.5 / kc));
    printf(" fade_power 2 fade_distance %.9g", sqrt(kc / kq));
}

static void put_light(const struct pen_light_desc *light, struct pen_vec3 middle, int samples)
{
    printf("light_source { ");
    if (light->kind == PEN_LIGHT_DIRECTIONAL) {
        if (light->angular_radius > 0)
            bench_fail("no translation for directional lights with an angular_radius");
        put("", pen_along(middle, pen_normalize(light->direction), -1e5));
        put(" color rgb ", light->intensity);
        put(" parallel point_at ", middle);
    } else {
        put_faded(light, middle);
    }
    if (light->kind == PEN_LIGHT_SPOT) { /* no sharp cone: cos^tightness everywhere */
        put(" spotlight point_at ", pen_add(light->position, light->direction));
        printf(" radius 89.9 falloff 90 tightness %.9g", light->beam_exponent);
    }
    if (light->radius > 0 && light->shadows)
        printf(" area_light <%.9g, 0, 0>, <0, %.9g, 0>, %d, %d circular orient jitter",
               2 * light->radius, 2 * light->radius, (int)ceil(sqrt(samples)),
               (int)ceil(sqrt(samples)));
    printf("%s }\n", light->shadows ? "" : " shadowless");
}

static struct camera camera_of(const struct pen_camera_desc *desc, double aspect)
{
    struct camera c = {.distance = 1};
    struct pen_status st;
    if (!pen_camera_frame_make(desc, &c.frame, &st))
        bench_fail(st.msg);
    c.height = 2 * tan(desc->fov_degrees * 3.14159265358979323846 / 360);
    c.width = c.height * aspect;
    if (desc->has_view_plane) {
        c.distance = desc->plane_distance;
        c.width = desc->plane_width;
        c.height = desc->plane_height;
    }
    c.middle =
        desc->has_look_at ? desc->look_at : pen_along(c.frame.eye, c.frame.forward, c.distance);
    return c;
}

static void put_scene(const struct pen_scene_desc *desc)
{
    const struct pen_settings *set = &desc->settings;
    struct pen_transform identity = pen_transform_identity();
    struct camera c = camera_of(&desc->views[0].camera, (double)set->width / set->height);
    printf("// width=%d height=%d\n#version 3.7;\n", set->width, set->height);
    printf("global_settings { assumed_gamma 1.0 max_trace_level %d adc_bailout %.9g }\n",
           set->max_depth, set->min_contribution);
    put("background { color rgb ", desc->background);
    put(" }\ncamera { perspective location ", c.frame.eye);
    put(" direction ", pen_scale(c.frame.forward, c.distance));
    put(" right ", pen_scale(c.frame.right, c.width));
    put(" up ", pen_scale(c.frame.up, c.height));
    printf(" }\n");
    for (uint32_t i = 0; i < desc->light_count; i++)
        put_light(&desc->lights[i], c.middle, set->light_samples);
    for (uint32_t i = 0; i < desc->material_count; i++)
        put_texture(&desc->materials[i], i, desc->ambient);
    put_objects(desc->objects, desc->object_count, desc->materials, &identity);
}

int main(void)
{
    struct pen_arena *arena = pen_arena_new(0);
    size_t bytes;
    char *text = bench_read(&bytes);
    struct pen_scene_desc desc = bench_load(text, bytes, arena);
    put_scene(&desc);
    pen_arena_free(arena);
    free(text);
    return fflush(stdout) ? 1 : 0;
}
