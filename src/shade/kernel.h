/* SPDX-License-Identifier: MIT */
/* Kernels: the radiance of pixels, by the equations of src/shade/README.md. The kernel body is one
 * inlined function that takes a constant mask of effects. Each compiled kernel contains only the
 * effects of its mask. pen_kernel_select picks the smallest kernel that covers the effects of a
 * scene. All kernels, for all instruction sets, give the same bits. Block kernels are compiled for
 * each instruction set. Pixel kernels are compiled once, since a single pixel cannot use wide
 * vectors. */
#ifndef PEN_SHADE_KERNEL_H
#define PEN_SHADE_KERNEL_H

#include <stdint.h>

#include "math/rect.h"
#include "math/sample.h"
#include "scene/scene.h"

/* Numbers of rays by kind, as src/shade/KERNELS.md counts them. */
struct pen_ray_counts {
    uint64_t primary, shadow, reflection, transmission;
    uint64_t dropped_samples; /* not finite or beyond the film; not in the mean; expected 0 */
    uint64_t unmatched_exits; /* paths that left a solid that they had not entered, so it is open;
                                 expected 0 with closed solids */
    uint64_t truncated_paths; /* secondary rays that were not traced, because their pixel sample had
                                 shaded pen_tree_surfaces_max surfaces */
};

/* Adds the numbers of `more` to *sum. */
static inline void pen_ray_counts_add(struct pen_ray_counts *sum, const struct pen_ray_counts *more)
{
    sum->primary += more->primary;
    sum->shadow += more->shadow;
    sum->reflection += more->reflection;
    sum->transmission += more->transmission;
    sum->dropped_samples += more->dropped_samples;
    sum->unmatched_exits += more->unmatched_exits;
    sum->truncated_paths += more->truncated_paths;
}

/* The input of a kernel.
 * Threads: shared, immutable. */
struct pen_kernel_input {
    const struct pen_scene *scene;
    const struct pen_scene_view *view;
    const struct pen_settings *settings;
    struct pen_pinhole pinhole;
    struct pen_lens lens;
    unsigned effects;
    const struct pen_trace_ops *trace;
    /* The kernel of all these effects, if block kernels with fewer effects may get this input; else
     * NULL: pen_kernel_choose. */
    const struct pen_kernel *full;
};

/* Working memory of one thread: the stack of pending secondary rays and the last occluders. */
struct pen_kernel_scratch;

struct pen_kernel_scratch *pen_kernel_scratch_new(const struct pen_kernel_input *input);
void pen_kernel_scratch_free(struct pen_kernel_scratch *scratch);

/* Renders one pixel: the mean of its samples, linear RGB in double. Adds its rays to *counts. The
 * result is a pure function of (scene, settings, x, y). */
typedef void pen_kernel_fn(const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                           int x, int y, double rgb[3], struct pen_ray_counts *counts);

/* The point at which a camera ray passes the image, in pixels from the top left corner, and the
 * lens, in coordinates on the unit disk. */
struct pen_camera_point {
    double x, y;
    struct pen_point2 lens; /* 0 for a pinhole */
};

/* A sample of a replicate. A replicate of a pixel is a sequence of camera rays with its own
 * scramblings; the mean of its first n samples is valid for any n (math/sample.h: struct
 * pen_sample_key). */
struct pen_camera_sample {
    int x, y;           /* the pixel */
    uint32_t replicate; /* from 0 on; only audits have several */
    uint32_t index;     /* in the replicate, from 0 on */
    /* Replaces its point of the sequence; NULL: use that point. */
    const struct pen_camera_point *at;
};

/* Renders one sample of a pixel: its radiance. The pixel is that of the scratch memory's sampling
 * key. */
typedef struct pen_vec3 pen_kernel_sample_fn(const struct pen_kernel_input *input,
                                             struct pen_kernel_scratch *scratch,
                                             struct pen_camera_point at,
                                             struct pen_ray_counts *counts);

/* Renders a block of pixels, row by row, as pen_kernel_fn. rect.width and rect.height are at most
 * PEN_BLOCK_SIDE. */
enum { PEN_BLOCK_SIDE = 8 };
typedef void pen_kernel_block_fn(const struct pen_kernel_input *input,
                                 struct pen_kernel_scratch *scratch, struct pen_rect rect,
                                 double (*rgb)[3], struct pen_ray_counts *counts);

/* Renders up to PEN_KERNEL_SAMPLES samples of replicates, of any pixels: their radiances. Samples
 * that are neighbours in the list should be near in the image. A sample that is not finite, or too
 * large for the film, is counted as dropped and has a radiance of NaN. Kernels without
 * anti-aliasing have no such function. */
enum { PEN_KERNEL_SAMPLES = 64 };
typedef void pen_kernel_samples_fn(const struct pen_kernel_input *input,
                                   struct pen_kernel_scratch *scratch,
                                   const struct pen_camera_sample *samples, int count,
                                   struct pen_vec3 *radiance, struct pen_ray_counts *counts);

struct pen_kernel {
    const char *name; /* e.g. "hard+mirror/avx2": shown in statistics */
    unsigned effects; /* the mask: PEN_FX_* */
    pen_kernel_fn *pixel;
    pen_kernel_sample_fn *sample;   /* one sample by the pixel kernel */
    pen_kernel_block_fn *block;     /* for input->trace with packets */
    pen_kernel_samples_fn *samples; /* does not need packets */
    size_t block_bytes;             /* of the working memory of `block` */
};

/* The kernels by index, for tests and reports; NULL after the last. Kernels for an instruction set
 * run only on processors that have it (pen_cpu_isa). */
const struct pen_kernel *pen_kernel_at(int index, enum pen_isa isa);

/* The kernel with the fewest effects that covers `effects`, for an instruction set. Never NULL. */
const struct pen_kernel *pen_kernel_select(unsigned effects, enum pen_isa isa);

/* The effects that the block kernels of a mask may leave out although a scene has them. These
 * kernels find the samples that meet such an effect, and input->full renders them again. */
enum { PEN_FX_MAY_BE_LEFT_OUT = PEN_FX_SKY | PEN_FX_PATTERNS };

/* The kernel with the least expected time for this number of pixels of the view. It is that of
 * pen_kernel_select, or one that leaves out effects which few samples meet; then it sets
 * input->full. The choice is a function of the scene, the view, the settings and the number alone.
 * Bits and rays do not depend on it. */
struct pen_kernel pen_kernel_choose(struct pen_kernel_input *input, int64_t pixels,
                                    enum pen_isa isa);

#endif
