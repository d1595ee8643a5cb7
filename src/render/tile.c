/* SPDX-License-Identifier: MIT */
/* Divides an image into square tiles, numbered row by row from the top left. */
#include "render/render.h"

/* The number of tiles that cover `pixels` along one axis. */
static int tiles_along(int pixels, int tile)
{
    return pixels / tile + (pixels % tile != 0);
}

int pen_tile_count(int width, int height, int tile)
{
    return tiles_along(width, tile) * tiles_along(height, tile);
}

struct pen_rect pen_tile_rect(int width, int height, int tile, int index)
{
    int columns = tiles_along(width, tile);
    struct pen_rect rect = {.x = index % columns * tile, .y = index / columns * tile};
    rect.width = width - rect.x < tile ? width - rect.x : tile;
    rect.height = height - rect.y < tile ? height - rect.y : tile;
    return rect;
}
