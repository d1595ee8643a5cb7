/* SPDX-License-Identifier: MIT */
#include "render/adaptive_state.h"

#include <stdlib.h>
#include <string.h>

static const char magic[8] = "PENADP5";

static const double ms_max = 1e12; /* 30 years: a time that can be counted in nanoseconds */

/* The part before the build's text, the times of tiles, the sums, and the wanted pixels. */
struct header {
    char magic[8];
    uint32_t width, height, tiles, build_bytes;
    int32_t threads, float_resets;
    double render_ms, cpu_ms;
    struct pen_ray_counts rays;
    struct pen_adaptive_stats adaptive;
};

static size_t pixels_of(const struct pen_settings *s)
{
    return (size_t)s->width * (size_t)s->height;
}

static size_t tiles_of(const struct pen_settings *s)
{
    return (size_t)pen_tile_count(s->width, s->height, s->tile);
}

/* The largest size of a state, with 256 bytes for the build. */
static size_t state_bytes(const struct pen_settings *settings)
{
    return sizeof(struct header) + 256 + tiles_of(settings) * sizeof(double) +
           pixels_of(settings) * (sizeof(struct pen_pixel_sums) + 1);
}

void pen_adaptive_save(const struct pen_adaptive *adaptive, const struct pen_render_stats *stats,
                       const char *build, struct pen_buf *out)
{
    const struct pen_settings *s = adaptive->settings;
    struct header h;
    memset(&h, 0, sizeof h);
    memcpy(h.magic, magic, sizeof h.magic);
    h.width = (uint32_t)s->width;
    h.height = (uint32_t)s->height;
    h.tiles = stats->tile_ms ? (uint32_t)tiles_of(s) : 0;
    h.build_bytes = (uint32_t)strlen(build);
    h.threads = stats->threads;
    h.float_resets = stats->float_resets;
    h.render_ms = stats->render_ms;
    h.cpu_ms = stats->cpu_ms;
    h.rays = stats->rays;
    h.adaptive = stats->adaptive;
    pen_buf_reserve(out, out->bytes + state_bytes(s)); /* which may be gigabytes */
    pen_buf_add(out, &h, sizeof h);
    pen_buf_add(out, build, h.build_bytes);
    if (h.tiles > 0)
        pen_buf_add(out, stats->tile_ms, h.tiles * sizeof *stats->tile_ms);
    pen_buf_add(out, adaptive->sums, pixels_of(s) * sizeof *adaptive->sums);
    pen_buf_add(out, adaptive->wanted, pixels_of(s));
}

/* Whether a byte is a valid bool. Using another byte as a bool is undefined. */
static bool is_bool(const bool *at)
{
    unsigned char byte;
    memcpy(&byte, at, sizeof byte);
    return byte <= 1;
}

/* Whether statistics are of rounds with this target, which have ended or one of which is
 * unfinished. */
static bool fits(const struct pen_adaptive_stats *a, const struct pen_settings *s)
{
    if (!is_bool(&a->met) || !is_bool(&a->timed) || !is_bool(&a->ended))
        return false;
    const bool target = a->target == s->target_error && a->rounds >= 0;
    if (a->ended)
        return target && a->rounds > 0 && a->rounds <= PEN_ROUNDS_MAX;
    return target && a->rounds < PEN_ROUNDS_MAX && a->round[a->rounds].tiles >= 0 &&
           (size_t)a->round[a->rounds].tiles < tiles_of(s);
}

/* Whether a header and the bytes after it are of these settings and this build. */
static bool is_usable(const struct header *h, const unsigned char *rest, size_t count,
                      const struct pen_settings *s, const char *build)
{
    const size_t tiles = h->tiles * sizeof(double),
                 pixels = pixels_of(s) * (sizeof(struct pen_pixel_sums) + 1);
    return memcmp(h->magic, magic, sizeof magic) == 0 && h->width == (uint32_t)s->width &&
           h->height == (uint32_t)s->height && (h->tiles == 0 || h->tiles == tiles_of(s)) &&
           h->build_bytes == strlen(build) && count == h->build_bytes + tiles + pixels &&
           memcmp(rest, build, h->build_bytes) == 0 && fits(&h->adaptive, s) && h->render_ms >= 0 &&
           h->render_ms < ms_max;
}

bool pen_adaptive_load(struct pen_adaptive *adaptive, const void *bytes, size_t count,
                       const char *build, struct pen_render_stats *stats, float *rgb,
                       struct pen_status *st)
{
    const struct pen_settings *s = adaptive->settings;
    const unsigned char *rest = (const unsigned char *)bytes + sizeof(struct header);
    struct header h;
    if (count < sizeof h)
        return pen_fail(st, PEN_NOT_FOUND, "no state of an adaptive render");
    memcpy(&h, bytes, sizeof h);
    if (!is_usable(&h, rest, count - sizeof h, s, build))
        return pen_fail(st, PEN_NOT_FOUND, "the state is of another build or another picture");
    *stats = (struct pen_render_stats){.render_ms = h.render_ms,
                                       .cpu_ms = h.cpu_ms,
                                       .threads = h.threads,
                                       .float_resets = h.float_resets,
                                       .rays = h.rays,
                                       .tile_count = (uint32_t)tiles_of(s),
                                       .adaptive = h.adaptive};
    rest += h.build_bytes;
    if (h.tiles > 0) {
        stats->tile_ms = malloc(h.tiles * sizeof *stats->tile_ms);
        if (!stats->tile_ms)
            return pen_fail(st, PEN_NO_MEMORY, "out of memory for the times of %u tiles", h.tiles);
        memcpy(stats->tile_ms, rest, h.tiles * sizeof *stats->tile_ms);
        rest += h.tiles * sizeof *stats->tile_ms;
    }
    memcpy(adaptive->sums, rest, pixels_of(s) * sizeof *adaptive->sums);
    adaptive->refined = h.adaptive.rounds > 0;
    memcpy(adaptive->wanted, rest + pixels_of(s) * sizeof *adaptive->sums, pixels_of(s));
    for (size_t i = 0; i < pixels_of(s); i++)
        pen_adaptive_estimate(adaptive, i, &rgb[3 * i]);
    return true;
}
