/* SPDX-License-Identifier: MIT */
#include "support/scene_files.h"

#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "io/scene_json.h"
#include "support/golden.h"

bool proof_in_full(void)
{
    const char *given = getenv("PEN_PROOF");
    return given && strcmp(given, "full") == 0;
}

/* Ends the process, so that programs without libcheck can use this as well as tests. */
static void need(bool ok, const char *path, const char *what, const char *more)
{
    if (ok)
        return;
    fprintf(stderr, "%s: %s %s\n", path, what, more);
    exit(1);
}

static char *read_file(const char *path, size_t *bytes)
{
    enum { MOST = 64 << 20 };
    FILE *file = fopen(path, "rb");
    need(file != NULL, path, "cannot be read", "");
    char *text = malloc(MOST);
    need(text != NULL, path, "no memory", "");
    *bytes = fread(text, 1, MOST, file);
    need(*bytes < MOST, path, "is too long", "");
    fclose(file);
    return text;
}

void scene_file_with(const char *path, scene_file_fn *each, void *user)
{
    static struct pen_errors errors;
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    size_t bytes;
    char *text = read_file(path, &bytes);
    memset(&errors, 0, sizeof errors);
    need(pen_scene_load(text, bytes, &limits, arena, &desc, &errors), path, errors.item[0].at,
         errors.item[0].msg);
    each(path, &desc, user);
    free(text);
    pen_arena_free(arena);
}

int scene_files_each(bool built_in, scene_file_fn *each, void *user)
{
    glob_t found;
    int missing = glob("tests/golden/scenes/*.json", 0, NULL, &found);
    if (built_in)
        missing |= glob("scenes/*.json", GLOB_APPEND, NULL, &found);
    need(!missing, "scenes", "are missing", "");
    const int count = (int)found.gl_pathc;
    for (int i = 0; i < count; i++)
        scene_file_with(found.gl_pathv[i], each, user);
    globfree(&found);
    return count;
}

void scene_file_shrink(struct pen_settings *settings, int width)
{
    golden_shrink(settings);
    if (settings->light_samples > 8)
        settings->light_samples = 8;
    if (settings->width <= width)
        return;
    settings->height = settings->height * width / settings->width;
    settings->height += settings->height == 0;
    settings->width = width;
}

struct pen_scene *scene_file_freeze(const char *path, const struct pen_scene_desc *desc)
{
    struct pen_status st = {0};
    struct pen_scene *scene = pen_scene_freeze(desc, PEN_ACCEL_AUTO, 0, &st);
    need(scene != NULL, path, st.at, st.msg);
    return scene;
}

struct pen_kernel_input frame_input(const struct pen_scene *scene, int view,
                                    const struct pen_settings *settings, enum pen_isa isa)
{
    struct pen_kernel_input input = {
        .scene = scene,
        .view = &scene->views[view],
        .settings = settings,
        .pinhole = pen_scene_pinhole(scene, view, settings->width, settings->height),
        .effects = pen_scene_effects(scene, view, settings),
        .trace = pen_trace_ops_get(isa),
    };
    input.lens = pen_scene_lens(scene, view, &input.pinhole);
    return input;
}

/* Renders a block and copies it to its place in the frame. */
static void add_block(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                      struct pen_kernel_scratch *scratch, struct pen_rect rect, double (*frame)[3],
                      struct pen_ray_counts *rays)
{
    double rgb[PEN_BLOCK_SIDE * PEN_BLOCK_SIDE][3];
    kernel->block(input, scratch, rect, rgb, rays);
    for (int y = 0; y < rect.height; y++)
        memcpy(frame[(rect.y + y) * input->settings->width + rect.x], rgb[y * rect.width],
               (size_t)rect.width * sizeof *rgb);
}

double *frame_by_blocks(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                        struct pen_ray_counts *rays)
{
    const int width = input->settings->width, height = input->settings->height;
    struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(input);
    double(*frame)[3] = calloc((size_t)width * (size_t)height, sizeof *frame);
    need(scratch && frame, "a frame", "no memory", "");
    *rays = (struct pen_ray_counts){0};
    for (int y = 0; y < height; y += PEN_BLOCK_SIDE)
        for (int x = 0; x < width; x += PEN_BLOCK_SIDE) {
            struct pen_rect rect = {x, y, PEN_BLOCK_SIDE, PEN_BLOCK_SIDE};
            rect.width = width - x < rect.width ? width - x : rect.width;
            rect.height = height - y < rect.height ? height - y : rect.height;
            add_block(kernel, input, scratch, rect, frame, rays);
        }
    pen_kernel_scratch_free(scratch);
    return &frame[0][0];
}

double *frame_by_pixels(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                        struct pen_ray_counts *rays)
{
    const int width = input->settings->width, height = input->settings->height;
    struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(input);
    double *frame = calloc((size_t)width * (size_t)height, 3 * sizeof *frame);
    need(scratch && frame, "a frame", "no memory", "");
    *rays = (struct pen_ray_counts){0};
    for (int i = 0; i < width * height; i++)
        kernel->pixel(input, scratch, i % width, i / width, &frame[3 * i], rays);
    pen_kernel_scratch_free(scratch);
    return frame;
}
