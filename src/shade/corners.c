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

struct corner *pen_corner_at(struct corners *corners)
{
    for (int i = 0; i < corners->count; i++)
        if (corners->at[i].first == corners->surfaces + 1 && corners->at[i].step > 0)
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
        corners->at[i] = (struct corner){.first = corners->link.first,
                                         .p = corners->link.p,
                                         .n = corners->link.n,
                                         .bound = corners->link.bound};
    corners->count = i + 1;
    return &corners->at[i];
}

/* Adds to the corner's way a share of the direction along its surface away from a face. Returns the
 * squared sine of their angle; 1 if they are taken for parallel. */
static double turn_away(struct corner *corner, struct pen_vec3 face, double share)
{
    const struct pen_vec3 along = pen_along(face, corner->n, -pen_dot(face, corner->n));
    const double sine_sq = pen_dot(along, along);
    if (!(sine_sq >= SINE_SQ_LEAST))
        return 1;
    corner->away = pen_along(corner->away, along, share / sqrt(sine_sq));
    return sine_sq;
}

/* Moves the ray to the corner's surface farther, away from two faces. The ways away from them have
 * other shares each time, since some lead to the edge of the two. */
static bool move_farther(struct corner *corner, struct pen_vec3 face, struct pen_vec3 other)
{
    if (++corner->tries > CORNER_TRIES)
        return false;
    const double sine_sq = turn_away(corner, face, 1),
                 other_sq = turn_away(corner, other, 1.0 / (1 + corner->tries));
    const double step = STEP_LEAST * corner->bound / fmin(sine_sq, other_sq);
    corner->step = fmin(fmax(step, 2 * corner->step), STEP_MOST * corner->bound);
    return pen_dot(corner->away, corner->away) >= SINE_SQ_LEAST;
}

/* Whether a point is near a corner's first surface. */
static bool is_near(struct pen_vec3 p, struct pen_vec3 first, double bound)
{
    const struct pen_vec3 apart = pen_sub(p, first);
    return pen_dot(apart, apart) <= APART_MOST * bound * (APART_MOST * bound);
}

bool pen_corner_avoid(struct corner *corner, struct pen_vec3 p, struct pen_vec3 n)
{
    if (is_near(p, corner->p, corner->bound) && move_farther(corner, n, n))
        return true;
    corner->step = 0;
    corner->tries = CORNER_TRIES;
    return false;
}

bool pen_corner_met(struct corners *corners, const struct corner_hit *hit)
{
    struct corner_link *link = &corners->link;
    const bool near = link->first > 0 && is_near(hit->p, link->p, hit->bound);
    corners->surfaces++;
    corners->again = false;
    if (near && hit->hardly_left) {
        struct corner *corner = corner_of_link(corners);
        corners->again = corner && move_farther(corner, hit->n, link->left);
    }
    if (!near)
        *link = (struct corner_link){
            .p = hit->p, .n = hit->n, .bound = hit->bound, .first = corners->surfaces};
    link->left = hit->n;
    return corners->again;
}
