/* SPDX-License-Identifier: MIT */
/* The frame of a scene by the kernel that is chosen for it, by every other kernel that covers it,
 * and by every instruction set: the same bits and the same rays. So a kernel may leave out code
 * without a change, and an effect that a scene lacks is computed as its simplest case. The same
 * holds for block kernels that leave out a sky or patterns of the scene. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "support/isa.h"
#include "support/random.h"
#include "support/scene_files.h"
#include "support/suite.h"

struct tally {
    int scene;                        /* number of the scene */
    int step, width;                  /* one scene in so many is tried, so wide */
    int compared;                     /* frames */
    unsigned seen;                    /* effects of the scenes */
    int left_out;                     /* of these, by a kernel that leaves out an effect */
    bool by_kernel[PEN_FX_COUNT + 1]; /* superfluous effects that some kernel had */
};

/* A frame that must be this one. */
struct wanted {
    const char *path;
    const double *frame;
    struct pen_ray_counts rays;
    size_t bytes;
};

static void check_frame(const struct wanted *want, const struct pen_kernel *kernel, double *frame,
                        const struct pen_ray_counts *rays, const char *how)
{
    ck_assert_msg(memcmp(frame, want->frame, want->bytes) == 0, "%s: %s, %s: other bits",
                  want->path, kernel->name, how);
    ck_assert_msg(memcmp(rays, &want->rays, sizeof *rays) == 0, "%s: %s, %s: other rays",
                  want->path, kernel->name, how);
    free(frame);
}

/* A block kernel that leaves out effects of the scene, if it may. */
static void compare_left_out(struct tally *tally, const struct wanted *want,
                             const struct pen_kernel_input *input, const struct pen_kernel *kernel,
                             enum pen_isa isa)
{
    const unsigned missing = input->effects & ~kernel->effects;
    struct pen_kernel_input with_full = *input;
    struct pen_ray_counts rays;
    if ((missing & ~(unsigned)PEN_FX_MAY_BE_LEFT_OUT) ||
        ((missing & PEN_FX_PATTERNS) && input->scene->patterned_glass))
        return;
    with_full.full = pen_kernel_select(input->effects, isa);
    check_frame(want, kernel, frame_by_blocks(kernel, &with_full, &rays), &rays, "leaves out");
    tally->compared++;
    tally->left_out++;
}

/* All kernels of an instruction set that cover the scene. */
static void compare_kernels(struct tally *tally, const struct wanted *want,
                            const struct pen_kernel_input *input, enum pen_isa isa)
{
    const struct pen_kernel *kernel;
    struct pen_ray_counts rays;
    for (int i = 0; (kernel = pen_kernel_at(i, isa)) != NULL; i++) {
        const unsigned more = kernel->effects & ~input->effects;
        if (input->effects & ~kernel->effects) {
            compare_left_out(tally, want, input, kernel, isa);
            continue;
        }
        for (int bit = 0; bit < PEN_FX_COUNT; bit++)
            tally->by_kernel[bit] |= more >> bit & 1;
        check_frame(want, kernel, frame_by_blocks(kernel, input, &rays), &rays, "blocks");
        tally->compared++;
        if (isa != PEN_ISA_BASE && !proof_in_full())
            continue; /* pixel kernels are the same for all */
        check_frame(want, kernel, frame_by_pixels(kernel, input, &rays), &rays, "pixels");
        tally->compared++;
    }
}

static void compare_scene(const char *path, struct pen_scene_desc *desc, void *user)
{
    struct tally *tally = user;
    if (tally->scene++ % tally->step)
        return;
    struct pen_settings settings = desc->settings;
    scene_file_shrink(&settings, tally->width);
    struct pen_scene *scene = scene_file_freeze(path, desc);
    for (uint32_t view = 0; view < desc->view_count; view++) {
        struct pen_kernel_input input = frame_input(scene, (int)view, &settings, PEN_ISA_BASE);
        const struct pen_kernel *chosen = pen_kernel_select(input.effects, PEN_ISA_BASE);
        struct wanted want = {.path = path};
        double *frame = frame_by_pixels(chosen, &input, &want.rays);
        want.frame = frame;
        want.bytes = 3 * sizeof *frame * (size_t)(settings.width * settings.height);
        for (int isa = 0; isa < isa_count(); isa++) {
            input.trace = pen_trace_ops_get((enum pen_isa)isa);
            compare_kernels(tally, &want, &input, (enum pen_isa)isa);
        }
        tally->seen |= input.effects;
        free(frame);
    }
    pen_scene_free(scene);
}

START_TEST(test_masks__every_superset_gives_the_same_bits)
{
    const bool full = proof_in_full();
    struct tally tally = {.step = full ? 1 : random_fewer(), .width = full ? 48 : 20};
    const int scenes = scene_files_each(full, compare_scene, &tally);
    ck_assert_int_ge(scenes, full ? 48 : 40);
    ck_assert_int_gt(tally.left_out, 0);
    ck_assert_int_ge(tally.compared, full ? 1000 : 500 / random_fewer());
    if (!full)
        return;
    ck_assert_uint_eq(tally.seen, (1u << PEN_FX_COUNT) - 1);
    for (int bit = 0; bit < PEN_FX_COUNT; bit++) /* some scene has not what its kernel has */
        ck_assert_msg(tally.by_kernel[bit], "%s is never superfluous", pen_effect_name(bit));
    printf("%d frames of %d scenes, %d instruction sets: equal\n", tally.compared, scenes,
           isa_count());
}
END_TEST

PEN_SUITE("masks", test_masks__every_superset_gives_the_same_bits)
