/* SPDX-License-Identifier: MIT */
/* Follows which rows of an image are finished, while blocks of it are finished in any order, and
 * tells a function so, row by row from the top. A thread that finishes rows while another is in
 * that function does not wait: the other goes on with those rows. */
#ifndef PEN_RENDER_INTERNAL_ROW_ORDER_H
#define PEN_RENDER_INTERNAL_ROW_ORDER_H

#include "render/render.h"

struct pen_row_order;

/* Owns: free with pen_row_order_free. The settings stay until then. Fails: NULL when out of memory.
 */
struct pen_row_order *pen_row_order_new(const struct pen_settings *settings,
                                        pen_render_rows_fn *rows_done, void *user);
void pen_row_order_free(struct pen_row_order *order);

/* Notes that a block of a tile is in the image, and calls rows_done for rows that are finished.
 * Threads: any number at once. */
void pen_row_order_block_done(struct pen_row_order *order, struct pen_rect block);

#endif
