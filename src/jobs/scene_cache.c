/* SPDX-License-Identifier: MIT */
/* A short list with the most recently used scene in front. Scenes at its end are freed when there
 * are more than ENTRIES, or when all scenes together exceed bytes_max. The scene in use always
 * stays. */
#include "jobs/internal/scene_cache.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "io/document.h"
#include "jobs/internal/jobs.h"

enum { ENTRIES = 16 };
static const size_t bytes_max = (size_t)512 << 20;

struct entry {
    unsigned char sha256[32];
    enum pen_accelerator accelerator;
    struct pen_scene *scene;
    size_t bytes;
};

struct pen_scene_cache {
    size_t cap_bytes;
    int count;
    struct entry entry[ENTRIES];
};

struct pen_scene_cache *pen_scene_cache_new(size_t cap_bytes)
{
    struct pen_scene_cache *cache = calloc(1, sizeof *cache);
    if (cache)
        cache->cap_bytes = cap_bytes;
    return cache;
}

static void drop_last(struct pen_scene_cache *cache)
{
    pen_scene_free(cache->entry[--cache->count].scene);
}

void pen_scene_cache_empty(struct pen_scene_cache *cache)
{
    while (cache->count > 0)
        drop_last(cache);
}

void pen_scene_cache_free(struct pen_scene_cache *cache)
{
    if (cache)
        pen_scene_cache_empty(cache);
    free(cache);
}

static void put_in_front(struct pen_scene_cache *cache, int from)
{
    struct entry entry = cache->entry[from];
    memmove(&cache->entry[1], &cache->entry[0], (size_t)from * sizeof entry);
    cache->entry[0] = entry;
}

/* Frees scenes from the end of the list until a new scene of this size may be added. */
static void evict_for(struct pen_scene_cache *cache, size_t bytes)
{
    for (int i = 0; i < cache->count; i++)
        bytes += cache->entry[i].bytes;
    while (cache->count > 0 && (cache->count == ENTRIES || bytes > bytes_max)) {
        bytes -= cache->entry[cache->count - 1].bytes;
        drop_last(cache);
    }
}

/* Limits for a stored document. The api process has accepted it under its own limits, so only the
 * limits that protect the parser remain. */
static struct pen_limits open_limits(void)
{
    struct pen_limits limits = pen_limits_default();
    limits.body_bytes = limits.parsed_bytes = SIZE_MAX;
    limits.objects = UINT64_MAX;
    limits.pixels_per_view = UINT64_MAX;
    limits.views = UINT32_MAX;
    limits.work = HUGE_VAL;
    return limits;
}

static bool parse(const struct pen_buf *text, struct pen_arena *arena, struct pen_scene_desc *desc,
                  struct pen_status *st)
{
    struct pen_limits limits = open_limits();
    struct pen_errors errors = {0};
    if (pen_scene_load((const char *)text->data, text->bytes, &limits, arena, desc, &errors))
        return true;
    *st = errors.item[0];
    return false;
}

bool pen_scene_describe(struct pen_store *store, const char *job_id, struct pen_arena *arena,
                        struct pen_scene_desc *desc, struct pen_status *st)
{
    struct pen_buf text = {0};
    bool ok = pen_store_scene(store, job_id, &text, st) && parse(&text, arena, desc, st);
    pen_buf_release(&text);
    return ok;
}

static struct pen_scene *load(const struct pen_scene_cache *cache, const struct pen_buf *text,
                              enum pen_accelerator accelerator, struct pen_scene_times *times,
                              struct pen_status *st)
{
    const struct pen_limits limits = open_limits();
    struct pen_scene_desc desc;
    struct pen_scene *scene = NULL;
    int64_t begin_ns = pen_clock_ns();
    struct pen_arena *arena = pen_arena_new(cache->cap_bytes);
    if (!arena) {
        pen_fail(st, PEN_NO_MEMORY, "no memory for a scene");
        return NULL;
    }
    if (parse(text, arena, &desc, st)) {
        times->parse_ms = pen_ms_since(begin_ns);
        begin_ns = pen_clock_ns();
        scene = pen_scene_freeze(&desc, accelerator, cache->cap_bytes, st);
        if (!scene && st->at[0])
            pen_text_locate((const char *)text->data, text->bytes, &limits, st);
        times->build_ms = pen_ms_since(begin_ns);
    }
    if (scene)
        pen_scene_take_description(scene, arena);
    else
        pen_arena_free(arena);
    return scene;
}

const struct pen_scene *pen_scene_cache_get(struct pen_scene_cache *cache, struct pen_store *store,
                                            const struct pen_claim *claim,
                                            enum pen_accelerator accelerator,
                                            struct pen_scene_times *times, struct pen_status *st)
{
    *times = (struct pen_scene_times){0};
    for (int i = 0; i < cache->count; i++) {
        const struct entry *e = &cache->entry[i];
        if (e->accelerator == accelerator &&
            memcmp(e->sha256, claim->scene_sha256, sizeof e->sha256) == 0) {
            put_in_front(cache, i);
            return cache->entry[0].scene;
        }
    }
    struct pen_buf text = {0};
    struct pen_scene *scene = pen_store_scene(store, claim->job_id, &text, st)
                                  ? load(cache, &text, accelerator, times, st)
                                  : NULL;
    pen_buf_release(&text);
    if (!scene)
        return NULL;
    struct entry entry = {
        .accelerator = accelerator, .scene = scene, .bytes = pen_scene_bytes(scene)};
    memcpy(entry.sha256, claim->scene_sha256, sizeof entry.sha256);
    evict_for(cache, entry.bytes);
    cache->entry[cache->count++] = entry;
    put_in_front(cache, cache->count - 1);
    return scene;
}
