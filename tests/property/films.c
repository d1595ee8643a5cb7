/* SPDX-License-Identifier: MIT */
/* Each film is made again from its scene file, in small, as tests/golden/test_golden.c does. */
#include "property/films.h"

#include <stdlib.h>
#include <string.h>
#if defined(__x86_64__)
#include <xmmintrin.h>
#endif

#include "io/scene_json.h"
#include "render/render.h"
#include "support/golden.h"
#include "support/random.h"

#define TABLE "tests/golden/hashes.txt"

enum { FILMS_MAX = 200, SCENE_BYTES = 1 << 24 };

struct film {
    uint64_t hash;
    char path[100], view[40];
};

static struct film film[FILMS_MAX];

int films_count(void)
{
    static int count;
    char line[256];
    FILE *table = count ? NULL : fopen(TABLE, "r");
    while (table && count < FILMS_MAX && fgets(line, sizeof line, table)) {
        unsigned long long hash;
        struct film *f = &film[count];
        if (sscanf(line, "%llx %99s %39s", &hash, f->path, f->view) != 3)
            continue;
        f->hash = hash;
        count++;
    }
    if (table)
        fclose(table);
    return count;
}

/* A scene that is being rendered. */
struct stage {
    struct pen_arena *arena;
    struct pen_scene *scene;
    struct pen_settings settings;
    int view;
};

static char *read_scene(const char *path, size_t *bytes)
{
    FILE *f = fopen(path, "rb");
    char *text = f ? malloc(SCENE_BYTES) : NULL;
    *bytes = text ? fread(text, 1, SCENE_BYTES, f) : 0;
    if (f)
        fclose(f);
    return text;
}

static void stage_end(struct stage *s)
{
    pen_scene_free(s->scene);
    pen_arena_free(s->arena);
}

static bool stage_begin(struct stage *s, const struct film *f, int accelerator, char *why,
                        size_t room)
{
    static struct pen_errors errors;
    struct pen_limits limits = pen_limits_default();
    struct pen_scene_desc desc;
    struct pen_status st = {0};
    size_t bytes;
    char *text = read_scene(f->path, &bytes);
    memset(&errors, 0, sizeof errors);
    *s = (struct stage){.arena = pen_arena_new(0), .view = -1};
    bool read = text && pen_scene_load(text, bytes, &limits, s->arena, &desc, &errors);
    for (uint32_t i = 0; read && i < desc.view_count; i++)
        if (strcmp(desc.views[i].name, f->view) == 0)
            s->view = (int)i;
    if (s->view >= 0)
        s->scene = pen_scene_freeze(&desc, (enum pen_accelerator)accelerator, 0, &st);
    if (s->scene) {
        s->settings = desc.settings;
        golden_shrink(&s->settings);
    } else {
        snprintf(why, room, "%s %s cannot be rendered: %s%s", f->path, f->view, errors.item[0].msg,
                 st.msg);
        stage_end(s);
    }
    free(text);
    return s->scene != NULL;
}

/* What is known of a film's tiles while they are rendered. */
struct progress {
    int columns, tile, left; /* tiles until the run is cancelled */
    atomic_bool cancel;
    bool *done;
};

static void tile_done(void *user, struct pen_rect rect)
{
    struct progress *p = user;
    p->done[rect.y / p->tile * p->columns + rect.x / p->tile] = true;
    if (--p->left == 0)
        atomic_store(&p->cancel, true);
}

static void shuffle(int *order, int count, uint64_t seed)
{
    struct random r = {seed, seed};
    for (int i = 0; i < count; i++)
        order[i] = i;
    for (int i = count - 1; i > 0; i--) {
        int k = (int)random_below(&r, (uint32_t)i + 1), kept = order[i];
        order[i] = order[k];
        order[k] = kept;
    }
}

/* The tiles that are not done, one by one. */
static bool render_rest(struct pen_thread_pool *pool, struct pen_render_task task,
                        const struct progress *p, int count, uint64_t seed)
{
    struct pen_render_stats stats;
    struct pen_status st;
    int *order = calloc((size_t)count, sizeof *order);
    bool ok = true;
    shuffle(order, count, seed);
    task.tile_done = NULL;
    task.cancel = NULL;
    task.tile_count = 1;
    for (int i = 0; ok && i < count; i++) {
        task.first_tile = order[i];
        ok = p->done[order[i]] || pen_render_run(pool, &task, &stats, &st);
    }
    free(order);
    return ok;
}

