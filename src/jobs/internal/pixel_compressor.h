/* SPDX-License-Identifier: MIT */
/* Pixel compression: a thread that compresses finished tiles for the store while others are still
 * being rendered, so that a commit finds them ready. Compressing a batch takes several times as
 * long as storing it.
 *
 * Threads: one thread calls begin, and later end or cancel; render threads call tile_done. */
#ifndef PEN_JOBS_INTERNAL_PIXEL_COMPRESSOR_H
#define PEN_JOBS_INTERNAL_PIXEL_COMPRESSOR_H

#include "render/render.h"
#include "store/store.h"

struct pen_pixel_compressor;

/* Consecutive tiles of an image. */
struct pen_tile_run {
    const struct pen_settings *settings;
    int first, count;
    const float *image; /* all of it, by rows */
};

/* Starts the thread. Owns: free with pen_pixel_compressor_free. Fails: PEN_NO_MEMORY. */
struct pen_pixel_compressor *pen_pixel_compressor_new(struct pen_status *st);
void pen_pixel_compressor_free(struct pen_pixel_compressor *compressor);

/* Begins a batch. The run's image and settings stay until pen_pixel_compressor_end or _cancel.
 * Fails: PEN_NO_MEMORY. */
bool pen_pixel_compressor_begin(struct pen_pixel_compressor *compressor,
                                const struct pen_tile_run *run, struct pen_status *st);

/* Notes that a tile's pixels are in the image: tile_done of a pen_render_task, whose user is the
 * compressor. */
void pen_pixel_compressor_tile_done(void *compressor, struct pen_rect rect);

/* Notes that the batch ends after its first `count` tiles, which are done. */
void pen_pixel_compressor_cut(struct pen_pixel_compressor *compressor, int count);

/* Waits until the batch is compressed; all of its tiles must be done. *encoded is valid until the
 * next batch begins. Fails: PEN_NO_MEMORY. */
bool pen_pixel_compressor_end(struct pen_pixel_compressor *compressor,
                              const struct pen_pixels **encoded, struct pen_status *st);

/* Ends a batch whose render has failed. */
void pen_pixel_compressor_cancel(struct pen_pixel_compressor *compressor);

#endif
