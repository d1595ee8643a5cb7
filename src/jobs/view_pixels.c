/* SPDX-License-Identifier: MIT */
/* Committed pixels are stored tile by tile, and each tile row by row from the top. So the pixels of
 * a batch are one contiguous run of values. */
#include <string.h>

#include "jobs/internal/view_pixels.h"

#include "render/render.h"
#include "render/transfer.h"

/* Returns the number of pixels in the tiles before tile `index`. All rows of tiles have the full
 * height, except possibly the last. */
static int64_t pixels_before(const struct pen_settings *s, int index)
{
    int across = pen_tile_count(s->width, 1, s->tile);
    int64_t row = index / across, column = index % across;
    int64_t top = row * s->tile;
    int64_t height = s->height - top < s->tile ? s->height - top : s->tile;
    if (height <= 0)
        return (int64_t)s->width * s->height;
    return top * s->width + column * s->tile * height;
}

int64_t pen_tiles_pixels(const struct pen_settings *settings, int first, int count)
{
    return pixels_before(settings, first + count) - pixels_before(settings, first);
}

void pen_tiles_gather(const struct pen_settings *settings, int first, int count, const float *image,
                      float *tiles)
{
    for (int i = first; i < first + count; i++) {
        struct pen_rect r = pen_tile_rect(settings->width, settings->height, settings->tile, i);
        size_t row = (size_t)r.width * 3;
        for (int y = r.y; y < r.y + r.height; y++, tiles += row)
            memcpy(tiles, image + 3 * ((size_t)y * (size_t)settings->width + (size_t)r.x),
                   row * sizeof *tiles);
    }
}

void pen_tiles_scatter(const struct pen_settings *settings, int first, int count,
                       const float *tiles, float *image)
{
    for (int i = first; i < first + count; i++) {
        struct pen_rect r = pen_tile_rect(settings->width, settings->height, settings->tile, i);
        size_t row = (size_t)r.width * 3;
        for (int y = r.y; y < r.y + r.height; y++, tiles += row)
            memcpy(image + 3 * ((size_t)y * (size_t)settings->width + (size_t)r.x), tiles,
                   row * sizeof *tiles);
    }
}

struct loading {
    const struct pen_settings *settings;
    struct pen_film *film;
    unsigned char *mask, *begins;
    int64_t filled;
    bool outside; /* a batch lies outside the image: the store is damaged */
};

static void mark_tiles(const struct loading *load, int first, int count)
{
    const struct pen_settings *s = load->settings;
    for (int i = first; i < first + count; i++) {
        struct pen_rect r = pen_tile_rect(s->width, s->height, s->tile, i);
        for (int y = r.y; y < r.y + r.height; y++)
            memset(load->mask + (size_t)y * (size_t)s->width + (size_t)r.x, 1, (size_t)r.width);
    }
}

static bool place_batch(void *user, int first, int count, const float *rgb, int64_t pixels)
{
    struct loading *load = user;
    const struct pen_settings *s = load->settings;
    int total = pen_tile_count(s->width, s->height, s->tile);
    load->outside = first < 0 || count < 0 || first > total || count > total - first ||
                    pixels != pen_tiles_pixels(s, first, count);
    if (load->outside)
        return false;
    pen_tiles_scatter(s, first, count, rgb, load->film->rgb);
    if (load->mask)
        mark_tiles(load, first, count);
    if (load->begins && count > 0)
        load->begins[first] = 1;
    load->filled += pixels;
    return true;
}

bool pen_view_pixels_load(struct pen_store *store, const char *id, int view,
                          const struct pen_settings *settings, struct pen_film *film,
                          unsigned char *mask, unsigned char *begins, int64_t *filled,
                          struct pen_status *st)
{
    struct loading load = {.settings = settings, .film = film, .mask = mask, .begins = begins};
    if (!pen_store_pixels(store, id, view, place_batch, &load, st))
        return false;
    *filled = load.filled;
    return !load.outside || pen_fail(st, PEN_STORAGE, "job %s has pixels outside its image", id);
}

static struct pen_png_options png_options(const struct pen_settings *settings, int bits)
{
    return (struct pen_png_options){.bits = bits, .transfer = pen_settings_transfer(settings)};
}

struct pen_png_writer *pen_view_png_begin(const struct pen_film *film,
                                          const struct pen_settings *settings, struct pen_buf *out,
                                          struct pen_status *st)
{
    struct pen_png_options options = png_options(settings, 8);
    return pen_png_begin(film, &options, out, st);
}

bool pen_view_encode(const struct pen_film *film, const struct pen_settings *settings,
                     const char *format, struct pen_buf *out, struct pen_status *st)
{
    struct pen_png_options options = png_options(settings, strcmp(format, "png16") == 0 ? 16 : 8);
    if (strcmp(format, "pfm") == 0)
        return pen_pfm_write(film, out, st);
    return pen_png_write(film, &options, out, st);
}