static bool render(const struct stage *s, const struct films_variant *variant,
                   struct pen_thread_pool *pool, float *rgb)
{
    struct pen_status st;
    struct pen_render_stats stats;
    const struct pen_settings *set = &s->settings;
    int count = pen_tile_count(set->width, set->height, set->tile);
    struct progress p = {.columns = (set->width + set->tile - 1) / set->tile,
                         .tile = set->tile,
                         .left = variant->cut ? (count + 1) / 2 : -1,
                         .done = calloc((size_t)count, sizeof *p.done)};
    struct pen_render_task task = {.scene = s->scene,
                                   .view = s->view,
                                   .settings = set,
                                   .tile_count = -1,
                                   .rgb = rgb,
                                   .cancel = &p.cancel,
                                   .tile_done = tile_done,
                                   .user = &p};
    bool whole = variant->order == FILMS_AT_ONCE && pen_render_run(pool, &task, &stats, &st);
    bool ok = whole || ((variant->cut || variant->order == FILMS_SHUFFLED) &&
                        render_rest(pool, task, &p, count, variant->seed));
    free(p.done);
    return ok;
}

static bool match(int i, const struct films_variant *variant, char *why, size_t bytes)
{
    struct stage s;
    struct pen_status st = {0};
    if (!stage_begin(&s, &film[i], variant->accelerator, why, bytes))
        return false;
    s.settings.tile = variant->tile ? variant->tile : 4096;
    size_t count = 3 * (size_t)s.settings.width * (size_t)s.settings.height;
    float *rgb = calloc(count, sizeof *rgb);
    struct pen_thread_pool *pool = pen_thread_pool_new(variant->threads, &st);
    bool ok = pool && render(&s, variant, pool, rgb);
    uint64_t hash = golden_hash(rgb, count);
    if (!ok)
        snprintf(why, bytes, "%s %s was not rendered: %s", film[i].path, film[i].view, st.msg);
    else if (hash != film[i].hash)
        snprintf(why, bytes, "%s %s: hash %016llx, not that of " TABLE, film[i].path, film[i].view,
                 (unsigned long long)hash);
    pen_thread_pool_free(pool);
    free(rgb);
    stage_end(&s);
    return ok && hash == film[i].hash;
}

static unsigned change_state(unsigned bits)
{
#if defined(__x86_64__)
    unsigned before = _mm_getcsr();
    _mm_setcsr(before | bits);
    return before;
#else
    return bits;
#endif
}

static void restore_state(unsigned state)
{
#if defined(__x86_64__)
    _mm_setcsr(state);
#else
    (void)state;
#endif
}

bool films_match(int i, const struct films_variant *variant, char *why, size_t bytes)
{
    const char *isa = getenv("PENUMBRA_ISA");
    char was[40] = "";
    if (isa)
        snprintf(was, sizeof was, "%s", isa);
    if (variant->isa)
        setenv("PENUMBRA_ISA", variant->isa, 1);
    unsigned before = change_state(variant->strange);
    bool ok = match(i, variant, why, bytes);
    restore_state(before);
    if (!isa)
        unsetenv("PENUMBRA_ISA");
    else
        setenv("PENUMBRA_ISA", was, 1);
    return ok;
}

static bool accumulators_hash(const struct stage *s, uint64_t *hash)
{
    *hash = GOLDEN_HASH_BEGIN;
    for (int y = 0; y < s->settings.height; y++)
        for (int x = 0; x < s->settings.width; x++) {
            double rgb[3];
            uint64_t bits[3];
            struct pen_ray_counts rays;
            struct pen_status st;
            if (!pen_render_pixel(s->scene, s->view, &s->settings, x, y, rgb, &rays, &st))
                return false;
            memcpy(bits, rgb, sizeof bits);
            for (int c = 0; c < 3; c++)
                *hash = golden_hash_add(*hash, bits[c], 8);
        }
    return true;
}

const char *films_scene(int i)
{
    return film[i].path;
}

bool films_print_accumulators(int i, FILE *out)
{
    struct stage s;
    uint64_t hash;
    char why[256] = "out of memory";
    bool ok = stage_begin(&s, &film[i], PEN_ACCEL_AUTO, why, sizeof why);
    if (ok) {
        ok = accumulators_hash(&s, &hash);
        stage_end(&s);
    }
    if (ok)
        fprintf(out, "%016llx %s %s\n", (unsigned long long)hash, film[i].path, film[i].view);
    else
        fprintf(stderr, "stability: %s\n", why);
    return ok;
}
