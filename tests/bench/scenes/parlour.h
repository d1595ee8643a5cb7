/* SPDX-License-Identifier: MIT */
/* Rooms like those that a classroom ray tracer was timed with, and scenes of any size. */
#ifndef BENCH_SCENES_PARLOUR_H
#define BENCH_SCENES_PARLOUR_H

/* Writes a room of 77 primitives under two disk lights, of 400 x 600 pixels. Light samples are on a
 * jittered grid of 15 x 15 in a circle. One light hangs free. The other is in a bulb behind a
 * lampshade, and both of them transmit light. The floor and a mirror reflect. */
void parlour_soft(int size);

/* Writes the same room with chairs and a chandelier: 100 primitives, three hard lights, 1000 x 1400
 * pixels. */
void parlour_hard(int size);

/* Writes `size` spheres of equal radius at random places in a cube, under one hard light. The view
 * does not depend on their number. The radius shrinks so that they always cover about the same part
 * of the picture. */
void field(int size);

/* Writes a floor, and a row of `size` - 1 spheres whose size is a third of their distance. */
void row(int size);

/* tubes: the same floor, and `size` - 1 infinite tubes, which lean. cones: cones, which stand. */
void tubes(int size);
void cones(int size);

#endif
