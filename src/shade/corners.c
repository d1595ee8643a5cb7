/* SPDX-License-Identifier: MIT */
#include "shade/internal/corners.h"

#include <math.h>
#include <stddef.h>

/* Of bound(p): the shortest step in a right angle, the longest step, and how far apart the hits of
 * a wedge are at most. */
#define STEP_LEAST 0x1p5
#define STEP_MOST 0x1p25
#define APART_MOST 0x1p28

/* The sine of the smallest angle between faces that are told apart, squared. */
#define SINE_SQ_LEAST 0x1p-20

const struct corner *pen_corner_at(const struct corners *corners)
{
    for (int i = 0; i < corners->count; i++)
        if (corners->at[i].first == corners->surfaces + 1)
            return &corners->at[i];
    return NULL;
}

/* The corner of the link's first surface. Those of later surfaces are forgotten: when it moves, so
 * do they. NULL if there is no room. */
static struct corner *corner_of_link(struct corners *corners)
{
    int i = 0;
    while (i < corners->count && corners->at[i].first < corners->link.first)
        i++;
    if (i == CORNERS_MAX)
        return NULL;
    if (i == corners->count || corners->at[i].first != corners->link.first)
        corners->at[i] = (struct corner){.first = corners->link.first};
    corners->count = i + 1;
    return &corners->at[i];
}

/* Adds to the corner's way the direction along the first surface, of unit normal n, away from a
 * face. Returns the squared sine of their angle; 1 if they are taken for parallel. */
static double turn_away(struct corner *corner, struct pen_vec3 n, struct pen_vec3 face)
{
    const struct pen_vec3 along = pen_along(face, n, -pen_dot(face, n));
    const double sine_sq = pen_dot(along, along);
    if (!(sine_sq >= SINE_SQ_LEAST))
        return 1;
    corner->away = pen_along(corner->away, along, 1 / sqrt(sine_sq));
    return sine_sq;
}

/* Moves the ray to the link's first surface farther away. */
static bool move(struct corners *corners, const struct corner_hit *hit)
{
    const struct corner_link *link = &corners->link;
    struct corner *corner = corner_of_link(corners);
    if (!corner || ++corner->tries > CORNER_TRIES)
        return false;
    const double left = turn_away(corner, link->n, link->left);
    const double met = turn_away(corner, link->n, hit->n);
    const double bound = fmax(link->bound, hit->bound);
    const double step = STEP_LEAST * bound / fmin(left, met);
    corner->step = fmin(fmax(step, 2 * corner->step), STEP_MOST * bound);
    return pen_dot(corner->away, corner->away) >= SINE_SQ_LEAST;
}

bool pen_corner_met(struct corners *corners, const struct corner_hit *hit)
{
    struct corner_link *link = &corners->link;
    const struct pen_vec3 apart = pen_sub(hit->p, link->p);
    const double most = APART_MOST * hit->bound;
    const bool near = link->first > 0 && pen_dot(apart, apart) <= most * most;
    corners->surfaces++;
    corners->again = near && hit->hardly_left && move(corners, hit);
    if (!near)
        *link = (struct corner_link){
            .p = hit->p, .n = hit->n, .bound = hit->bound, .first = corners->surfaces};
    link->left = hit->n;
    return corners->again;
}
