/* SPDX-License-Identifier: MIT */
/* Coincident surfaces of solids are one interface. It has the index before all of them, the index
 * behind all of them, one reflectance, and the product of their kt. The first surface in the
 * document is shaded. */
#include "shade/internal/media.h"
#include "shade/internal/patterns.h"

/* A surface of a solid that the path passes. */
struct passage {
    uint32_t solid;
    bool enters;
};

struct interface {
    const struct pen_kernel_input *input;
    const struct path *path;
    const struct solid_point *at;
    struct pen_vec3 outward; /* of the first surface */
    int count;
    struct passage passage[LAYERS_MAX + 1];
    struct pen_vec3 kt;
};

/* Adds a surface. A surface that leaves a solid and one that enters it there cancel each other. */
static void add(struct interface *in, struct pen_hit hit)
{
    const struct pen_scene *scene = in->input->scene;
    const struct pen_vec3 n = pen_prim_normal(&scene->prims, hit, in->at->p);
    const bool outside = (pen_dot(n, in->outward) > 0) == in->at->outside;
    const struct passage c = {scene->solids.of_prim[hit.prim],
                              outside != (scene->solids.turned[hit.prim] != 0)};
    in->kt = pen_mul(in->kt, pen_material_at(scene, hit.prim, in->at->p, in->at->bound).kt);
    for (int i = 0; i < in->count; i++) {
        if (in->passage[i].solid == c.solid && in->passage[i].enters != c.enters) {
            in->passage[i] = in->passage[--in->count];
            return;
        }
    }
    if (in->count <= LAYERS_MAX)
        in->passage[in->count++] = c;
}

/* Removes the solids' surfaces from the layers at the path's place. */
static void take_waiting(struct interface *in, struct layers *layers)
{
    int kept = layers->next;
    for (int i = layers->next; i < layers->count; i++) {
        const struct pen_hit hit = layers->waiting[i];
        if (in->input->scene->solids.of_prim[hit.prim] != PEN_NO_SOLID)
            add(in, hit);
        else
            layers->waiting[kept++] = hit;
    }
    layers->count = kept;
}

/* Adds the surfaces that coincide with the surface that the ray starts on, after its hit. */
static void take_met(struct interface *in, struct pen_hit after)
{
    const struct pen_kernel_input *input = in->input;
    struct pen_t_interval interval = {after, 2 * PEN_LAST_LAYER_T};
    struct pen_hit hit;
    while (input->trace->nearest(input->scene->accel, &in->path->ray, &in->path->origin, &interval,
                                 &hit) &&
           hit.t <= PEN_LAST_LAYER_T) {
        interval.after = hit;
        if (input->scene->solids.of_prim[hit.prim] != PEN_NO_SOLID)
            add(in, hit);
    }
}

bool pen_solids_coincide(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                         const struct path *path, const struct solid_point *at,
                         struct solid_interface *out)
{
    const struct pen_solids *solids = &input->scene->solids;
    const bool layer = at->hit.t > PEN_FIRST_T && at->hit.t <= PEN_LAST_LAYER_T;
    if (solids->of_prim[at->hit.prim] == PEN_NO_SOLID || (!scratch->layers.any && !layer))
        return false;
    struct interface in = {.input = input, .path = path, .at = at, .kt = {1, 1, 1}};
    in.outward = pen_prim_normal(&input->scene->prims, at->hit, at->p);
    add(&in, at->hit);
    if (scratch->layers.any)
        take_waiting(&in, &scratch->layers);
    if (layer)
        take_met(&in, at->hit);
    struct media *media = media_at(scratch, media_of_path(scratch));
    struct media *behind = media_at(scratch, media_behind(scratch));
    out->unmatched = 0;
    for (int i = 0; i < in.count; i++)
        if (!in.passage[i].enters)
            out->unmatched += media_add(media, in.passage[i].solid);
    media_copy(behind, media);
    for (int i = 0; i < in.count; i++) {
        if (in.passage[i].enters)
            media_add(behind, in.passage[i].solid);
        else
            media_remove(behind, in.passage[i].solid);
    }
    out->index = media_index_without(solids, media, PEN_NO_SOLID);
    out->beyond = media_index_without(solids, behind, PEN_NO_SOLID);
    out->kt = in.kt;
    return true;
}
