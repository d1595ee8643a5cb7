/* SPDX-License-Identifier: MIT */
#include "kinds.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The scene of all kinds. Batches are divided by an upper bound of rays, which eight lights raise;
 * few pixels see the sphere that they light, so there are many batches of little work. */
#define LIGHT "{\"type\": \"point\", \"intensity\": [1, 1, 1], \"position\": [3, 6, 4]}"
static const char scene[] =
    "{\"format\": \"penumbra-scene/1\", \"ambient\": [0.1, 0.1, 0.1],"
    " \"camera\": {\"position\": [0, 1, 10], \"look_at\": [0, 0, 0]},"
    " \"lights\": [" LIGHT "," LIGHT "," LIGHT "," LIGHT "," LIGHT "," LIGHT "," LIGHT "," LIGHT
    "],"
    " \"objects\": [{\"type\": \"sphere\", \"center\": [0, 0, 0], \"radius\": 1,"
    " \"material\": {\"kd\": 0.6, \"ks\": 0.4, \"shininess\": 20, \"kr\": 0.3}}]%s}";
static const char views[] =
    ", \"views\": [{\"name\": \"a\"}, {\"name\": \"b\", \"camera\": {\"position\": [0, 1, 30]}},"
    " {\"name\": \"c\", \"camera\": {\"position\": [9, 1, 9]}}]";

static const struct kind {
    const char *name, *scene_more, *render;
    int views;
} kinds[KINDS] = {
    {.name = "tiny", .scene_more = "", .render = "{\"width\": 64, \"height\": 48}", .views = 1},
    {.name = "batches",
     .scene_more = "",
     .render = "{\"width\": 120, \"height\": 90, \"samples_per_pixel\": 289, \"tile\": 8}",
     .views = 1},
    /* Its pixels are stored in three slices. */
    {.name = "slices", .scene_more = "", .render = "{\"width\": 420, \"height\": 330}", .views = 1},
    {.name = "views",
     .scene_more = views,
     .render = "{\"width\": 48, \"height\": 32, \"samples_per_pixel\": 9}",
     .views = 3},
    {.name = "both",
     .scene_more = views,
     .render = "{\"width\": 64, \"height\": 40, \"samples_per_pixel\": 289, \"tile\": 8}",
     .views = 3},
    /* Rendered in rounds, whose state is kept. */
    {.name = "rounds",
     .scene_more = "",
     .render = "{\"width\": 160, \"height\": 120, \"target_error\": 0.0005, \"tile\": 8}",
     .views = 1},
};

void kind_body(int kind, int priority, char *out, size_t bytes)
{
    char text[2048];
    const struct kind *k = &kinds[kind];
    snprintf(text, sizeof text, scene, k->scene_more);
    snprintf(out, bytes, "{\"name\": \"%s\", \"priority\": %d, \"render\": %s, \"scene\": %s}",
             k->name, priority, k->render, text);
}

const char *kind_name(int kind)
{
    return kinds[kind].name;
}

int kind_of(const char *name)
{
    for (int i = 0; i < KINDS; i++) {
        if (name && strcmp(kinds[i].name, name) == 0)
            return i;
    }
    return -1;
}

void must(bool ok, const struct pen_status *st, const char *what)
{
    if (ok)
        return;
    fprintf(stderr, "%s: %s\n", what, st->msg);
    exit(2);
}

struct outcome outcome_of(struct pen_jobs *jobs, const char *id, int kind)
{
    static const char *const names[VIEWS] = {"a", "b", "c"};
    struct outcome out = {0};
    struct pen_status st;
    int views_count = kinds[kind].views;
    for (int v = 0; v < views_count; v++) {
        struct pen_image pfm, png;
        struct pen_image_query query = {.view = views_count > 1 ? names[v] : NULL, .format = "pfm"};
        must(pen_jobs_image(jobs, id, &query, &pfm, &st), &st, id);
        query.format = "png";
        must(pen_jobs_image(jobs, id, &query, &png, &st), &st, id);
        out.pfm[v] = pfm.bytes;
        out.png[v] = png.bytes;
    }
    json_t *stats = pen_jobs_stats(jobs, id, &st);
    must(stats != NULL, &st, id);
    out.rays = json_incref(json_object_get(stats, "rays"));
    json_decref(stats);
    return out;
}

void outcome_release(struct outcome *outcome)
{
    for (int v = 0; v < VIEWS; v++) {
        pen_buf_release(&outcome->pfm[v]);
        pen_buf_release(&outcome->png[v]);
    }
    json_decref(outcome->rays);
}

static bool same(const struct pen_buf *a, const struct pen_buf *b)
{
    return a->bytes == b->bytes && (a->bytes == 0 || memcmp(a->data, b->data, a->bytes) == 0);
}

bool outcome_same_pixels(const struct outcome *a, const struct outcome *b)
{
    for (int v = 0; v < VIEWS; v++) {
        if (!same(&a->pfm[v], &b->pfm[v]) || !same(&a->png[v], &b->png[v]))
            return false;
    }
    return true;
}
