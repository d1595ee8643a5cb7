/* SPDX-License-Identifier: MIT */
/* Block kernels stripped by hand: copies of the kernel's text from which the code of all effects
 * but those of one set is removed, to hold the compiled kernels against. Their effects:
 * ambient and specular light in all; hard: hard shadows; soft: hard and soft ones; mirror: hard
 * ones and mirrors. */
#ifndef TESTS_EFFECTS_STRIPPED_STRIPPED_H
#define TESTS_EFFECTS_STRIPPED_STRIPPED_H

#include "shade/internal/kernel_list.h"

pen_kernel_block_fn stripped_none, stripped_hard, stripped_soft, stripped_mirror;

#endif
