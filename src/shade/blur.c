/* SPDX-License-Identifier: MIT */
/* Directions in a cone. A point of the unit disk at distance r from its middle is mapped to the
 * direction whose cosine with the cone's axis is 1 - r^2 (1 - cos a). So equal areas have equal
 * solid angles (Lambert's azimuthal projection).
 *
 * If the surface cuts the cone, points beyond its horizon are replaced by independent ones, each
 * uniform on the disk, until one is not beyond it. So each direction is uniform in the remaining
 * part of the cone. If nothing is cut, all are points of one Sobol' set. At least half of the cone
 * remains, because its axis is on the right side. So no more than 64 points are tried; after these,
 * with a probability of 2^-64, the axis is used. */
#include "shade/internal/blur.h"

#include "math/frame.h"

enum { TRIES = 64 };

static struct pen_vec3 direction_at(struct pen_vec3 axis, const struct pen_across *across,
                                    double spread, struct pen_point2 on_square)
{
    const struct pen_point2 p = pen_disk_of_square(on_square);
    const double square = p.x * p.x + p.y * p.y, down = spread * square;
    const double aside = sqrt(spread * (2 - down));
    const struct pen_vec3 d = pen_along(pen_scale(across->u, p.x * aside), across->v, p.y * aside);
    return pen_along(d, axis, 1 - down);
}

void pen_blur_next(struct pen_kernel_scratch *scratch, size_t entry, struct path *path)
{
    struct blurred *b = &scratch->blurred[entry];
    const uint64_t hash = pen_sample_hash(&b->key);
    const uint32_t sample = b->next++;
    const struct pen_vec3 axis = pen_normalize(path->ray.d), p = path->ray.o;
    const struct pen_across across = pen_across(axis);
    struct pen_vec3 d = direction_at(axis, &across, b->spread, pen_sobol2(hash, sample));
    for (uint32_t i = 0; !(pen_dot(d, b->side) > b->least); i++) {
        if (i == TRIES) {
            d = axis;
            break;
        }
        d = direction_at(axis, &across, b->spread, pen_random2(hash, TRIES * sample + i));
    }
    path->node = pen_sample_blurred_node(b->key.node, b->reflected, sample);
    pen_ray_make(&path->ray, p, d);
}
