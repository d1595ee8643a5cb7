/* SPDX-License-Identifier: MIT */
/* Any bytes as a model in PLY. */
#include "fuzz/model.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    read_model(data, size, PEN_MODEL_PLY, NULL, NULL);
    return 0;
}
