/* SPDX-License-Identifier: MIT */
/* Open addressing with linear probing, at most 3/4 full. */
#include "io/mesh/build.h"

#include <sys/random.h>

enum { SLOTS_MIN = 1 << 12 };

__extension__ typedef unsigned __int128 wide;

static uint64_t hash(const struct pen_weld *w, const float v[3])
{
    const float plus[3] = {v[0] + 0.0f, v[1] + 0.0f, v[2] + 0.0f}; /* -0 becomes 0 */
    uint32_t bits[3];
    memcpy(bits, plus, sizeof bits);
    wide product = (wide)((bits[0] | (uint64_t)bits[1] << 32) ^ w->key[0]) * (bits[2] ^ w->key[1]);
    return (uint64_t)product ^ (uint64_t)(product >> 64);
}

/* The slot of the first vertex at this place, or the empty slot for it. */
static uint32_t *find(const struct pen_weld *w, const struct pen_build *b, const float v[3])
{
    for (uint64_t i = hash(w, v);; i++) {
        uint32_t *slot = &w->slot[i & w->mask];
        if (*slot == 0)
            return slot;
        const float *other = b->m->vertex[*slot - 1];
        if (other[0] == v[0] && other[1] == v[1] && other[2] == v[2])
            return slot;
    }
}

static bool grow(struct pen_weld *w, struct pen_build *b)
{
    struct pen_weld more = *w;
    const uint64_t slots = w->slot ? ((uint64_t)w->mask + 1) * 2 : SLOTS_MIN;
    if (!w->slot && getrandom(more.key, sizeof more.key, GRND_NONBLOCK) < 0)
        more.key[0] = more.key[1] = UINT64_C(0x9E3779B97F4A7C15);
    if (!(more.slot = pen_build_zeroed(b, slots, sizeof *more.slot)))
        return false;
    more.mask = (uint32_t)(slots - 1);
    for (uint64_t i = 0; w->slot && i <= w->mask; i++)
        if (w->slot[i])
            *find(&more, b, b->m->vertex[w->slot[i] - 1]) = w->slot[i];
    pen_weld_release(w, b);
    *w = more;
    return true;
}

uint32_t pen_weld_vertex(struct pen_weld *w, struct pen_build *b, uint32_t vertex)
{
    if (w->used >= w->mask / 4 * 3 && !grow(w, b))
        return UINT32_MAX;
    uint32_t *slot = find(w, b, b->m->vertex[vertex]);
    if (*slot == 0) {
        *slot = vertex + 1;
        w->used++;
    }
    return *slot - 1;
}

void pen_weld_release(struct pen_weld *w, struct pen_build *b)
{
    pen_build_free(b, w->slot, w->slot ? (uint64_t)w->mask + 1 : 0, sizeof *w->slot);
    *w = (struct pen_weld){0};
}
