/* SPDX-License-Identifier: MIT */
/* The samples that a round adds to the pixels of a block are traced 64 at a time, pixel by pixel
 * along a Z-order curve. So samples that are traced together are near one another. */
#include "render/internal/refine.h"

#include <math.h>

enum { BLOCK_PIXELS = PEN_BLOCK_SIDE * PEN_BLOCK_SIDE };

/* Samples that wait to be traced. */
struct sample_list {
    const struct pen_kernel *kernel;
    const struct pen_kernel_input *input;
    struct pen_kernel_scratch *scratch;
    struct pen_ray_counts *rays;
    struct pen_camera_sample sample[PEN_KERNEL_SAMPLES];
    struct pen_pixel_sums *sums[PEN_KERNEL_SAMPLES];   /* of the samples' pixels, */
    unsigned char half[PEN_KERNEL_SAMPLES];            /* the half of each sample, */
    double weight[PEN_KERNEL_SAMPLES];                 /* and its weight */
    struct pen_camera_point point[PEN_KERNEL_SAMPLES]; /* of samples that look for things */
    int count;
};

/* Traces the samples of the list and adds them to their pixels. */
static void trace_list(struct sample_list *list)
{
    struct pen_vec3 radiance[PEN_KERNEL_SAMPLES];
    if (list->count == 0)
        return;
    list->kernel->samples(list->input, list->scratch, list->sample, list->count, radiance,
                          list->rays);
    for (int i = 0; i < list->count; i++) {
        struct pen_pixel_sums *sums = list->sums[i];
        const int half = list->half[i];
        if (isnan(radiance[i].x))
            continue; /* dropped */
        const double weight = list->weight[i];
        sums->kept[half] += weight;
        sums->sum[half][0] += weight * radiance[i].x;
        sums->sum[half][1] += weight * radiance[i].y;
        sums->sum[half][2] += weight * radiance[i].z;
    }
    list->count = 0;
}

/* Adds a sample of a range to the list, which has space for it. */
static void add_sample(struct sample_list *list, const struct pen_sample_range *r, bool things,
                       uint32_t index)
{
    const int i = list->count++;
    struct pen_camera_sample *sample = &list->sample[i];
    *sample = (struct pen_camera_sample){r->x, r->y, r->replicate, index, NULL};
    list->sums[i] = r->sums;
    list->half[i] = index >= r->end / 2;
    list->weight[i] = 1;
    if (things) {
        list->weight[i] = pen_beam_sample(r->beams, sample, &list->point[i]);
        sample->at = &list->point[i];
    }
}

void pen_trace_samples(const struct pen_kernel *kernel, const struct pen_kernel_input *input,
                       struct pen_kernel_scratch *scratch, const struct pen_sample_range *ranges,
                       int count, struct pen_ray_counts *rays)
{
    struct sample_list list;
    list.kernel = kernel;
    list.input = input;
    list.scratch = scratch;
    list.rays = rays;
    list.count = 0;
    for (int p = 0; p < count; p++) {
        const struct pen_sample_range *r = &ranges[p];
        const bool things = r->beams != NULL;
        pen_pixel_double(r->sums);
        for (uint32_t i = r->first; i < r->end; i++) {
            if (list.count == PEN_KERNEL_SAMPLES)
                trace_list(&list);
            add_sample(&list, r, things, i);
        }
        r->sums->samples = r->end;
    }
    trace_list(&list);
}

int pen_z_order_x(int i)
{
    return (i & 1) | (i >> 1 & 2) | (i >> 2 & 4);
}

void pen_refine_block(const struct pen_render_task *task, const struct pen_kernel *kernel,
                      const struct pen_kernel_input *input, struct pen_kernel_scratch *scratch,
                      struct pen_rect block, int thread, struct pen_ray_counts *rays)
{
    struct pen_sample_range ranges[BLOCK_PIXELS];
    int count = 0;
    _Static_assert(PEN_BLOCK_SIDE == 8, "pixel numbers have 6 bits");
    for (int i = 0; i < BLOCK_PIXELS; i++) {
        const int x = block.x + pen_z_order_x(i), y = block.y + pen_z_order_x(i >> 1);
        const size_t at = (size_t)y * (size_t)task->settings->width + (size_t)x;
        if (x >= block.x + block.width || y >= block.y + block.height ||
            !task->adaptive->wanted[at])
            continue;
        if (task->pixel_begins)
            task->pixel_begins(task->pixel_user, thread, x, y);
        struct pen_pixel_sums *sums = &task->adaptive->sums[at];
        const uint32_t more = pen_adaptive_begin_pixel(task->adaptive, at), first = sums->samples;
        ranges[count] = (struct pen_sample_range){.x = x,
                                                  .y = y,
                                                  .first = first,
                                                  .end = first + more,
                                                  .sums = sums,
                                                  .beams = pen_adaptive_beams(task->adaptive, at)};
        if (task->pixel_by_pixel)
            pen_trace_samples(kernel, input, scratch, &ranges[count], 1, rays);
        count++;
    }
    if (!task->pixel_by_pixel)
        pen_trace_samples(kernel, input, scratch, ranges, count, rays);
    for (int i = 0; i < count; i++) {
        const size_t at = (size_t)(ranges[i].sums - task->adaptive->sums);
        pen_adaptive_estimate(task->adaptive, at, &task->rgb[3 * at]);
    }
}
