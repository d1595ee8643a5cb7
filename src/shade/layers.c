/* SPDX-License-Identifier: MIT */
/* The hits of a path in a scene with coincident surfaces. The first hit by t is the anchor of a
 * class: the anchor and all later hits of the ray that are layers of it. The class is visited in
 * document order. Then the search continues after the anchor, without the hits already visited. So
 * no hit is lost or visited twice, however near other hits are. */
#include "shade/internal/scratch.h"

static bool is_ahead(const struct layers *layers, struct pen_hit hit)
{
    for (int i = 0; i < layers->ahead_count; i++) {
        const struct pen_hit *a = &layers->ahead[i];
        if (a->prim == hit.prim && a->part == hit.part && a->t == hit.t)
            return true;
    }
    return false;
}

/* The first hit in the interval that is neither visited nor waiting. */
static bool search(const struct pen_kernel_input *input, const struct layers *layers,
                   const struct path *path, struct pen_t_interval interval, struct pen_hit *hit)
{
    while (input->trace->nearest(input->scene->accel, &path->ray, &path->origin, &interval, hit)) {
        if (!is_ahead(layers, *hit))
            return true;
        interval.after = *hit;
    }
    return false;
}

/* Hits that the search has passed cannot be found again. */
static void pass(struct layers *layers, struct pen_hit anchor)
{
    int kept = 0;
    for (int i = 0; i < layers->ahead_count; i++)
        if (pen_hit_before(anchor, layers->ahead[i]))
            layers->ahead[kept++] = layers->ahead[i];
    layers->ahead_count = kept;
    layers->after = anchor;
}

/* Adds a hit to those that wait, in document order. */
static void wait_for(struct layers *layers, struct pen_hit hit)
{
    int at = layers->count++;
    for (; at > 0 && hit.prim < layers->waiting[at - 1].prim; at--)
        layers->waiting[at] = layers->waiting[at - 1];
    layers->waiting[at] = hit;
}

/* The anchor of a class. */
struct anchor {
    struct pen_hit hit;
    double bound; /* the distance by which its point may be off by rounding */
};

/* Adds a hit behind the anchor if it is a layer of it and has not been visited. */
static void add_layer(const struct pen_kernel_input *input, struct layers *layers,
                      const struct path *path, const struct anchor *anchor, struct pen_hit hit)
{
    if (layers->count == LAYERS_MAX || layers->ahead_count == LAYERS_MAX ||
        !pen_hit_before(anchor->hit, hit) || is_ahead(layers, hit) ||
        !pen_prim_layers(&input->scene->prims, &path->ray, anchor->hit, hit, anchor->bound))
        return;
    wait_for(layers, hit);
    layers->ahead[layers->ahead_count++] = hit;
}

/* Adds all layers that a search finds. */
static void add_all(const struct pen_kernel_input *input, struct layers *layers,
                    const struct path *path, const struct anchor *anchor)
{
    double end = pen_prim_layers_end(&input->scene->prims, &path->ray, anchor->hit, anchor->bound);
    struct pen_t_interval interval = {anchor->hit, end};
    struct pen_hit hit;
    while (layers->count < LAYERS_MAX && search(input, layers, path, interval, &hit)) {
        interval.after = hit;
        add_layer(input, layers, path, anchor, hit);
    }
}

/* Adds the intersections with one primitive. */
static void add_partner(const struct pen_kernel_input *input, struct layers *layers,
                        const struct path *path, const struct anchor *anchor, uint32_t partner)
{
    struct pen_intersections all;
    pen_prim_intersect(&input->scene->prims, partner, &path->ray, &path->origin, &all);
    for (int i = 0; i < all.count; i++)
        add_layer(input, layers, path, anchor, (struct pen_hit){all.t[i], partner, all.part[i]});
}

static bool contains(const struct pen_box *b, struct pen_vec3 p)
{
    return p.x >= b->lo.x && p.x <= b->hi.x && p.y >= b->lo.y && p.y <= b->hi.y && p.z >= b->lo.z &&
           p.z <= b->hi.z;
}

/* Whether a place of the hit's primitive, where it may have layers, contains the hit. */
static bool layers_at(const struct pen_scene *scene, const struct pen_ray *ray, struct pen_hit hit)
{
    const struct pen_vec3 p = pen_along(ray->o, ray->d, hit.t);
    const struct pen_layer_place *place = &scene->layer_place[scene->layer_first[hit.prim]];
    const struct pen_layer_place *end = &scene->layer_place[scene->layer_first[hit.prim + 1]];
    for (; place < end; place++)
        if (contains(&place->box, p))
            return true;
    return false;
}

/* Finds the anchor's class. */
static void collect(const struct pen_kernel_input *input, struct layers *layers,
                    const struct path *path, struct pen_hit first)
{
    const struct pen_scene *scene = input->scene;
    const struct pen_vec3 near = pen_along(path->ray.o, path->ray.d, first.t);
    const struct pen_vec3 p = pen_prim_point(&scene->prims, first, &path->ray);
    const struct anchor anchor = {
        first, pen_origin_at(&scene->prims, &path->ray, &path->origin, first, p).bound};
    for (uint32_t i = scene->layer_first[first.prim]; i < scene->layer_first[first.prim + 1]; i++) {
        const struct pen_layer_place *place = &scene->layer_place[i];
        if (!contains(&place->box, near))
            continue;
        if (place->partner == PEN_NO_PRIM)
            add_all(input, layers, path, &anchor);
        else
            add_partner(input, layers, path, &anchor, place->partner);
    }
}

/* Begins the class of the first hit that has not been visited. If there are no layers, and none of
 * earlier classes are left, the ray is outside layers again. */
static void begin_class(const struct pen_kernel_input *input, struct layers *layers,
                        const struct path *path, struct pen_hit *hit)
{
    pass(layers, *hit);
    layers->next = 0;
    layers->count = 1;
    layers->waiting[0] = *hit;
    if (layers_at(input->scene, &path->ray, *hit))
        collect(input, layers, path, *hit);
    layers->any = layers->count > 1 || layers->ahead_count > 0;
    *hit = layers->waiting[layers->next++];
}

void pen_layers_begin(const struct pen_kernel_input *input, struct layers *layers,
                      const struct path *path, struct pen_hit *hit)
{
    if (!layers_at(input->scene, &path->ray, *hit))
        return;
    layers->ahead_count = 0;
    begin_class(input, layers, path, hit);
}

bool pen_layers_met(const struct pen_kernel_input *input, const struct path *path,
                    struct pen_hit hit)
{
    struct layers layers;
    layers.any = false;
    pen_layers_begin(input, &layers, path, &hit);
    return layers.any;
}

bool pen_layers_next(const struct pen_kernel_input *input, struct layers *layers,
                     const struct path *path, struct pen_hit *hit)
{
    if (layers->next == layers->count) {
        if (!search(input, layers, path, (struct pen_t_interval){layers->after, INFINITY}, hit))
            return false;
        begin_class(input, layers, path, hit);
        return true;
    }
    *hit = layers->waiting[layers->next++];
    return true;
}
