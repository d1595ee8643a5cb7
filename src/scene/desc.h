/* SPDX-License-Identifier: MIT */
/* The description of a scene, as its document gives it: scene units, degrees, no transform applied.
 * The readers in module io fill it, after they refuse everything that api/scene-format.md forbids.
 * pen_scene_freeze converts it to the form that kernels read. All memory belongs to the reader's
 * arena. */
#ifndef PEN_SCENE_DESC_H
#define PEN_SCENE_DESC_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/arena.h"
#include "base/status.h"
#include "geom/kind.h"
#include "math/transform.h"
#include "scene/settings.h"

/* A colour that depends on the place, in the object's own coordinates: those of the document before
 * the transforms of enclosing groups. */
struct pen_pattern {
    bool checker; /* cells of edge `size`, alternately a and b; else a gradient from a to b */
    struct pen_vec3 a, b;
    double size;
    struct pen_vec3 from, to;
};

/* The colours of a material, in the order of its members. */
enum pen_material_colours {
    PEN_COLOUR_EMISSION,
    PEN_COLOUR_KA,
    PEN_COLOUR_KD,
    PEN_COLOUR_KS,
    PEN_COLOUR_KT,
    PEN_COLOUR_KR,
    PEN_MATERIAL_COLOURS
};

/* The patterns of a material's colours; NULL for a colour without one. */
struct pen_patterns {
    const struct pen_pattern *of[PEN_MATERIAL_COLOURS];
};

struct pen_material {
    struct pen_vec3 emission, ka, kd, ks, kt,
        kr; /* RGB; of a pattern, the mean of its two colours */
    double shininess, ior;
    double reflection_blur, transmission_blur; /* degrees */
    const struct pen_patterns *patterns;       /* NULL: none */
    bool ior_written; /* written in the document: then also 1 makes a solid */
};
_Static_assert(offsetof(struct pen_material, kr) == PEN_COLOUR_KR * sizeof(struct pen_vec3),
               "the colours are an array of PEN_MATERIAL_COLOURS");

/* A colour of a material by its number. */
static inline struct pen_vec3 *pen_material_colour(struct pen_material *m, int colour)
{
    return (struct pen_vec3 *)((char *)m + (size_t)colour * sizeof(struct pen_vec3));
}

/* The pattern of a colour; NULL if the colour is the same everywhere. A pattern of two equal
 * colours is the same everywhere. */
static inline const struct pen_pattern *pen_material_pattern(const struct pen_material *m,
                                                             int colour)
{
    const struct pen_pattern *p = m->patterns ? m->patterns->of[colour] : NULL;
    const bool plain = p && p->a.x == p->b.x && p->a.y == p->b.y && p->a.z == p->b.z;
    return plain ? NULL : p;
}

/* Whether some colour depends on the place. */
static inline bool pen_material_is_patterned(const struct pen_material *m)
{
    for (int i = 0; i < PEN_MATERIAL_COLOURS; i++)
        if (pen_material_pattern(m, i))
            return true;
    return false;
}

/* Whether the material makes solids of primitives with an inside, and of closed surfaces of flat
 * primitives. */
static inline bool pen_material_is_solid(const struct pen_material *m)
{
    return m->ior != 1 || m->ior_written;
}

/* The default material: emission 0, ka 1, kd ks kt kr 0, shininess 1, ior 1 and not written, no
 * blur. It is black without ambient light. */
struct pen_material pen_material_default(void);

enum pen_light_kind { PEN_LIGHT_DIRECTIONAL, PEN_LIGHT_POINT, PEN_LIGHT_SPOT };

struct pen_light_desc {
    enum pen_light_kind kind;
    bool shadows;
    struct pen_vec3 intensity, position;
    struct pen_vec3 direction; /* in which the light travels; any length */
    double attenuation[3];     /* kc, kl, kq */
    double beam_exponent;
    double radius;         /* scene units; 0: hard shadows */
    double angular_radius; /* degrees */
};

