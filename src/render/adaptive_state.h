/* SPDX-License-Identifier: MIT */
/* The state of an adaptive render as bytes, so that another process can go on between two rounds,
 * between two tiles of a round, or after the last round. The picture gets the same bits.
 *
 * It has the sums of all pixels, the statistics of the rounds with the number of tiles that are
 * finished of the one that goes on, and the pixels that this round refines. The latter are kept,
 * not selected again: they were chosen by the sums before the round, and those of finished tiles
 * have changed. The decision after the round needs the sums alone, so that it is the same again.
 *
 * The bytes are for this build of the program alone, since another one may decide or round
 * otherwise; they carry a text that tells builds apart. */
#ifndef PEN_RENDER_ADAPTIVE_STATE_H
#define PEN_RENDER_ADAPTIVE_STATE_H

#include "base/buf.h"
#include "render/render.h"

/* Appends the state, to an empty buffer without taking more memory than it needs; out->failed tells
 * that memory ran out. `build` has at most 255 bytes. */
void pen_adaptive_save(const struct pen_adaptive *adaptive, const struct pen_render_stats *stats,
                       const char *build, struct pen_buf *out);

/* Reads a state into one that is new, with its estimates, and the pixels into rgb. Returns false if
 * the bytes are not of this build, of this size of picture or not whole; the state stays new then.
 * Owns: the caller frees stats->tile_ms. Fails: PEN_NO_MEMORY; PEN_NOT_FOUND for bytes that cannot
 * be used. */
bool pen_adaptive_load(struct pen_adaptive *adaptive, const void *bytes, size_t count,
                       const char *build, struct pen_render_stats *stats, float *rgb,
                       struct pen_status *st);

#endif
