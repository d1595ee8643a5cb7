/* SPDX-License-Identifier: MIT */
#include "store/internal/compress.h"

#include <stdlib.h>
#include <zstd.h>
#include <zstd_errors.h>

struct pen_compressor {
    ZSTD_CCtx *pack;
    ZSTD_DCtx *unpack;
    unsigned char *out; /* kept from call to call; only grows */
    size_t capacity;
};

struct pen_compressor *pen_compressor_new(int level)
{
    struct pen_compressor *packer = calloc(1, sizeof *packer);
    if (!packer)
        return NULL;
    packer->pack = ZSTD_createCCtx();
    packer->unpack = ZSTD_createDCtx();
    if (!packer->pack || !packer->unpack) {
        pen_compressor_free(packer);
        return NULL;
    }
    ZSTD_CCtx_setParameter(packer->pack, ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(packer->pack, ZSTD_c_checksumFlag, 1);
    return packer;
}

void pen_compressor_free(struct pen_compressor *packer)
{
    if (!packer)
        return;
    ZSTD_freeCCtx(packer->pack);
    ZSTD_freeDCtx(packer->unpack);
    free(packer->out);
    free(packer);
}

static bool make_room(struct pen_compressor *packer, size_t bytes, struct pen_status *st)
{
    if (bytes <= packer->capacity && packer->out)
        return true;
    free(packer->out);
    packer->capacity = 0;
    packer->out = malloc(bytes ? bytes : 1);
    if (!packer->out)
        return pen_fail(st, PEN_NO_MEMORY, "no memory for %zu bytes of packed data", bytes);
    packer->capacity = bytes;
    return true;
}

bool pen_compress(struct pen_compressor *packer, const void *data, size_t bytes,
                  struct pen_bytes *out, struct pen_status *st)
{
    size_t bound = ZSTD_compressBound(bytes);
    if (!make_room(packer, bound, st))
        return false;
    size_t n = ZSTD_compress2(packer->pack, packer->out, bound, data, bytes);
    if (ZSTD_isError(n))
        return pen_fail(st, PEN_NO_MEMORY, "cannot pack: %s", ZSTD_getErrorName(n));
    *out = (struct pen_bytes){packer->out, n};
    return true;
}

bool pen_decompress(struct pen_compressor *packer, const void *data, size_t bytes,
                    struct pen_bytes *out, struct pen_status *st)
{
    unsigned long long size = ZSTD_getFrameContentSize(data, bytes);
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > SIZE_MAX)
        return pen_fail(st, PEN_STORAGE, "stored data is damaged: no packed frame");
    if (!make_room(packer, (size_t)size, st))
        return false;
    size_t n = ZSTD_decompressDCtx(packer->unpack, packer->out, packer->capacity, data, bytes);
    if (ZSTD_isError(n) && ZSTD_getErrorCode(n) == ZSTD_error_memory_allocation)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to unpack stored data");
    if (ZSTD_isError(n) || n != size)
        return pen_fail(st, PEN_STORAGE, "stored data is damaged: %s",
                        ZSTD_isError(n) ? ZSTD_getErrorName(n) : "wrong size");
    *out = (struct pen_bytes){packer->out, n};
    return true;
}
