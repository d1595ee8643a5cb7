/* SPDX-License-Identifier: MIT */
#include "render/internal/audit_clusters.h"

#include <stdbool.h>

enum { SIDE = PEN_AUDIT_CELLS_SIDE };

static void extend(struct pen_audit_cell *cell, const struct pen_audit_cell *by)
{
    if (cell->wrong == 0) {
        *cell = *by;
        return;
    }
    cell->wrong += by->wrong;
    cell->left = by->left < cell->left ? by->left : cell->left;
    cell->top = by->top < cell->top ? by->top : cell->top;
    cell->right = by->right > cell->right ? by->right : cell->right;
    cell->bottom = by->bottom > cell->bottom ? by->bottom : cell->bottom;
}

void pen_audit_note_wrong(struct pen_audit_cell cells[PEN_AUDIT_CELLS],
                          const struct pen_settings *settings, size_t at)
{
    const int width = settings->width, x = (int)(at % (size_t)width), y = (int)(at / (size_t)width);
    const int column = (int)((int64_t)x * SIDE / width),
              row = (int)((int64_t)y * SIDE / settings->height);
    extend(&cells[row * SIDE + column], &(struct pen_audit_cell){1, x, y, x, y});
}

/* Removes a cell, and all cells of its cluster, from those that are left. */
static struct pen_audit_cell take_cluster(const struct pen_audit_cell *cells, bool *left, int first)
{
    struct pen_audit_cell sum = {.wrong = 0};
    int waiting[PEN_AUDIT_CELLS], count = 0;
    waiting[count++] = first;
    left[first] = false;
    while (count > 0) {
        const int at = waiting[--count], column = at % SIDE, row = at / SIDE;
        extend(&sum, &cells[at]);
        for (int i = 0; i < 9; i++) {
            const int x = column + i % 3 - 1, y = row + i / 3 - 1, next = y * SIDE + x;
            if (x < 0 || y < 0 || x >= SIDE || y >= SIDE || !left[next])
                continue;
            left[next] = false;
            waiting[count++] = next;
        }
    }
    return sum;
}

/* Inserts a cluster after those with as many wrong pixels, if it is one of the largest. */
static void insert(struct pen_audit *audit, const struct pen_audit_cell *sum)
{
    int at = audit->clusters < PEN_AUDIT_CLUSTERS ? audit->clusters++ : PEN_AUDIT_CLUSTERS;
    for (; at > 0 && audit->cluster[at - 1].wrong < sum->wrong; at--)
        if (at < PEN_AUDIT_CLUSTERS)
            audit->cluster[at] = audit->cluster[at - 1];
    if (at < PEN_AUDIT_CLUSTERS)
        audit->cluster[at] = (struct pen_audit_cluster){
            .rect = {sum->left, sum->top, sum->right - sum->left + 1, sum->bottom - sum->top + 1},
            .wrong = sum->wrong};
}

static bool is_within(struct pen_rect rect, int x, int y)
{
    return x >= rect.x && y >= rect.y && x < rect.x + rect.width && y < rect.y + rect.height;
}

void pen_audit_find_clusters(const struct pen_audit_cell cells[PEN_AUDIT_CELLS],
                             const struct pen_settings *settings, const size_t *drawn,
                             struct pen_audit *audit)
{
    const size_t width = (size_t)settings->width;
    bool left[PEN_AUDIT_CELLS];
    audit->clusters = 0;
    for (int i = 0; i < PEN_AUDIT_CELLS; i++)
        left[i] = cells[i].wrong > 0;
    for (int i = 0; i < PEN_AUDIT_CELLS; i++) {
        if (!left[i])
            continue;
        const struct pen_audit_cell sum = take_cluster(cells, left, i);
        insert(audit, &sum);
    }
    for (int c = 0; c < audit->clusters; c++)
        for (uint64_t i = 0; i < audit->pixels; i++)
            audit->cluster[c].pixels +=
                is_within(audit->cluster[c].rect, (int)(drawn[i] % width), (int)(drawn[i] / width));
}
