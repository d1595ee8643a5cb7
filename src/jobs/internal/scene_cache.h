/* SPDX-License-Identifier: MIT */
/* A worker's cache of frozen scenes. The key is the hash of the scene's document and the
 * accelerator. So a scene that is rendered again, for another view or another batch, is neither
 * parsed nor built again. */
#ifndef PEN_JOBS_INTERNAL_SCENE_CACHE_H
#define PEN_JOBS_INTERNAL_SCENE_CACHE_H

#include "scene/scene.h"
#include "store/store.h"

struct pen_scene_cache;

/* The time it took to get a scene; 0 if it was cached. */
struct pen_scene_times {
    double parse_ms, build_ms;
};

/* Makes a cache. cap_bytes bounds the arena of a scene; 0: no bound.
 * Owns: free with pen_scene_cache_free.
 * Fails: NULL when out of memory. */
struct pen_scene_cache *pen_scene_cache_new(size_t cap_bytes);
void pen_scene_cache_free(struct pen_scene_cache *cache);

/* Frees all scenes; the cache stays usable. */
void pen_scene_cache_empty(struct pen_scene_cache *cache);

/* Returns the frozen scene of a claim's job.
 * Owns: the cache; the scene is valid until the next call with this cache.
 * Fails: as pen_store_scene, pen_scene_load and pen_scene_freeze. */
const struct pen_scene *pen_scene_cache_get(struct pen_scene_cache *cache, struct pen_store *store,
                                            const struct pen_claim *claim,
                                            enum pen_accelerator accelerator,
                                            struct pen_scene_times *times, struct pen_status *st);

/* Reads the scene of a job into a description in the arena.
 * Fails: as pen_store_scene and pen_scene_load. */
bool pen_scene_describe(struct pen_store *store, const char *job_id, struct pen_arena *arena,
                        struct pen_scene_desc *desc, struct pen_status *st);

#endif
