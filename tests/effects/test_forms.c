/* SPDX-License-Identifier: MIT */
/* An effect that a scene has without consequence costs no kernel, no bit and no ray. */
#include <stdlib.h>
#include <string.h>

#include "support/forms.h"
#include "support/isa.h"
#include "support/scene_files.h"
#include "support/suite.h"

/* What one form of a scene gives. */
struct result {
    const struct form *form;
    bool idle;
    unsigned effects, of_desc;
    const char *kernel;
    struct pen_ray_counts rays;
    double *frame;
    size_t bytes;
};

static void render(const char *path, struct pen_scene_desc *desc, void *user)
{
    struct result *r = user;
    r->form->make(desc, r->idle);
    struct pen_settings settings = desc->settings;
    struct pen_scene *scene = scene_file_freeze(path, desc);
    struct pen_kernel_input input = frame_input(scene, 0, &settings, PEN_ISA_BASE);
    const struct pen_kernel kernel =
        pen_kernel_choose(&input, (int64_t)settings.width * settings.height, PEN_ISA_BASE);
    r->effects = input.effects;
    r->of_desc = pen_desc_effects(desc, &settings);
    r->kernel = kernel.name;
    r->bytes = 3 * sizeof *r->frame * (size_t)(settings.width * settings.height);
    r->frame = frame_by_blocks(&kernel, &input, &r->rays);
    pen_scene_free(scene);
}

START_TEST(test_forms__without_consequence_is_absent)
{
    unsigned seen = 0;
    for (const struct form *form = forms; form->name; form++) {
        struct result r[2];
        for (int idle = 0; idle < 2; idle++) {
            r[idle] = (struct result){.form = form, .idle = idle};
            scene_file_with("tests/effects/scenes/plain.json", render, &r[idle]);
        }
        ck_assert_msg((r[0].effects & form->effect) == 0, "%s: not absent", form->name);
        if (form->called_for) {
            ck_assert_uint_eq(r[1].effects, r[0].effects | form->effect);
        } else {
            ck_assert_msg(r[1].effects == r[0].effects, "%s: effects %x", form->name, r[1].effects);
            ck_assert_msg(r[1].of_desc == r[0].of_desc, "%s: of the document %x", form->name,
                          r[1].of_desc);
            ck_assert_msg(strcmp(r[0].kernel, r[1].kernel) == 0, "%s: kernel %s", form->name,
                          r[1].kernel);
        }
        ck_assert_msg(memcmp(r[0].frame, r[1].frame, r[0].bytes) == 0, "%s: other bits",
                      form->name);
        ck_assert_msg(memcmp(&r[0].rays, &r[1].rays, sizeof r[0].rays) == 0, "%s: other rays",
                      form->name);
        seen |= form->effect;
        free(r[0].frame);
        free(r[1].frame);
    }
    ck_assert_uint_eq(seen, (1u << PEN_FX_COUNT) - 1);
}
END_TEST

PEN_SUITE("forms", test_forms__without_consequence_is_absent)
