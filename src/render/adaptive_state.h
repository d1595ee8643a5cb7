/* SPDX-License-Identifier: MIT */
/* The state of an adaptive render as bytes. Another process can continue from it: between two
 * rounds, between two tiles of a round, or after the last round. The picture gets the same bits.
 *
 * The state contains the sums of all pixels and the statistics of the rounds, with the number of
 * finished tiles of the current round. It also contains the pixels that this round refines. They
 * are stored rather than selected again: they were chosen by the sums before the round, and those
 * of finished tiles have changed. The decision after the round needs only the sums, so it is the
 * same again.
 *
 * Only the same build of the program can read the bytes, because another build may decide or round
 * differently. They contain a text that identifies the build. */
#ifndef PEN_RENDER_ADAPTIVE_STATE_H
#define PEN_RENDER_ADAPTIVE_STATE_H

#include "base/buf.h"
#include "render/render.h"

/* Appends the state to an empty buffer, without taking more memory than it needs. out->failed is
 * set if memory ran out. `build` has at most 255 bytes. */
void pen_adaptive_save(const struct pen_adaptive *adaptive, const struct pen_render_stats *stats,
                       const char *build, struct pen_buf *out);

/* Reads a state into a new one, with its estimates, and the pixels into rgb. Returns false, and the
 * state stays new, if the bytes are incomplete or of another build or another picture size.
 * Owns: the caller frees stats->tile_ms.
 * Fails: PEN_NO_MEMORY; PEN_NOT_FOUND for bytes that cannot be used. */
bool pen_adaptive_load(struct pen_adaptive *adaptive, const void *bytes, size_t count,
                       const char *build, struct pen_render_stats *stats, float *rgb,
                       struct pen_status *st);

#endif
