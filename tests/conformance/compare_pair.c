/* SPDX-License-Identifier: MIT */
/* Compares a picture with that of another implementation of the shading model:
 *
 *     compare_pair REFERENCE.png OURS.png
 *
 * prints `SHARE RMSE UNEXPLAINED` (the share of pixels that agree, in per cent; the RMSE over these
 * pixels; the number of other pixels without an edge beside them) and, on standard error, the first
 * unexplained pixels. Exit code 0: the pair conforms; 1: it does not; 2: it could not be compared.
 *
 *   - A pixel agrees if no channel differs by more than 2/255.
 *   - 99.7 % of the pixels must agree, and their RMSE must be at most 0.004.
 *   - Every other pixel must have an edge within one pixel: a silhouette, an edge between two
 *     primitives, or the outline of a shadow. The reference shows such an edge: among the pixel's
 *     eight neighbours in it, some channel varies by at least the difference of the two pictures at
 *     the pixel, within 2/255. So a dot, a crack or a line in our picture alone is never excused.
 *
 * The reference holds linear values times 255 but has no tag for that, so its encoded values are
 * taken as linear ones. Our picture has a tag that it is linear. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "film/picture.h"

static const int TOLERANCE = 2;       /* of 255 */
static const double SHARE_MIN = 99.7; /* per cent */
static const double RMSE_MAX = 0.004; /* of values in [0, 1] */
static const int64_t UNEXPLAINED_SHOWN = 10;

/* 8-bit values, 3 a pixel. */
struct raster {
    int width, height;
    unsigned char *rgb;
};

static struct pen_picture *read_picture(const char *path)
{
    struct pen_status st;
    FILE *file = fopen(path, "rb");
    long bytes = file && fseek(file, 0, SEEK_END) == 0 ? ftell(file) : -1;
    char *data = bytes > 0 ? malloc((size_t)bytes) : NULL;
    struct pen_picture *picture = NULL;
    if (data && fseek(file, 0, SEEK_SET) == 0 &&
        fread(data, 1, (size_t)bytes, file) == (size_t)bytes)
        picture = pen_picture_read(data, (size_t)bytes, &st);
    else
        pen_fail(&st, PEN_IO, "cannot be read");
    if (!picture)
        fprintf(stderr, "%s: %s\n", path, st.msg);
    free(data);
    if (file)
        fclose(file);
    return picture;
}

typedef void row_reader(const struct pen_picture *picture, int y, double *out);

static bool read_raster(const char *path, row_reader *read_row, struct raster *out)
{
    struct pen_picture *picture = read_picture(path);
    if (!picture)
        return false;
    *out = (struct raster){pen_picture_width(picture), pen_picture_height(picture), NULL};
    size_t row_values = (size_t)out->width * 3;
    double *row = malloc(row_values * sizeof *row);
    out->rgb = malloc(row_values * (size_t)out->height);
    for (int y = 0; row && out->rgb && y < out->height; y++) {
        read_row(picture, y, row);
        for (size_t i = 0; i < row_values; i++)
            out->rgb[(size_t)y * row_values + i] = (unsigned char)floor(255 * row[i] + 0.5);
    }
    bool ok = row && out->rgb;
    free(row);
    pen_picture_free(picture);
    return ok;
}

static int value(const struct raster *r, int x, int y, int channel)
{
    return r->rgb[((size_t)y * (size_t)r->width + (size_t)x) * 3 + (size_t)channel];
}

/* The largest difference of a channel at a pixel. */
static int difference(const struct raster *a, const struct raster *b, int x, int y)
{
    int most = 0;
    for (int channel = 0; channel < 3; channel++) {
        int d = abs(value(a, x, y, channel) - value(b, x, y, channel));
        most = d > most ? d : most;
    }
    return most;
}

/* By how much a channel varies among the neighbours of a pixel, the pixel itself left out. */
static int variation(const struct raster *r, int x, int y)
{
    int most = 0;
    for (int channel = 0; channel < 3; channel++) {
        int lo = 255, hi = 0;
        for (int i = 0; i < 9; i++) {
            int u = x + i % 3 - 1, v = y + i / 3 - 1;
            if (i == 4 || u < 0 || v < 0 || u >= r->width || v >= r->height)
                continue;
            int c = value(r, u, v, channel);
            lo = c < lo ? c : lo;
            hi = c > hi ? c : hi;
        }
        most = hi - lo > most ? hi - lo : most;
    }
    return most;
}

static double squared(const struct raster *a, const struct raster *b, int x, int y)
{
    double sum = 0;
    for (int channel = 0; channel < 3; channel++) {
        double d = (value(a, x, y, channel) - value(b, x, y, channel)) / 255.0;
        sum += d * d;
    }
    return sum;
}

static bool judge(const struct raster *reference, const struct raster *ours)
{
    int64_t agreeing = 0, unexplained = 0;
    int64_t pixels = (int64_t)reference->width * reference->height;
    double sum = 0;
    for (int y = 0; y < reference->height; y++) {
        for (int x = 0; x < reference->width; x++) {
            int d = difference(reference, ours, x, y);
            if (d <= TOLERANCE) {
                agreeing++;
                sum += squared(reference, ours, x, y);
            } else if (variation(reference, x, y) < d - TOLERANCE) {
                if (unexplained++ < UNEXPLAINED_SHOWN)
                    fprintf(stderr, "pixel %d,%d differs by %d, and no edge is there\n", x, y, d);
            }
        }
    }
    double share = 100.0 * (double)agreeing / (double)pixels;
    double rmse = agreeing ? sqrt(sum / (3 * (double)agreeing)) : 0;
    printf("%8.4f %9.6f %6lld\n", share, rmse, (long long)unexplained);
    return share >= SHARE_MIN && rmse <= RMSE_MAX && unexplained == 0;
}

int main(int argc, char **argv)
{
    struct raster reference = {0}, ours = {0};
    int code = 2;
    if (argc != 3)
        fprintf(stderr, "usage: compare_pair REFERENCE.png OURS.png\n");
    else if (!read_raster(argv[1], pen_picture_encoded_row, &reference) ||
             !read_raster(argv[2], pen_picture_linear_row, &ours))
        fprintf(stderr, "there is nothing to compare\n");
    else if (reference.width != ours.width || reference.height != ours.height)
        fprintf(stderr, "sizes differ: %d x %d and %d x %d\n", reference.width, reference.height,
                ours.width, ours.height);
    else
        code = judge(&reference, &ours) ? 0 : 1;
    free(reference.rgb);
    free(ours.rgb);
    return code;
}
