/* SPDX-License-Identifier: MIT */
/* An arena is a list of blocks, filled in order. A request that does not fit in the current block
 * moves on to the next one that holds it, else to a new block at least twice as large as the last,
 * so the number of blocks stays logarithmic. What is counted against the cap is what was asked
 * for, rounded up to the alignment: block headers and unused ends of blocks are not. */
#include "base/arena.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    SMALL_ALIGN = 16,
    LARGE_ALIGN = 64, /* a cache line: arrays that are read by SIMD start on one */
    FIRST_BLOCK = 4096,
    LAST_BLOCK = 1 << 24 /* blocks grow no further than this by themselves */
};

struct block {
    struct block *next;
    size_t bytes, used; /* of the payload, which begins LARGE_ALIGN behind the block */
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

/* Where a piece of that alignment begins in the block, or SIZE_MAX if it does not fit. */
static size_t place(const struct block *b, size_t bytes, size_t align)
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
    struct block *b = aligned_alloc(LARGE_ALIGN, LARGE_ALIGN + payload);
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
    size_t wanted = count * size;
    size_t align = wanted >= LARGE_ALIGN ? LARGE_ALIGN : SMALL_ALIGN;
    if (wanted == 0)
        wanted = 1; /* nothing asked for is still a place of its own */
    size_t bytes = (wanted + SMALL_ALIGN - 1) & ~(size_t)(SMALL_ALIGN - 1);
    if (bytes > arena->cap - arena->used)
        return NULL;
    struct block *b = arena->current;
    while (b && place(b, bytes, align) == SIZE_MAX && b->next)
        b = arena->current = b->next;
    if (!b || place(b, bytes, align) == SIZE_MAX)
        b = grow(arena, bytes);
    if (!b)
        return NULL;
    size_t start = place(b, bytes, align);
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