/* Whether lights of the kind have a position; if not, they are infinitely far away. */
static inline bool pen_light_positional(enum pen_light_kind kind)
{
    switch (kind) {
    case PEN_LIGHT_DIRECTIONAL:
        return false;
    case PEN_LIGHT_POINT:
    case PEN_LIGHT_SPOT:
        return true;
    }
    return false;
}

/* Whether lights of the kind have a direction. A positional light with a direction has a beam. */
static inline bool pen_light_directed(enum pen_light_kind kind)
{
    switch (kind) {
    case PEN_LIGHT_DIRECTIONAL:
    case PEN_LIGHT_SPOT:
        return true;
    case PEN_LIGHT_POINT:
        return false;
    }
    return false;
}

/* Whether the light has a disk, so that shadows it casts are soft. */
static inline bool pen_light_desc_soft(const struct pen_light_desc *light)
{
    return (pen_light_positional(light->kind) ? light->radius : light->angular_radius) > 0;
}

/* The kinds of objects: PEN_OBJECT_SPHERE and so on, with the numbers of the kinds of primitives;
 * and groups. */
enum pen_object_kind {
#define KIND(NAME, ...) PEN_OBJECT_##NAME = PEN_PRIM_##NAME,
    PEN_KINDS(KIND)
#undef KIND
        PEN_OBJECT_GROUP = PEN_PRIM_KIND_COUNT,
    PEN_OBJECT_MESH
};

/* A mesh. Vertex f is at shift + 2^exponent f. Each triangle is a primitive.
 * Owns: it borrows the arrays. A frozen scene uses them too, so they must outlive it. */
struct pen_mesh_desc {
    uint32_t vertex_count, triangle_count; /* at least one triangle */
    const float *vertex;                   /* three for each vertex, all finite */
    const uint32_t *corner;                /* three for each triangle: numbers of vertices */
    /* Normals, as struct pen_mesh (geom/mesh.h) has them. */
    const float *normal;
    const uint32_t *corner_normal;
    uint32_t normal_count;
    double shift[3];
    int exponent;
    const uint16_t *material_of; /* by triangle, index into `material`; NULL: 0 */
    uint32_t material_count;     /* at least 1 */
    const int *material;         /* indices into the scene's materials; -1: default */
};

/* The corners of a triangle in the mesh's own coordinates, before the transforms around it. */
void pen_mesh_desc_triangle(const struct pen_mesh_desc *mesh, uint32_t triangle,
                            struct pen_vec3 v[3]);

/* The meshes of a scene, also those in groups. */
struct pen_mesh_totals {
    uint64_t meshes, triangles;
};
struct pen_scene_desc;
struct pen_mesh_totals pen_desc_meshes(const struct pen_scene_desc *desc);

struct pen_object_desc {
    enum pen_object_kind kind;
    const char *name; /* NULL if it has none */
    int material;     /* index, -1: default; not used for a mesh */
    /* A triangle or polygon without area. It is no primitive, but its edges count where a solid may
     * close. */
    bool left_out;
    bool repeats_vertex; /* a polygon: its last vertex, once more, is not among `vertices` */
    union {
        struct {
            struct pen_vec3 center;
            double radius;
        } sphere;
        struct {
            struct pen_vec3 point, normal;
        } plane;
        struct {
            uint32_t count; /* 3 for a triangle */
            struct pen_vec3 *vertices;
        } polygon; /* also for a triangle */
        struct {
            struct pen_vec3 origin, axis;
            double radius;
        } infinite_cylinder;
        struct {
            struct pen_vec3 base, axis;
            double radius, height;
            bool caps;
        } cylinder;
        struct {
            struct pen_vec3 base, axis;
            double radius, top_radius, height; /* top_radius is 0 or more, and not radius */
            bool caps;
        } cone;
        struct {
            uint32_t count;
            struct pen_object_desc *objects;
            bool has_transform;
            struct pen_transform transform;
        } group;
        const struct pen_mesh_desc *mesh;
    } u;
};

