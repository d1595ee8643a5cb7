/* SPDX-License-Identifier: MIT */
/* The image is divided into stripes: a row of tiles has one stripe for each row of blocks in its
 * tiles. A stripe is finished when its blocks in all tiles of that row are. */
#include "render/internal/row_order.h"

#include <pthread.h>
#include <stdlib.h>

struct pen_row_order {
    const struct pen_settings *settings;
    pen_render_rows_fn *rows_done;
    void *user;
    int stripes;
    pthread_mutex_t lock;
    int told;         /* guarded by lock; number of stripes reported to rows_done */
    bool telling;     /* guarded by lock; a thread is in rows_done */
    atomic_int *left; /* by stripe, the number of unfinished blocks; atomic: the last one acquires
                         the others' pixels */
};

static int divided_up(int a, int b)
{
    return a / b + (a % b != 0);
}

static int stripes_of_tile(const struct pen_settings *s)
{
    return divided_up(s->tile, PEN_BLOCK_SIDE);
}

/* The stripe that contains row y. */
static int stripe_at(const struct pen_settings *s, int y)
{
    return y / s->tile * stripes_of_tile(s) + y % s->tile / PEN_BLOCK_SIDE;
}

/* The first row below a stripe. */
static int stripe_end(const struct pen_settings *s, int stripe)
{
    const int top = stripe / stripes_of_tile(s) * s->tile;
    const int64_t rows = (int64_t)(stripe % stripes_of_tile(s) + 1) * PEN_BLOCK_SIDE;
    const int64_t end = top + (rows < s->tile ? rows : s->tile);
    return end < s->height ? (int)end : s->height;
}

/* The number of blocks side by side. */
static int blocks_across(const struct pen_settings *s)
{
    const int last = s->width % s->tile;
    return s->width / s->tile * divided_up(s->tile, PEN_BLOCK_SIDE) +
           divided_up(last, PEN_BLOCK_SIDE);
}

struct pen_row_order *pen_row_order_new(const struct pen_settings *settings,
                                        pen_render_rows_fn *rows_done, void *user)
{
    const int stripes = stripe_at(settings, settings->height - 1) + 1;
    struct pen_row_order *order = malloc(sizeof *order);
    atomic_int *left = malloc((size_t)stripes * sizeof *left);
    if (!order || !left) {
        free(order);
        free(left);
        return NULL;
    }
    *order = (struct pen_row_order){.settings = settings,
                                    .rows_done = rows_done,
                                    .user = user,
                                    .stripes = stripes,
                                    .left = left};
    pthread_mutex_init(&order->lock, NULL);
    for (int i = 0; i < stripes; i++)
        atomic_init(&left[i], blocks_across(settings));
    return order;
}

void pen_row_order_free(struct pen_row_order *order)
{
    if (!order)
        return;
    pthread_mutex_destroy(&order->lock);
    free(order->left);
    free(order);
}

/* The number of finished stripes, from the top. Called with the lock held. */
static int finished(const struct pen_row_order *order)
{
    int end = order->told;
    while (end < order->stripes &&
           atomic_load_explicit(&order->left[end], memory_order_acquire) == 0)
        end++;
    return end;
}

/* Calls rows_done until no more rows are finished, unless another thread does so. If a stripe is
 * finished meanwhile, one of the two finds it, since both test with the lock held. */
static void tell(struct pen_row_order *order)
{
    pthread_mutex_lock(&order->lock);
    int end = order->telling ? order->told : finished(order);
    while (end > order->told) {
        order->told = end;
        order->telling = true;
        pthread_mutex_unlock(&order->lock);
        order->rows_done(order->user, stripe_end(order->settings, end - 1));
        pthread_mutex_lock(&order->lock);
        order->telling = false;
        end = finished(order);
    }
    pthread_mutex_unlock(&order->lock);
}

void pen_row_order_block_done(struct pen_row_order *order, struct pen_rect block)
{
    atomic_int *left = &order->left[stripe_at(order->settings, block.y)];
    if (atomic_fetch_sub_explicit(left, 1, memory_order_acq_rel) == 1)
        tell(order);
}
