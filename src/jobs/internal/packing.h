/* SPDX-License-Identifier: MIT */
/* The thread that packs tiles for the store while others are still being rendered, so that a commit
 * finds them ready: packing a batch takes several times as long as storing it. */
#ifndef PEN_JOBS_INTERNAL_PACKING_H
#define PEN_JOBS_INTERNAL_PACKING_H

#include "render/render.h"
#include "store/store.h"

struct pen_packing;

/* Some tiles of an image. */
struct pen_tile_run {
    const struct pen_settings *settings;
    int first, count;
    const float *image; /* all of it, by rows */
};

/* Starts the thread. observer: told of what each batch took ("pack"); NULL: none. Owns: free with
 * pen_packing_free. */
struct pen_packing *pen_packing_new(const struct pen_store_observer *observer,
                                    struct pen_status *st);
void pen_packing_free(struct pen_packing *packing);

/* Begins with a batch. The run's image and settings stay until pen_packing_end. Fails:
 * PEN_NO_MEMORY. */
bool pen_packing_begin(struct pen_packing *packing, const struct pen_tile_run *run,
                       struct pen_status *st);

/* Says that a tile's pixels are in the image: what pen_render_task calls as tile_done. */
void pen_packing_tile_done(void *packing, struct pen_rect rect);

/* Waits until the batch, all of whose tiles are done, is packed. *packed: valid until the next
 * batch begins. Fails: PEN_NO_MEMORY. */
bool pen_packing_end(struct pen_packing *packing, const struct pen_pixels **packed,
                     struct pen_status *st);

/* Lets go of a batch that did not come out. */
void pen_packing_drop(struct pen_packing *packing);

#endif
