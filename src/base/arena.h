/* SPDX-License-Identifier: MIT */
/* Arenas: memory with one lifetime (a scene, a request, a thread's scratch space) and a byte cap.
 * An arena is reset or freed as a whole. An allocation that exceeds the cap, or for which there is
 * no memory, returns NULL. So a hostile scene gets an error, and the process continues. */
#ifndef PEN_BASE_ARENA_H
#define PEN_BASE_ARENA_H

#include <stddef.h>

struct pen_arena;

/* Makes an arena that will hold at most cap_bytes of allocations (0: no cap).
 * Owns: the caller frees it with pen_arena_free.
 * Fails: NULL when out of memory. */
struct pen_arena *pen_arena_new(size_t cap_bytes);

/* Frees the arena and everything in it. NULL is allowed. */
void pen_arena_free(struct pen_arena *arena);

/* Discards all allocations and keeps the memory for reuse. */
void pen_arena_reset(struct pen_arena *arena);

/* Returns zeroed memory for count elements of size bytes, aligned to 64 bytes if the whole is at
 * least 64 bytes long, else to 16.
 * Fails: NULL if count * size overflows, exceeds the cap, or memory runs out. */
void *pen_arena_alloc(struct pen_arena *arena, size_t count, size_t size);

/* A copy of a string and its terminating zero.
 * Fails: NULL, as pen_arena_alloc. */
char *pen_arena_strdup(struct pen_arena *arena, const char *text);

/* Bytes allocated since the last reset, as counted against the cap. */
size_t pen_arena_used(const struct pen_arena *arena);

#endif
