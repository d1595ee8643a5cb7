/* SPDX-License-Identifier: MIT */
/* The frozen scene, as kernels read it: typed arrays of primitives in the local frame, materials,
 * lights, cameras, the acceleration structure, and the set of effects that the scene needs. It is
 * immutable after pen_scene_freeze; any number of threads may use it.
 *
 * Local frame: p_local = (p - center) * 2^-exponent. center is a multiple of 2^exponent near the
 * middle of the finite primitives; 2^exponent is near their extent. So the local coordinates keep
 * their bits if a scene is scaled by a power of two, or moved by a multiple of 2^exponent. This
 * excludes the rims of open cylinders and cones, which are extended by the rounding of the
 * document. Attenuation factors are rescaled to local lengths exactly. */
#ifndef PEN_SCENE_SCENE_H
#define PEN_SCENE_SCENE_H

#include <stdbool.h>
#include <stdint.h>

#include "accel/accel.h"
#include "scene/desc.h"
#include "scene/solid.h"

/* Effects that a kernel may simulate. A bit is set if the scene, rendered with given settings,
 * needs the effect. pen_effect_name returns the names that statistics use. */
enum pen_effect {
    PEN_FX_AMBIENT = 1 << 0,
    PEN_FX_HARD_SHADOWS = 1 << 1,
    PEN_FX_SOFT_SHADOWS = 1 << 2,
    PEN_FX_SHADOW_TRANSMITTANCE = 1 << 3,
    PEN_FX_MIRROR = 1 << 4,
    PEN_FX_TRANSMISSION = 1 << 5,
    PEN_FX_ANTI_ALIASING = 1 << 6,
    PEN_FX_SPECULAR = 1 << 7,
    PEN_FX_SKY = 1 << 8,
    PEN_FX_DEPTH_OF_FIELD = 1 << 9,
    PEN_FX_PATTERNS = 1 << 10,
    PEN_FX_REFRACTION = 1 << 11,
    PEN_FX_GLOSSY = 1 << 12,
    PEN_FX_FROSTED = 1 << 13,
    PEN_FX_SMOOTH_NORMALS = 1 << 14
};
enum { PEN_FX_COUNT = 15 };

/* The effect's name in the API ("hard_shadows") by bit number. */
const char *pen_effect_name(int bit);

struct pen_light {
    bool positional; /* else infinitely far away */
    bool beam;       /* positional, with a direction and a beam_exponent */
    bool shadows;
    bool soft; /* the light casts shadows and its radius is above 0 */
    struct pen_vec3 intensity;
    struct pen_vec3 position;  /* local frame */
    struct pen_vec3 direction; /* unit */
    double kc, kl, kq;         /* for local distances */
    double beam_exponent;
    double radius; /* of the light's disk, local frame; directional: at unit distance */
};

/* A pinhole camera. The ray through the image point (px, py), in pixels from the top left corner,
 * has direction middle + (px - half_width) dx + (py - half_height) dy (not normalised). Offsets are
 * measured from the middle of the image, so mirrored pixels have exactly mirrored rays. */
struct pen_pinhole {
    struct pen_vec3 eye; /* local frame */
    struct pen_vec3 middle, dx, dy;
    double half_width, half_height;
};

/* A thin lens around a pinhole. A ray starts at eye + a right + b up, with (a, b) on the unit disk.
 * Its direction is focus * d - (a right + b up), where d is that of the pinhole's ray. So all rays
 * to one point of the image meet in the plane in focus. */
struct pen_lens {
    bool open;                 /* the aperture's radius is above 0; else there is no lens */
    struct pen_vec3 right, up; /* as long as the radius; local frame */
    double focus;
};

/* Solids (scene/solid.h), by their numbers. */
struct pen_solid_list {
    uint32_t count;
    const uint32_t *solid; /* ascending */
};

struct pen_scene_view {
    const char *name;
    struct pen_camera_frame frame; /* scene units */
    struct pen_camera_desc camera;
    struct pen_solid_list inside; /* the solids that contain the eye and the whole lens */
    struct pen_solid_list maybe;  /* the solids that may contain some points of the lens */
};

/* A box in which a primitive may coincide with `partner`. PEN_NO_PRIM: with any of many primitives.
 */
struct pen_layer_place {
    struct pen_box box;
    uint32_t partner;
};

/* The map from the local frame to an object's own coordinates. If a point is known to `bound`, its
 * coordinate i is known to reach[i] * bound + rounding[i]. */
struct pen_own_space {
    struct pen_transform from_local;
    double reach[3], rounding[3];
};

/* The cones of a material's blurred rays: 1 - cos of their half-angles; 0: not blurred. */
struct pen_blur {
    double reflection, transmission;
};

/* For each effect of secondary rays, the largest factor in any channel by which a primitive
 * multiplies the weight of such a ray; INFINITY if weights may also grow. */
