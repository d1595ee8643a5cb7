/* SPDX-License-Identifier: MIT */
#include "support/corrupt.h"

#include <check.h>
#include <stdio.h>
#include <string.h>

void corrupt_read(const char *path, struct corrupt_text *text)
{
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    text->bytes = fread(text->data, 1, sizeof text->data / 2, file);
    fclose(file);
}

static void insert(struct corrupt_text *text, size_t at, const char *piece, size_t bytes)
{
    if (text->bytes + bytes > sizeof text->data)
        return;
    memmove(text->data + at + bytes, text->data + at, text->bytes - at);
    memcpy(text->data + at, piece, bytes);
    text->bytes += bytes;
}

static size_t somewhere(struct random *random, const struct corrupt_text *text)
{
    return random_below(random, (uint32_t)text->bytes + 1);
}

/* Changes the next digit to another, or to a character that numbers have: the text mostly stays
 * well-formed. */
static void change_digit(struct random *random, struct corrupt_text *text, size_t at)
{
    while (at < text->bytes && (text->data[at] < '0' || text->data[at] > '9'))
        at++;
    if (at < text->bytes)
        text->data[at] = "0123456789-.e "[random_below(random, 14)];
}

void corrupt(struct random *random, struct corrupt_text *text, const struct corrupt_kind *kind)
{
    char copy[64], byte = (char)random_below(random, 256);
    const char *piece = kind->piece[random_below(random, (uint32_t)kind->count)];
    size_t at = somewhere(random, text), left = text->bytes - at;
    size_t some = random_below(random, sizeof copy);
    some = some < left ? some : left;
    switch (random_below(random, 6)) {
    case 0:
        insert(text, at, piece, strlen(piece));
        break;
    case 1:
        insert(text, at, &byte, 1);
        break;
    case 2:
        memmove(text->data + at, text->data + at + some, left - some);
        text->bytes -= some;
        break;
    case 3:
        memcpy(copy, text->data + at, some);
        insert(text, somewhere(random, text), copy, some);
        break;
    case 4:
        change_digit(random, text, at);
        break;
    default:
        if (left > 0)
            text->data[at] = byte;
        break;
    }
}
