/* SPDX-License-Identifier: MIT */
/* Stored pixels are read back bit for bit. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "store/internal/compress.h"
#include "support/random.h"
#include "support/store.h"
#include "support/suite.h"

static struct store_bed bed;
static struct store_job job;

enum { SIDE = STORE_JOB_TILE, TILE_PIXELS = SIDE * SIDE, MOST = 3 * PEN_PIXELS_SLICE + 1 };
static float sent[3 * MOST];

/* Smooth values, equal values, and random bit patterns, NaNs among them. */
static void fill(struct random *random, int pixels)
{
    for (int i = 0; i < 3 * pixels; i++) {
        uint32_t bits = (uint32_t)random_bits(random);
        switch (i / 999 % 3) {
        case 0:
            sent[i] = 0.25F + (float)i * 1e-6F + (float)random_unit(random) * 1e-4F;
            break;
        case 1:
            sent[i] = i > 3 ? sent[i - 3] : 0;
            break;
        default:
            memcpy(&sent[i], &bits, sizeof bits);
        }
    }
}

/* Submits a job of one batch of so many pixels, and claims it. */
static struct pen_claim claim_of(int n, int pixels)
{
    store_job_init(&job, n, 1, 1);
    job.view[0].width = pixels;
    job.view[0].height = 1;
    job.batch[0].pixels = pixels;
    store_job_submit(bed.store, &job);
    return store_claim(bed.store, "w");
}

static enum pen_code commit(const struct pen_claim *claim, struct pen_result *result)
{
    struct pen_status st = {0};
    result->stats = "{}";
    result->layer = "beauty";
    result->format = "png";
    result->artefact = "picture";
    result->artefact_bytes = 7;
    return pen_store_commit(bed.store, claim, result, NULL, &st) ? PEN_OK : st.code;
}

static bool compare(void *user, int first_tile, int tile_count, const float *rgb, int64_t pixels)
{
    (void)first_tile;
    (void)tile_count;
    ck_assert_mem_eq(rgb, sent, (size_t)pixels * 3 * sizeof *rgb);
    *(int64_t *)user += pixels;
    return true;
}

static void check_stored(int pixels)
{
    struct pen_status st;
    int64_t seen = 0;
    store_must(pen_store_pixels(bed.store, job.id, 0, compare, &seen, &st), &st, "pixels");
    ck_assert_int_eq(seen, pixels);
}

START_TEST(test_pixels__come_back_bit_for_bit_whatever_their_number)
{
    static const int counts[] = {
        1, 2, 3, 1000, PEN_PIXELS_SLICE - 1, PEN_PIXELS_SLICE, PEN_PIXELS_SLICE + 1, MOST};
    struct random random = random_begin(71);
    store_bed_open(&bed);
    for (int i = 0; i < (int)(sizeof counts / sizeof counts[0]); i++) {
        fill(&random, counts[i]);
        printf("seed %llu, %d pixels\n", (unsigned long long)random.seed, counts[i]);
        struct pen_claim claim = claim_of(i, counts[i]);
        struct pen_result result = {.rgb = sent, .pixels = counts[i]};
        ck_assert_int_eq(commit(&claim, &result), PEN_OK);
        check_stored(counts[i]);
    }
    store_bed_close(&bed);
}
END_TEST

PEN_SUITE("store pixels", test_pixels__come_back_bit_for_bit_whatever_their_number)
