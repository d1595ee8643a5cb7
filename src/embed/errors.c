/* SPDX-License-Identifier: MIT */
/* Error lists, and structures whose size the caller states. */
#include <stdlib.h>
#include <string.h>

#include "embed/internal/embed.h"

enum { TEXT_BYTES = PEN_AT_BYTES + PEN_MSG_BYTES + 32 };

struct located {
    struct pen_status status;
    char text[TEXT_BYTES];
};

struct penumbra_errors {
    size_t count, total; /* kept in item[], and found */
    struct located item[];
};

/* Returned when a list cannot be allocated; not in the heap and never written. */
static const struct pen_status out_of_memory = {.code = PEN_NO_MEMORY, .msg = "out of memory"};
static const struct penumbra_errors no_list = {.count = 0, .total = 1};

static struct penumbra_errors *errors_new(const struct pen_status *item, size_t count, size_t total)
{
    struct penumbra_errors *list = malloc(sizeof *list + count * sizeof *list->item);
    if (!list)
        return (struct penumbra_errors *)(uintptr_t)&no_list;
    list->count = count;
    list->total = total;
    for (size_t i = 0; i < count; i++) {
        list->item[i].status = item[i];
        pen_status_describe(&item[i], NULL, list->item[i].text, TEXT_BYTES);
    }
    return list;
}

bool pen_embed_fail(struct penumbra_errors **errors, const struct pen_status *st)
{
    if (errors)
        *errors = errors_new(st, 1, 1);
    return false;
}

bool pen_embed_fail_list(struct penumbra_errors **errors, const struct pen_errors *list)
{
    if (errors)
        *errors = errors_new(list->item, list->count, list->total);
    return false;
}

size_t penumbra_errors_count(const struct penumbra_errors *errors)
{
    return errors ? errors->total : 0;
}

int penumbra_errors_get(const struct penumbra_errors *errors, size_t index,
                        struct penumbra_error *error)
{
    const struct pen_status *st = &out_of_memory;
    const char *text = out_of_memory.msg;
    if (!errors)
        return 0;
    if (errors != &no_list && index < errors->count) {
        st = &errors->item[index].status;
        text = errors->item[index].text;
    } else if (errors != &no_list || index > 0) {
        return 0;
    }
    struct penumbra_error full = {.code = pen_code_name(st->code),
                                  .message = st->msg,
                                  .pointer = st->at,
                                  .line = st->line,
                                  .column = st->column,
                                  .text = text};
    return pen_embed_give(&full, sizeof full, error);
}

void penumbra_errors_free(struct penumbra_errors *errors)
{
    if (errors != &no_list)
        free(errors);
}

static size_t size_of(const void *structure)
{
    size_t size;
    memcpy(&size, structure, sizeof size);
    return size;
}

bool pen_embed_take(const void *given, void *out, size_t known)
{
    size_t size = size_of(given);
    if (size < sizeof size)
        return false;
    for (size_t i = known; i < size; i++) {
        if (((const unsigned char *)given)[i] != 0)
            return false;
    }
    memset(out, 0, known);
    memcpy(out, given, size < known ? size : known);
    return true;
}

bool pen_embed_give(const void *from, size_t known, void *to)
{
    size_t size = size_of(to);
    if (size < sizeof size)
        return false;
    if (size > known)
        size = known;
    memcpy((char *)to + sizeof size, (const char *)from + sizeof size, size - sizeof size);
    return true;
}

void *pen_embed_detach(struct pen_buf *buf)
{
    void *data = buf->data;
    *buf = (struct pen_buf){0};
    return data;
}

void penumbra_free(void *memory)
{
    free(memory);
}
