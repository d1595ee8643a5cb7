/* SPDX-License-Identifier: MIT */
/* Renders a scene by a compiled block kernel, and by the kernel that is stripped by hand of all
 * other effects, for AVX2:
 *   instructions SET FILE             both must give the same bits and rays
 *   instructions SET FILE compiled    only the compiled one, in proof_frame, for valgrind to count
 *   instructions SET FILE stripped    only the stripped one
 * SET is none, hard, soft or mirror; the scene is changed to have just these effects. Or SET is a
 * form (support/forms.h), and the scene is rendered by the kernel that is chosen for it:
 *   instructions FORM FILE without    without the effect
 *   instructions FORM FILE idle       with it but without consequence */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "effects/stripped/stripped.h"
#include "support/forms.h"
#include "support/scene_files.h"

struct set {
    const char *name, *kernel;
    unsigned effects; /* of the scene, but for ambient and specular light */
    pen_kernel_block_fn *stripped;
};

static const struct set sets[] = {
    {"none", "lit/avx2", 0, stripped_none},
    {"hard", "hard/avx2", PEN_FX_HARD_SHADOWS, stripped_hard},
    {"soft", "soft/avx2", PEN_FX_SOFT_SHADOWS, stripped_soft},
    {"mirror", "hard+mirror/avx2", PEN_FX_HARD_SHADOWS | PEN_FX_MIRROR, stripped_mirror},
};

/* Makes a scene of the set's effects out of any. */
static void make_of_set(struct pen_scene_desc *desc, const struct set *set)
{
    const double kr = set->effects & PEN_FX_MIRROR ? 0.25 : 0;
    desc->has_sky = false;
    for (uint32_t i = 0; i < desc->material_count; i++) {
        struct pen_material *m = &desc->materials[i];
        m->kt = pen_vec3(0, 0, 0);
        m->kr = pen_vec3(kr, kr, kr);
        m->ior = 1;
        m->reflection_blur = m->transmission_blur = 0;
        m->patterns = NULL;
    }
    for (uint32_t i = 0; i < desc->light_count; i++) {
        struct pen_light_desc *light = &desc->lights[i];
        light->shadows = set->effects != 0;
        light->radius = light->angular_radius = set->effects & PEN_FX_SOFT_SHADOWS ? 0.5 : 0;
    }
    for (uint32_t i = 0; i < desc->view_count; i++)
        desc->views[i].camera.aperture_radius = 0;
}

/* What is counted: a name that the compiler keeps. */
__attribute__((noinline)) double *proof_frame(const struct pen_kernel *kernel,
                                              const struct pen_kernel_input *input,
                                              struct pen_ray_counts *rays);
double *proof_frame(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                    struct pen_ray_counts *rays)
{
    double *frame = frame_by_blocks(kernel, input, rays);
    __asm__ volatile("" ::: "memory"); /* not a jump to it */
    return frame;
}

struct request {
    const struct set *set;
    const struct form *form;  /* instead of a set */
    const char *file, *which; /* which: NULL for both */
    bool failed;
};

static bool refuse(const char *what, const char *of)
{
    fprintf(stderr, "%s: %s\n", of, what);
    return false;
}

static bool render(const struct request *r, const struct pen_kernel_input *input)
{
    const struct pen_kernel *compiled = pen_kernel_select(input->effects, PEN_ISA_AVX2);
    struct pen_kernel stripped = *compiled;
    struct pen_ray_counts rays[2] = {{0}, {0}};
    const bool both = !r->which;
    double *frame[2] = {NULL, NULL};
    const size_t pixels = (size_t)(input->settings->width * input->settings->height);
    stripped.block = r->set->stripped;
    if (strcmp(compiled->name, r->set->kernel) != 0)
        return refuse(compiled->name, "another kernel is chosen");
    if (both || strcmp(r->which, "compiled") == 0)
        frame[0] = proof_frame(compiled, input, &rays[0]);
    if (both || strcmp(r->which, "stripped") == 0)
        frame[1] = proof_frame(&stripped, input, &rays[1]);
    bool same = true;
    if (both)
        same = memcmp(frame[0], frame[1], pixels * 3 * sizeof(double)) == 0 &&
               memcmp(&rays[0], &rays[1], sizeof rays[0]) == 0;
    free(frame[0]);
    free(frame[1]);
    return same || refuse("the stripped kernel gives other bits or rays", r->set->name);
}

static void render_form(const char *path, struct pen_scene_desc *desc, void *user)
{
    struct request *r = user;
    r->form->make(desc, strcmp(r->which, "idle") == 0);
    struct pen_settings settings = desc->settings;
    struct pen_scene *scene = scene_file_freeze(path, desc);
    struct pen_kernel_input input = frame_input(scene, 0, &settings, PEN_ISA_AVX2);
    const struct pen_kernel kernel =
        pen_kernel_choose(&input, (int64_t)settings.width * settings.height, PEN_ISA_AVX2);
    struct pen_ray_counts rays;
    free(proof_frame(&kernel, &input, &rays));
    pen_scene_free(scene);
}

static void with_scene(const char *path, struct pen_scene_desc *desc, void *user)
{
    struct request *r = user;
    struct pen_settings settings = desc->settings;
    scene_file_shrink(&settings, 96);
    settings.samples_per_pixel = settings.lens_samples = 1;
    settings.light_samples = 16;
    make_of_set(desc, r->set);
    struct pen_scene *scene = scene_file_freeze(path, desc);
    const struct pen_kernel_input input = frame_input(scene, 0, &settings, PEN_ISA_AVX2);
    const unsigned lit = PEN_FX_AMBIENT | PEN_FX_SPECULAR;
    r->failed = (input.effects & ~lit) != r->set->effects ? !refuse("has other effects", path)
                                                          : !render(r, &input);
    pen_scene_free(scene);
}

int main(int argc, char **argv)
{
    struct request r = {.file = argc > 2 ? argv[2] : "", .which = argc > 3 ? argv[3] : NULL};
    for (size_t i = 0; argc > 2 && i < sizeof sets / sizeof *sets; i++)
        if (strcmp(sets[i].name, argv[1]) == 0)
            r.set = &sets[i];
    if (r.which && !r.set)
        r.form = form_find(argv[1]);
    if (!r.set && !r.form) {
        fprintf(stderr, "usage: instructions none|hard|soft|mirror FILE [compiled|stripped]\n"
                        "       instructions FORM FILE without|idle\n");
        return 2;
    }
    scene_file_with(r.file, r.form ? render_form : with_scene, &r);
    return r.failed;
}
