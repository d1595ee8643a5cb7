/* SPDX-License-Identifier: MIT */
/* The kernel with the least expected time for a view. A kernel with few effects that does not cover
 * the scene may be faster than one that does, if few samples meet the missing effects. The pixel
 * kernel of all effects renders a grid of samples, which shows how many samples meet them. */
#include <fenv.h>

#include "shade/internal/kernel_list.h"
#include "shade/internal/scratch.h"

/* The grid has SIDE_MIN to SIDE_MAX samples along each side; their number is chosen to cost about
 * half a per cent of the picture. If the picture is too small for SIDE_MIN, no effect is left out.
 */
enum { SIDE_MIN = 4, SIDE_MAX = 8, PIXELS_PER_SAMPLE = 400 };

/* An effect is left out if at most one sample in ONE_IN meets it. If a block meets it, up to a
 * quarter of the block's work is lost; the gain is a tenth to a fifth. */
enum { ONE_IN = 8 };

/* The effects that the samples of the grid meet. */
struct grid {
    int side;
    unsigned met[SIDE_MAX * SIDE_MAX]; /* by sample, of PEN_FX_MAY_BE_LEFT_OUT */
};

static int grid_side(int64_t pixels)
{
    int side = 0;
    while (side < SIDE_MAX && (int64_t)(side + 1) * (side + 1) * PIXELS_PER_SAMPLE <= pixels)
        side++;
    return side;
}

/* Renders the samples, in default arithmetic, each with one ray to a light and one blurred ray of a
 * kind. These are enough for the decision, and no sample takes long. Returns false when out of
 * memory. */
static bool render_grid(const struct pen_kernel_input *view, const struct pen_kernel *full,
                        struct grid *grid)
{
    struct pen_settings settings = *view->settings;
    struct pen_kernel_input input = *view;
    settings.light_samples = settings.blur_samples = 1;
    input.settings = &settings;
    struct pen_kernel_scratch *scratch = pen_kernel_scratch_new(&input);
    fenv_t caller;
    if (!scratch)
        return false;
    fegetenv(&caller);
    fesetenv(FE_DFL_ENV);
    for (int i = 0; i < grid->side * grid->side; i++) {
        const struct pen_camera_point at = {
            .x = (i % grid->side + 0.5) * settings.width / grid->side,
            .y = (i / grid->side + 0.5) * settings.height / grid->side,
        };
        struct pen_ray_counts counts = {.primary = 0};
        scratch->key = (struct pen_sample_key){.seed = settings.seed,
                                               .x = (uint32_t)at.x,
                                               .y = (uint32_t)at.y,
                                               .purpose = PEN_PURPOSE_LIGHT};
        scratch->met = 0;
        full->sample(&input, scratch, at, &counts);
        grid->met[i] = scratch->met;
    }
    fesetenv(&caller);
    pen_kernel_scratch_free(scratch);
    return true;
}

static bool few_meet(const struct grid *grid, unsigned effects)
{
    int meet = 0;
    for (int i = 0; i < grid->side * grid->side; i++)
        meet += (grid->met[i] & effects) != 0;
    return meet * ONE_IN <= grid->side * grid->side;
}

/* A kernel's cost, as a function of its mask. Effects that may be left out cost only if a ray meets
 * them, so they do not count. So such an effect is left out only if every kernel with it also has
 * effects that the scene does not have. */
static int cost_of(const struct pen_kernel *kernel)
{
    return __builtin_popcount(kernel->effects & ~(unsigned)PEN_FX_MAY_BE_LEFT_OUT);
}

struct pen_kernel pen_kernel_choose(struct pen_kernel_input *input, int64_t pixels,
                                    enum pen_isa isa)
{
    static const unsigned left_out[] = {PEN_FX_SKY | PEN_FX_PATTERNS, PEN_FX_PATTERNS, PEN_FX_SKY};
    const struct pen_kernel *full = pen_kernel_select(input->effects, isa), *best = full;
    unsigned may = PEN_FX_MAY_BE_LEFT_OUT;
    struct grid grid = {.side = 0};
    if (input->scene->patterned_glass) /* shadow rays meet patterns too */
        may &= ~(unsigned)PEN_FX_PATTERNS;
    for (size_t i = 0; i < sizeof left_out / sizeof *left_out; i++) {
        const unsigned left = left_out[i] & may & input->effects;
        const struct pen_kernel *small = pen_kernel_select(input->effects & ~left, isa);
        if (cost_of(small) >= cost_of(best))
            continue;
        if (grid.side == 0) {
            grid.side = grid_side(pixels);
            if (grid.side < SIDE_MIN || !render_grid(input, full, &grid))
                break;
        }
        if (few_meet(&grid, left))
            best = small;
    }
    struct pen_kernel chosen = *best;
    if (best != full) {
        input->full = full;
        chosen.pixel = full->pixel;
        chosen.sample = full->sample;
    }
    return chosen;
}