struct pen_secondary_factors {
    double mirror, transmission, refraction, glossy, frosted;
};

struct pen_scene {
    struct pen_arena *arena;
    struct pen_vec3 center; /* origin of the local frame, scene units */
    int exponent;
    struct pen_vec3 background; /* with a sky: its horizon */
    /* Up is a unit vector; without a sky, zenith and nadir are the background. */
    struct pen_sky sky;
    struct pen_vec3 ambient;
    struct pen_prims prims;
    const uint32_t *prim_material; /* by slot, index into materials: see pen_scene_material */
    const uint8_t *see_through;    /* by slot: kt > 0 in some channel */
    bool any_see_through;
    /* The places where primitives may coincide. Those of primitive i are first[i] to first[i + 1] -
     * 1. NULL if there are none. */
    const uint32_t *layer_first;
    const struct pen_layer_place *layer_place;
    const struct pen_material *materials;
    uint32_t material_count;
    const struct pen_blur *blurs; /* by material */
    const uint32_t *prim_space;   /* by slot, index into own_spaces; NULL: no patterns */
    const struct pen_own_space *own_spaces;
    bool patterned_glass;           /* the kt of some primitive is a pattern */
    struct pen_solids solids;       /* the refracting ones */
    const struct pen_light *lights; /* lights with intensity > 0 in some channel, in order */
    const uint32_t *light_index;    /* their indices in the document, part of the sampling key */
    uint32_t light_count;
    const struct pen_scene_view *views;
    uint32_t view_count;
    const struct pen_accel *accel;
    unsigned effects; /* PEN_FX_* that the scene needs with some settings */
    struct pen_secondary_factors factors;
    double freeze_ms;              /* excludes building the acceleration structure */
    struct pen_arena *description; /* of the description, if the scene has taken it; else NULL */
};

/* Makes a frozen scene from a description: transforms each primitive once, in double, chooses the
 * local frame and builds the acceleration structure.
 * Owns: the scene has its own arena of at most cap_bytes (0: unlimited). It keeps no pointer into
 * `desc`, except that meshes borrow its arrays.
 * Fails: NULL; PEN_NO_MEMORY, PEN_UNSUPPORTED, PEN_INVALID (a scene that overflows the local
 * frame). */
struct pen_scene *pen_scene_freeze(const struct pen_scene_desc *desc,
                                   enum pen_accelerator accelerator, size_t cap_bytes,
                                   struct pen_status *st);

/* Frees the scene. NULL is allowed. */
void pen_scene_free(struct pen_scene *scene);

/* Gives the scene the arena of its description, so that the arrays of meshes live as long as the
 * scene. Without meshes the arena is freed at once. */
void pen_scene_take_description(struct pen_scene *scene, struct pen_arena *arena);

/* The bytes of the scene, its acceleration structure, and the description that it has taken. */
size_t pen_scene_bytes(const struct pen_scene *scene);

/* The number of a primitive's material. */
static inline uint32_t pen_scene_material_of(const struct pen_scene *scene, uint32_t prim)
{
    return scene->prim_material[pen_prim_slot(&scene->prims, prim)];
}

/* The material of a primitive. */
static inline const struct pen_material *pen_scene_material(const struct pen_scene *scene,
                                                            uint32_t prim)
{
    return &scene->materials[pen_scene_material_of(scene, prim)];
}

/* Whether a primitive transmits light. */
static inline bool pen_scene_see_through(const struct pen_scene *scene, uint32_t prim)
{
    return pen_see_through(&scene->prims, scene->see_through, prim);
}

/* The number of the view with this name, or -1. */
int pen_scene_find_view(const struct pen_scene *scene, const char *name);

/* The pinhole of a view for an image size. */
struct pen_pinhole pen_scene_pinhole(const struct pen_scene *scene, int view, int width,
                                     int height);

/* The lens around that pinhole. */
struct pen_lens pen_scene_lens(const struct pen_scene *scene, int view,
                               const struct pen_pinhole *pinhole);

/* Whether some view has a lens. */
bool pen_desc_has_lens(const struct pen_scene_desc *desc);

/* The number of camera rays of a pixel; with a target error, the maximum. */
int pen_camera_samples(bool lens, const struct pen_settings *settings);

/* The effects that a render of one view with these settings simulates. */
unsigned pen_scene_effects(const struct pen_scene *scene, int view,
                           const struct pen_settings *settings);

/* The effects of all views together. */
unsigned pen_desc_effects(const struct pen_scene_desc *desc, const struct pen_settings *settings);

/* Whether paths fork: some primitive's material both reflects and transmits. */
bool pen_desc_forks(const struct pen_scene_desc *desc);

/* Whether effects blur rays: glossy reflection or frosted transmission. */
static inline bool pen_effects_blur(unsigned effects)
{
    return effects & (PEN_FX_GLOSSY | PEN_FX_FROSTED);
}

#endif