enum pen_move_kind { PEN_MOVE_TRANSLATE, PEN_MOVE_ROTATE, PEN_MOVE_ORBIT };
enum pen_move_axis { PEN_AXIS_VECTOR, PEN_AXIS_FORWARD, PEN_AXIS_RIGHT, PEN_AXIS_UP };

struct pen_camera_move {
    enum pen_move_kind kind;
    enum pen_move_axis axis_kind; /* axis of a rotation; PEN_AXIS_VECTOR: `axis` */
    struct pen_vec3 axis;
    struct pen_vec3 vector; /* of a translation; the target of an orbit */
    double degrees;
};

struct pen_camera_desc {
    struct pen_vec3 position, up;
    bool default_up; /* not written; if it is parallel to the view direction, another one is used */
    bool has_look_at; /* else `direction` */
    struct pen_vec3 look_at, direction;
    bool has_view_plane; /* else `fov_degrees` */
    double plane_distance, plane_width, plane_height;
    double fov_degrees;
    double aperture_radius, focus_distance;
    uint32_t move_count;
    const struct pen_camera_move *moves;
};

struct pen_view_desc {
    const char *name;
    struct pen_camera_desc camera;
};

/* A background that changes with the elevation of a ray. It is linear in its sine, from the horizon
 * to the zenith and from the horizon to the nadir. */
struct pen_sky {
    struct pen_vec3 zenith, nadir;
    struct pen_vec3 up; /* any length */
};

struct pen_scene_desc {
    const char *name;           /* "" if it has none */
    struct pen_vec3 background; /* with a sky: its horizon */
    bool has_sky;
    struct pen_sky sky;
    struct pen_vec3 ambient;
    uint32_t view_count; /* at least 1; without "views" the one view is "main" */
    struct pen_view_desc *views;
    uint32_t material_count;
    struct pen_material *materials; /* named ones first, then inline ones */
    uint32_t light_count;
    struct pen_light_desc *lights;
    int build_threads;     /* how many build the acceleration structure; 0: one. No document can set
                              this */
    bool opaque_shadows;   /* no light passes through transmissive primitives; no document can set
                              this */
    uint32_t object_count; /* top level */
    struct pen_object_desc *objects;
    uint64_t primitive_count;     /* all primitives, also those in groups; groups do not count */
    uint32_t left_out_count;      /* objects that are left out */
    uint64_t left_out_vertices;   /* their vertices in all */
    struct pen_settings settings; /* defaults and the scene's own `render` */
    /* Omissions and choices of the reader, and probable errors of the author: code PEN_OK, place
     * and sentence. */
    uint32_t note_count;
    struct pen_status *notes;
};

/* The frame of a camera after its moves. right = forward x up; all are unit and orthogonal. */
struct pen_camera_frame {
    struct pen_vec3 eye, right, up, forward;
    bool other_up; /* not the default one, which is parallel to the view direction */
};

/* Computes the frame of a camera. A default up, [0, 1, 0], that is parallel to the view direction
 * is replaced: by [0, 0, -1] for a view down, [0, 0, 1] for a view up.
 * Fails: PEN_INVALID. Its place is the wrong key, relative to the camera object: "/up" (parallel to
 * the view direction, or zero), "/look_at" (equal to the position, or too far from it),
 * "/direction" (zero). */
bool pen_camera_frame_make(const struct pen_camera_desc *camera, struct pen_camera_frame *frame,
                           struct pen_status *st);

/* Checks the vertices of a polygon. Refuses fewer than three vertices, repeated vertices, a
 * deviation from the plane of more than 1e-6 of the extent, edges that intersect or touch, and zero
 * area.
 * Fails: PEN_INVALID with a place relative to the object, such as "/vertices/3"; PEN_NO_MEMORY.
 * Cost: O(n log n). */
bool pen_polygon_check(const struct pen_vec3 *vertices, uint32_t count, struct pen_status *st);

#endif
