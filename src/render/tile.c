/* SPDX-License-Identifier: MIT */
/* Tiles: an image cut into squares, row by row from the top left. */
#include "render/render.h"

/* How many tiles cover `pixels` in one direction. */
static int across(int pixels, int tile)
{
    return pixels / tile + (pixels % tile != 0);
}

int pen_tile_count(int width, int height, int tile)
{
    return across(width, tile) * across(height, tile);
}

struct pen_rect pen_tile_rect(int width, int height, int tile, int index)
{
    int columns = across(width, tile);
    struct pen_rect rect = {.x = index % columns * tile, .y = index / columns * tile};
    rect.width = width - rect.x < tile ? width - rect.x : tile;
    rect.height = height - rect.y < tile ? height - rect.y : tile;
    return rect;
}
