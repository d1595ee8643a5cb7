/* SPDX-License-Identifier: MIT */
/* Tracks which rows of an image are finished, while its blocks are finished in any order. It
 * reports them to a function, row by row from the top. A thread that finishes rows while another
 * thread is in that function does not wait: the other thread also reports these rows. */
#ifndef PEN_RENDER_INTERNAL_ROW_ORDER_H
#define PEN_RENDER_INTERNAL_ROW_ORDER_H

#include "render/render.h"

struct pen_row_order;

/* Makes a tracker. The settings must stay valid until it is freed.
 * Owns: free with pen_row_order_free.
 * Fails: NULL when out of memory. */
struct pen_row_order *pen_row_order_new(const struct pen_settings *settings,
                                        pen_render_rows_fn *rows_done, void *user);
void pen_row_order_free(struct pen_row_order *order);

/* Records that a block of a tile is in the image, and calls rows_done for finished rows.
 * Threads: any number at the same time. */
void pen_row_order_block_done(struct pen_row_order *order, struct pen_rect block);

#endif
