/* SPDX-License-Identifier: MIT */
/* Any bytes as stored pixels and as a stored document. The first two bytes are the number of
 * pixels. */
#include "fuzz/fuzz.h"
#include "store/internal/compress.h"

enum { PIXELS = 1 << 12 };

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static struct pen_compressor *compressor;
    struct pen_status st = {0};
    if (!compressor)
        compressor = pen_compressor_new(1);
    must(compressor != NULL);
    if (size < 2)
        return 0;
    const size_t count = (size_t)(data[0] << 8 | data[1]) % PIXELS;
    struct pen_bytes in = {data + 2, size - 2}, out = {0};
    float *rgb = malloc((3 * count + 1) * sizeof *rgb);
    must(rgb != NULL);
    if (!pen_pixels_decode(compressor, &in, rgb, (int64_t)count, &st))
        must(st.code == PEN_STORAGE);
    free(rgb);
    if (pen_decompress(compressor, in.data, in.bytes, &out, &st))
        must(out.data != NULL);
    return 0;
}
