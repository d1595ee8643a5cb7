/* SPDX-License-Identifier: MIT */
/* The solids that contain a path: their numbers, ascending; the last one gives the index
 * (scene/solid.h). A path enters at most one solid at each surface, or several if surfaces
 * coincide; pen_kernel_scratch_new allocates room for all. A solid is either in the list or not:
 * entering or leaving it twice makes no difference. */
#ifndef PEN_SHADE_INTERNAL_MEDIA_H
#define PEN_SHADE_INTERNAL_MEDIA_H

#include <string.h>

#include "shade/internal/scratch.h"

/* The media of paths, by number: first those of the pixel kernel's stack; then the path that it
 * traces, the media behind an interface of several surfaces, and the pool of the block kernel. */
static inline struct media *media_at(const struct pen_kernel_scratch *scratch, size_t number)
{
    return (struct media *)(void *)(scratch->media + number * scratch->media_stride);
}

static inline size_t media_of_path(const struct pen_kernel_scratch *scratch)
{
    return scratch->depth;
}

static inline size_t media_behind(const struct pen_kernel_scratch *scratch)
{
    return scratch->depth + 1;
}

static inline size_t media_of_pool(const struct pen_kernel_scratch *scratch)
{
    return scratch->depth + 2;
}

/* The index of refraction within the solids of a list except one (or PEN_NO_SOLID). */
static inline double media_index_without(const struct pen_solids *solids, const struct media *m,
                                         uint32_t solid)
{
    uint32_t last = m->count;
    if (last > 0 && m->solid[last - 1] == solid)
        last--;
    return last > 0 ? solids->at[m->solid[last - 1]].ior : 1;
}

/* The same with one more solid. */
static inline double media_index_with(const struct pen_solids *solids, const struct media *m,
                                      uint32_t solid)
{
    if (m->count > 0 && m->solid[m->count - 1] > solid)
        solid = m->solid[m->count - 1];
    return solids->at[solid].ior;
}

static inline void media_copy(struct media *to, const struct media *from)
{
    to->count = from->count;
    for (uint32_t i = 0; i < from->count; i++)
        to->solid[i] = from->solid[i];
}

/* Adds a solid. Returns true if it was not in the list. */
static inline bool media_add(struct media *m, uint32_t solid)
{
    uint32_t at = m->count;
    while (at > 0 && m->solid[at - 1] > solid)
        at--;
    if (at > 0 && m->solid[at - 1] == solid)
        return false;
    for (uint32_t i = m->count++; i > at; i--)
        m->solid[i] = m->solid[i - 1];
    m->solid[at] = solid;
    return true;
}

/* Whether a solid is not in the list. */
static inline bool media_lacks(const struct media *m, uint32_t solid)
{
    for (uint32_t i = 0; i < m->count; i++)
        if (m->solid[i] == solid)
            return false;
    return true;
}

static inline void media_remove(struct media *m, uint32_t solid)
{
    uint32_t kept = 0;
    for (uint32_t i = 0; i < m->count; i++)
        if (m->solid[i] != solid)
            m->solid[kept++] = m->solid[i];
    m->count = kept;
}

/* Sets the media of a camera ray that starts at o. */
static inline void media_of_camera_ray(const struct pen_kernel_input *input, struct media *m,
                                       struct pen_vec3 o)
{
    const struct pen_scene_view *view = input->view;
    m->count = view->inside.count;
    for (uint32_t i = 0; i < m->count; i++)
        m->solid[i] = view->inside.solid[i];
    for (uint32_t i = 0; i < view->maybe.count; i++)
        if (pen_solid_contains(&input->scene->prims, &input->scene->solids, view->maybe.solid[i],
                               o))
            media_add(m, view->maybe.solid[i]);
}

/* A point on a surface of a solid. */
struct solid_point {
    struct pen_hit hit;
    struct pen_vec3 p;
    double bound;
    bool outside; /* the viewer is on the side of the outward normal */
};

/* The combined effect of coincident surfaces of solids. */
struct solid_interface {
    double index, beyond;
    struct pen_vec3 kt;
    unsigned unmatched; /* exits without an entry */
};

/* Computes the interface of all surfaces of solids that coincide with a surface which the pixel
 * kernel's path has met. They are not met again. Returns false if that surface is not among layers.
 * Else the media of the path are those before the interface, and number media_behind has those
 * behind it. */
bool pen_solids_coincide(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                         const struct path *path, const struct solid_point *at,
                         struct solid_interface *out);

#endif
