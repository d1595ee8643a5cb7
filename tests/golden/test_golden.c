/* SPDX-License-Identifier: MIT */
/* Golden films: the bits of every scene in scenes/ and tests/golden/scenes/, in small, compared
 * with hashes.txt. They are the same for any number of threads, instruction set and accelerator, on
 * any machine. After a change that is meant to change pictures, look at them. Then `make golden`
 * (PENUMBRA_GOLDEN=write) writes a new table, whose diff shows which pictures changed. */
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "render/render.h"
#include "shade/kernel.h"
#include "support/golden.h"
#include "support/isa.h"
#include "support/suite.h"

#define TABLE "tests/golden/hashes.txt"

enum { LINES_MAX = 200, LINE_BYTES = 160 };

struct table {
    int count;
    char line[LINES_MAX][LINE_BYTES];
};

static char *read_file(const char *path, size_t *bytes)
{
    FILE *file = fopen(path, "rb");
    ck_assert_msg(file != NULL, "%s cannot be read", path);
    ck_assert_int_eq(fseek(file, 0, SEEK_END), 0);
    long size = ftell(file);
    rewind(file);
    char *text = malloc((size_t)size + 1);
    *bytes = fread(text, 1, (size_t)size, file);
    text[*bytes] = 0;
    fclose(file);
    return text;
}

static uint64_t render_hash(const struct pen_scene *scene, int view, struct pen_settings settings,
                            int threads, int tile)
{
    struct pen_status st = {0};
    settings.tile = tile;
    size_t count = 3 * (size_t)settings.width * (size_t)settings.height;
    float *film = calloc(count, sizeof *film);
    struct pen_thread_pool *pool = pen_thread_pool_new(threads, &st);
    struct pen_render_task task = {
        .scene = scene, .view = view, .settings = &settings, .tile_count = -1, .rgb = film};
    struct pen_render_stats stats;
    ck_assert_msg(pen_render_run(pool, &task, &stats, &st), "%s", st.msg);
    pen_thread_pool_free(pool);
    uint64_t hash = golden_hash(film, count);
    free(film);
    return hash;
}

static struct pen_scene *freeze(const struct pen_scene_desc *desc, int accelerator)
{
    struct pen_status st = {0};
    struct pen_scene *scene = pen_scene_freeze(desc, (enum pen_accelerator)accelerator, 0, &st);
    ck_assert_msg(scene != NULL, "%s: %s", st.at, st.msg);
    return scene;
}

/* A build with sanitizers looks for undefined behaviour: for each kernel one view stands for
 * all. */
#ifdef PEN_SHARED_KERNELS
enum { ONE_PER_KERNEL = 1 };
#else
enum { ONE_PER_KERNEL = 0 };
#endif

/* Whether no view before this one was rendered by the same kernel. */
static bool has_new_kernel(const struct pen_scene *scene, int view,
                           const struct pen_settings *settings)
{
    enum { KERNELS_MAX = 64 };
    static const struct pen_kernel *seen[KERNELS_MAX];
    const struct pen_kernel *kernel =
        pen_kernel_select(pen_scene_effects(scene, view, settings), PEN_ISA_BASE);
    int i = 0;
    while (i < KERNELS_MAX - 1 && seen[i] && seen[i] != kernel)
        i++;
    const bool is_new = seen[i] != kernel;
    seen[i] = kernel;
    return is_new;
}

/* All views of a scene: one line each, once all ways of rendering agree. These meet each
 * accelerator, instruction set, number of threads and size of tiles; the rows of films in
 * tests/property change one of them at a time. */
static void hash_views(const char *path, const struct pen_scene_desc *desc, struct table *table)
{
    static const int threads[] = {2, 3, 8, 1}, tiles[] = {7, 1000, 1, 32};
    struct pen_settings settings = desc->settings;
    golden_shrink(&settings);
    struct pen_scene *by_kind[PEN_ACCEL_COUNT];
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        by_kind[kind] = freeze(desc, kind);
    const struct pen_scene *tree = by_kind[PEN_ACCEL_AUTO];
    for (uint32_t view = 0; view < desc->view_count; view++) {
        if (ONE_PER_KERNEL && !has_new_kernel(tree, (int)view, &settings))
            continue;
        uint64_t hash = render_hash(tree, (int)view, settings, 1, 32);
        for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++) {
            isa_force(kind % isa_count());
            ck_assert_msg(hash == render_hash(by_kind[kind], (int)view, settings, threads[kind % 4],
                                              tiles[kind % 4]),
                          "%s: %s, %s, %d threads, tiles of %d", path,
                          pen_accelerator_name((enum pen_accelerator)kind),
                          pen_isa_name((enum pen_isa)(kind % isa_count())), threads[kind % 4],
                          tiles[kind % 4]);
            isa_release();
        }
        ck_assert_int_lt(table->count, LINES_MAX);
        snprintf(table->line[table->count++], LINE_BYTES, "%016llx %s %s\n",
                 (unsigned long long)hash, path, desc->views[view].name);
    }
    for (int kind = 0; kind < PEN_ACCEL_COUNT; kind++)
        pen_scene_free(by_kind[kind]);
}

static void hash_scene(const char *path, struct table *table)
{
    static struct pen_errors errors;
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    size_t bytes;
    char *text = read_file(path, &bytes);
    memset(&errors, 0, sizeof errors);
    ck_assert_msg(pen_scene_load(text, bytes, &limits, arena, &desc, &errors), "%s%s: %s", path,
                  errors.item[0].at, errors.item[0].msg);
    hash_views(path, &desc, table);
    free(text);
    pen_arena_free(arena);
}

static void hash_all(struct table *table)
{
    glob_t found;
    ck_assert_int_eq(glob("scenes/*.json", 0, NULL, &found), 0);
    ck_assert_int_eq(glob("tests/golden/scenes/*.json", GLOB_APPEND, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++)
        hash_scene(found.gl_pathv[i], table);
    globfree(&found);
}

static void write_table(const struct table *table)
{
    FILE *file = fopen(TABLE, "w");
    ck_assert(file != NULL);
    fprintf(file, "# Hashes of films, by scene and view; written by `make golden`.\n");
    for (int i = 0; i < table->count; i++)
        fputs(table->line[i], file);
    ck_assert_int_eq(fclose(file), 0);
}

START_TEST(test_golden__films_are_those_of_the_table)
{
    static struct table table;
    hash_all(&table);
    const char *mode = getenv("PENUMBRA_GOLDEN");
    if (mode && strcmp(mode, "write") == 0) {
        write_table(&table);
        return;
    }
    size_t bytes;
    char *known = read_file(TABLE, &bytes);
    int different = 0;
    for (int i = 0; i < table.count; i++)
        if (!strstr(known, table.line[i])) {
            different++;
            fprintf(stderr, "not in " TABLE ": %s", table.line[i]);
        }
    ck_assert_int_eq(different, 0);
    int lines = 0;
    for (const char *c = known; *c; c++)
        lines += *c == '\n';
    ck_assert(ONE_PER_KERNEL || lines == table.count + 1); /* no scene has gone */
    free(known);
}
END_TEST

PEN_SUITE("golden", test_golden__films_are_those_of_the_table)
