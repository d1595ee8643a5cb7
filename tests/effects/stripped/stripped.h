/* SPDX-License-Identifier: MIT */
/* Block kernels stripped by hand, to compare the compiled kernels with. They are copies of the
 * kernel's text without the code of all effects outside one set. All have ambient and specular
 * light. `hard` adds hard shadows; `soft` adds hard and soft shadows; `mirror` adds hard shadows
 * and mirrors. */
#ifndef TESTS_EFFECTS_STRIPPED_STRIPPED_H
#define TESTS_EFFECTS_STRIPPED_STRIPPED_H

#include "shade/internal/kernel_list.h"

pen_kernel_block_fn stripped_none, stripped_hard, stripped_soft, stripped_mirror;

#endif
