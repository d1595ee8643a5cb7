/* SPDX-License-Identifier: MIT */
/* Rooms of the kind that a classroom ray tracer was timed with, and scenes of any size. */
#ifndef BENCH_SCENES_PARLOUR_H
#define BENCH_SCENES_PARLOUR_H

/* A room of 77 primitives under two disk lights, 400 x 600 pixels, with light samples on a jittered
 * grid of 15 x 15 in a circle. One light hangs free; the other is in a bulb behind a lampshade,
 * both of which transmit light. The floor and a mirror reflect. */
void parlour_soft(int size);

/* The same room with chairs and a chandelier, 100 primitives, under three hard lights, 1000 x 1400
 * pixels. */
void parlour_hard(int size);

/* `size` spheres of equal radius at random places in a cube whose view does not depend on their
 * number, under one hard light. The radius shrinks so that they cover about the same part of the
 * picture. */
void field(int size);

/* A floor and spheres of a third of their distance in a row of `size` - 1. */
void row(int size);

/* The same floor, and `size` - 1 infinite tubes, which lean; cones, which stand. */
void tubes(int size);
void cones(int size);

#endif
