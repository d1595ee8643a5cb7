/* SPDX-License-Identifier: MIT */
/* Any bytes as a model in OBJ. The bytes behind the first 0xFF are its MTL. No name of a file that
 * it asks for leads out of its folder. */
#include "fuzz/model.h"

struct rest {
    const uint8_t *data;
    size_t size;
};

static bool fetch(void *self, const char *name, struct pen_buf *out, struct pen_status *st)
{
    const struct rest *rest = self;
    must(name[0] && name[0] != '/' && !strchr(name, '\\') && !strstr(name, "/../"));
    must(strncmp(name, "../", 3) != 0 && strcmp(name, "..") != 0);
    return pen_buf_add(out, rest->data, rest->size) || pen_fail(st, PEN_NO_MEMORY, "No memory");
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    const uint8_t *mark = size > 0 ? memchr(data, 0xFF, size) : NULL;
    const size_t own = mark ? (size_t)(mark - data) : size;
    struct rest rest = {mark ? mark + 1 : data, mark ? size - own - 1 : 0};
    uint8_t *model = malloc(own > 0 ? own : 1); /* so that a read behind its end is found */
    must(model != NULL);
    memcpy(model, data ? data : (const uint8_t *)"", own);
    read_model(model, own, PEN_MODEL_OBJ, fetch, &rest);
    free(model);
    return 0;
}
