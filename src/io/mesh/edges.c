/* SPDX-License-Identifier: MIT */
/* Open and crowded edges. Edges are sorted by their lower vertex, by counting. Then the edges of
 * one vertex are counted by their upper vertex. So the time is proportional to their number. */
#include "io/mesh/build.h"

struct edge {
    uint32_t lower, upper;
};

struct edges {
    const uint32_t *corner; /* of triangles; NULL: the edges are `open` */
    struct edge *open;
    uint64_t count;
    uint32_t *begin;     /* of the edges of each lower vertex */
    uint32_t *upper;     /* of each edge */
    unsigned char *seen; /* 0 to 3, by upper vertex; 0 between lower vertices */
};

static inline struct edge edge_of(const struct edges *e, uint64_t i)
{
    const uint32_t p = e->corner ? e->corner[i] : e->open[i].lower,
                   q = e->corner ? e->corner[i % 3 == 2 ? i - 2 : i + 1] : e->open[i].upper;
    return (struct edge){p < q ? p : q, p < q ? q : p};
}

/* Afterwards the edges of vertex v are at begin[v - 1] to begin[v]. */
static void sort(struct edges *e, uint32_t vertices)
{
    uint32_t sum = 0;
    for (uint64_t i = 0; i < e->count; i++)
        e->begin[edge_of(e, i).lower]++;
    for (uint32_t v = 0; v < vertices; v++) {
        uint32_t count = e->begin[v];
        e->begin[v] = sum;
        sum += count;
    }
    for (uint64_t i = 0; i < e->count; i++) {
        struct edge edge = edge_of(e, i);
        e->upper[e->begin[edge.lower]++] = edge.upper;
    }
}

/* Counts open and crowded edges. With `open`, writes the open ones there. */
static void count(const struct edges *e, struct pen_model *m, struct edge *open)
{
    uint32_t open_edges = 0, crowded_edges = 0, from = 0;
    for (uint32_t v = 0; v < m->vertex_count; v++) {
        const uint32_t *first = e->upper + from, *end = e->upper + e->begin[v];
        for (const uint32_t *u = first; u < end; u++)
            e->seen[*u] = (unsigned char)(e->seen[*u] + (e->seen[*u] < 3));
        for (const uint32_t *u = first; u < end; u++) {
            const unsigned char seen = e->seen[*u];
            if (seen == 1 && open)
                open[open_edges] = (struct edge){v, *u};
            open_edges += seen == 1;
            crowded_edges += seen == 3;
            e->seen[*u] = 0;
        }
        from = e->begin[v];
    }
    m->open_edges = open_edges;
    m->crowded_edges = crowded_edges;
}

/* Counts the edges; *open gets a list of the open ones, if it is not NULL. */
static bool count_edges(struct pen_build *b, struct edges *e, struct edge **open)
{
    struct pen_model *m = b->m;
    const uint64_t vertices = m->vertex_count;
    bool ok = (e->begin = pen_build_zeroed(b, vertices, sizeof *e->begin)) &&
              (e->upper = pen_build_alloc(b, e->count, sizeof *e->upper)) &&
              (e->seen = pen_build_zeroed(b, vertices, 1));
    if (ok) {
        sort(e, m->vertex_count);
        count(e, m, NULL);
    }
    if (ok && open && m->open_edges > 0) {
        ok = (*open = pen_build_alloc(b, m->open_edges, sizeof **open)) != NULL;
        count(e, m, *open);
    }
    pen_build_free(b, e->seen, vertices, 1);
    pen_build_free(b, e->upper, e->count, sizeof *e->upper);
    pen_build_free(b, e->begin, vertices, sizeof *e->begin);
    return ok;
}

/* Open edges may be seams, where a file has vertices twice. They are counted again with their ends
 * joined by place. */
bool pen_build_edges(struct pen_build *b)
{
    struct pen_model *m = b->m;
    struct edges all = {.corner = m->corner[0], .count = 3 * (uint64_t)m->triangle_count};
    struct edges seams = {.open = NULL};
    struct pen_weld weld = {0};
    if (!count_edges(b, &all, b->file->kind == PEN_MODEL_STL ? NULL : &seams.open))
        return false;
    const uint32_t crowded = m->crowded_edges, open = m->open_edges;
    bool ok = true;
    seams.count = seams.open ? open : 0;
    for (uint32_t i = 0; ok && i < seams.count; i++) {
        uint32_t *lower = &seams.open[i].lower, *upper = &seams.open[i].upper;
        ok = (*lower = pen_weld_vertex(&weld, b, *lower)) != UINT32_MAX &&
             (*upper = pen_weld_vertex(&weld, b, *upper)) != UINT32_MAX;
    }
    pen_weld_release(&weld, b);
    if (ok && seams.open)
        ok = count_edges(b, &seams, NULL);
    m->crowded_edges += seams.open ? crowded : 0;
    pen_build_free(b, seams.open, open, sizeof *seams.open);
    return ok;
}
