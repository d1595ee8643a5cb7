/* SPDX-License-Identifier: MIT */
/* A counting thread has a copy of the scene whose accelerator is a counting view of the shared one,
 * and traces with the counting functions. Kernels are not affected. */
#include "render/internal/counter.h"

#include <stdlib.h>

#include "base/cpu.h"

struct pen_counter {
    struct pen_test_counts counts;
    struct pen_accel *view;
    struct pen_scene scene;
    struct pen_kernel_input input;
};

struct pen_counter *pen_counter_new(const struct pen_kernel_input *input)
{
    struct pen_counter *counter = calloc(1, sizeof *counter);
    if (!counter)
        return NULL;
    counter->view = pen_accel_count_new(input->scene->accel, &counter->counts);
    if (!counter->view) {
        free(counter);
        return NULL;
    }
    counter->scene = *input->scene;
    counter->scene.accel = counter->view;
    counter->input = *input;
    counter->input.scene = &counter->scene;
    counter->input.trace = pen_trace_count_ops_get(pen_cpu_isa());
    return counter;
}

void pen_counter_free(struct pen_counter *counter)
{
    if (!counter)
        return;
    pen_accel_count_free(counter->view);
    free(counter);
}

const struct pen_kernel_input *pen_counter_input(const struct pen_counter *counter)
{
    return &counter->input;
}

void pen_counter_add(const struct pen_counter *counter, struct pen_test_counts *sum)
{
    sum->boxes += counter->counts.boxes;
    sum->primitives += counter->counts.primitives;
}
