/* SPDX-License-Identifier: MIT */
/* zstd behind the interface of compress.h. */
#include "store/internal/compress.h"

#include <stdlib.h>
#include <zstd.h>
#include <zstd_errors.h>

#include "base/buf.h"

/* A block has at least BLOCK_IN bytes and holds at most BLOCK_OUT bytes (RFC 8878, section
 * 3.1.1.2). So a damaged frame that claims a larger size is not allocated. */
enum { BLOCK_IN = 4, BLOCK_OUT = 128 << 10 };

struct pen_compressor {
    ZSTD_CCtx *compress;
    ZSTD_DCtx *decompress;
    struct pen_buf out; /* memory kept from call to call */
};

struct pen_compressor *pen_compressor_new(int level)
{
    struct pen_compressor *compressor = calloc(1, sizeof *compressor);
    if (!compressor)
        return NULL;
    compressor->compress = ZSTD_createCCtx();
    compressor->decompress = ZSTD_createDCtx();
    if (!compressor->compress || !compressor->decompress) {
        pen_compressor_free(compressor);
        return NULL;
    }
    ZSTD_CCtx_setParameter(compressor->compress, ZSTD_c_compressionLevel, level);
    ZSTD_CCtx_setParameter(compressor->compress, ZSTD_c_checksumFlag, 1);
    return compressor;
}

void pen_compressor_free(struct pen_compressor *compressor)
{
    if (!compressor)
        return;
    ZSTD_freeCCtx(compressor->compress);
    ZSTD_freeDCtx(compressor->decompress);
    pen_buf_release(&compressor->out);
    free(compressor);
}

static bool reserve(struct pen_compressor *compressor, size_t bytes, struct pen_status *st)
{
    return pen_buf_reserve(&compressor->out, bytes) ||
           pen_fail(st, PEN_NO_MEMORY, "no memory for %zu bytes of compressed data", bytes);
}

bool pen_compress(struct pen_compressor *compressor, const void *data, size_t bytes,
                  struct pen_bytes *out, struct pen_status *st)
{
    size_t bound = ZSTD_compressBound(bytes);
    if (!reserve(compressor, bound, st))
        return false;
    size_t n = ZSTD_compress2(compressor->compress, compressor->out.data, bound, data, bytes);
    if (ZSTD_isError(n))
        return pen_fail(st, PEN_NO_MEMORY, "cannot compress: %s", ZSTD_getErrorName(n));
    *out = (struct pen_bytes){compressor->out.data, n};
    return true;
}

bool pen_decompress(struct pen_compressor *compressor, const void *data, size_t bytes,
                    struct pen_bytes *out, struct pen_status *st)
{
    const unsigned long long size = ZSTD_getFrameContentSize(data, bytes);
    if (size == ZSTD_CONTENTSIZE_UNKNOWN || size == ZSTD_CONTENTSIZE_ERROR || size > SIZE_MAX)
        return pen_fail(st, PEN_STORAGE, "stored data is damaged: not a compressed frame");
    if (size / BLOCK_OUT > bytes / BLOCK_IN)
        return pen_fail(st, PEN_STORAGE, "stored data is damaged: %zu bytes cannot hold %llu",
                        bytes, size);
    if (!reserve(compressor, (size_t)size, st))
        return false;
    size_t n = ZSTD_decompressDCtx(compressor->decompress, compressor->out.data, (size_t)size, data,
                                   bytes);
    if (ZSTD_isError(n) && ZSTD_getErrorCode(n) == ZSTD_error_memory_allocation)
        return pen_fail(st, PEN_NO_MEMORY, "no memory to decompress stored data");
    if (ZSTD_isError(n) || n != size)
        return pen_fail(st, PEN_STORAGE, "stored data is damaged: %s",
                        ZSTD_isError(n) ? ZSTD_getErrorName(n) : "wrong size");
    *out = (struct pen_bytes){compressor->out.data, n};
    return true;
}
