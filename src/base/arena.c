/* SPDX-License-Identifier: MIT */
/* An arena is a list of blocks that are filled in order. A request that does not fit into the
 * current block uses the next block that has space for it, else a new one. New blocks double in
 * size up to LAST_BLOCK, so that there are few. The cap counts the requested bytes, rounded up to
 * SMALL_ALIGN. It does not count block headers and unused ends of blocks. */
#include "base/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

enum {
    SMALL_ALIGN = 16,
    LARGE_ALIGN = 64, /* a cache line, at which arrays for SIMD code begin */
    FIRST_BLOCK = 4096,
    HUGE_BLOCK = 1 << 22, /* from here on blocks use huge pages, of which at most one is wasted */
    LAST_BLOCK = 1 << 24  /* a block is larger than this only for one large request */
};

struct block {
    struct block *next;
    size_t bytes, used; /* of the payload, LARGE_ALIGN bytes after the start of the block */
};

struct pen_arena {
    struct block *first, *current;
    size_t cap, used, next_bytes;
};

_Static_assert(sizeof(struct block) <= LARGE_ALIGN, "a block's header must fit before its payload");

struct pen_arena *pen_arena_new(size_t cap_bytes)
{
    struct pen_arena *arena = calloc(1, sizeof *arena);
    if (!arena)
        return NULL;
    arena->cap = cap_bytes ? cap_bytes : SIZE_MAX;
    arena->next_bytes = FIRST_BLOCK;
    return arena;
}

void pen_arena_free(struct pen_arena *arena)
{
    if (!arena)
        return;
    for (struct block *b = arena->first, *next; b; b = next) {
        next = b->next;
        free(b);
    }
    free(arena);
}

void pen_arena_reset(struct pen_arena *arena)
{
    for (struct block *b = arena->first; b; b = b->next)
        b->used = 0;
    arena->current = arena->first;
    arena->used = 0;
}

/* The offset in a block at which an allocation would begin, or SIZE_MAX if it does not fit. */
static size_t offset_in(const struct block *b, size_t bytes, size_t align)
{
    size_t start = (b->used + align - 1) & ~(align - 1);
    return start <= b->bytes && bytes <= b->bytes - start ? start : SIZE_MAX;
}

/* Appends a block that holds at least `bytes` and makes it the current one. */
static struct block *grow(struct pen_arena *arena, size_t bytes)
{
    size_t payload = bytes > arena->next_bytes ? bytes : arena->next_bytes;
    if (payload > SIZE_MAX / 2)
        return NULL;
    payload = (payload + LARGE_ALIGN - 1) & ~(size_t)(LARGE_ALIGN - 1);
    struct block *b = payload < HUGE_BLOCK ? aligned_alloc(LARGE_ALIGN, LARGE_ALIGN + payload)
                                           : pen_memory_large(LARGE_ALIGN + payload);
    if (!b)
        return NULL;
    *b = (struct block){.next = NULL, .bytes = payload};
    if (!arena->current) {
        arena->first = b;
    } else {
        b->next = arena->current->next;
        arena->current->next = b;
    }
    arena->current = b;
    if (arena->next_bytes < LAST_BLOCK)
        arena->next_bytes *= 2;
    return b;
}

void *pen_arena_alloc(struct pen_arena *arena, size_t count, size_t size)
{
    if (size && count > (SIZE_MAX - LARGE_ALIGN) / size)
        return NULL;
    size_t requested = count * size;
    size_t align = requested >= LARGE_ALIGN ? LARGE_ALIGN : SMALL_ALIGN;
    if (requested == 0)
        requested = 1; /* an allocation of 0 bytes also has its own address */
    size_t bytes = (requested + SMALL_ALIGN - 1) & ~(size_t)(SMALL_ALIGN - 1);
    if (bytes > arena->cap - arena->used)
        return NULL;
    struct block *b = arena->current;
    while (b && offset_in(b, bytes, align) == SIZE_MAX && b->next)
        b = arena->current = b->next;
    if (!b || offset_in(b, bytes, align) == SIZE_MAX)
        b = grow(arena, bytes);
    if (!b)
        return NULL;
    size_t start = offset_in(b, bytes, align);
    b->used = start + bytes;
    arena->used += bytes;
    return memset((char *)b + LARGE_ALIGN + start, 0, bytes);
}

char *pen_arena_strdup(struct pen_arena *arena, const char *text)
{
    size_t bytes = strlen(text) + 1;
    char *copy = pen_arena_alloc(arena, bytes, 1);
    return copy ? memcpy(copy, text, bytes) : NULL;
}

size_t pen_arena_used(const struct pen_arena *arena)
{
    return arena->used;
}
