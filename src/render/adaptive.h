/* SPDX-License-Identifier: MIT */
/* Adaptive rendering: to a target error instead of numbers of samples.
 *
 * The samples of a pixel are the first 2^k points of one scrambled Sobol' sequence (math/sample.h).
 * Each half of them is as evenly spread as its number of points allows, and the halves are
 * exchangeable. Let a and b be the means of the halves, with n samples each, and q(n) the mean
 * square error of a mean of n samples. Then
 *     (a - b)^2 / 4 is q(n) - q(2n) in the mean.
 * Independent halves would have q(2n) = q(n) / 2; then this would be q(2n), the error of their
 * mean. These halves are better, because the second half fills the gaps of the first. Across an
 * edge q falls as n^-1.5. Then q(2n) is 0.7 of that of independent halves, and the estimate from
 * the halves is 1.8 times the error. A part of this excess is known after an earlier doubling: see
 * true_part in decide.c. The estimate is too low if q falls more slowly than for independent
 * samples. This happens for a while with features as large as the cells that the sequence fills
 * next. The worst case found is 0.74 of q with two samples, for stripes or waves at 45 degrees with
 * a period of 0.35 to 0.5 pixels. With eight samples it is 0.8, for checks of a quarter of a pixel
 * along its sides (tests/render/test_halves.c).
 *
 * Rendering has rounds. The first, the pilot, takes pen_settings_pilot samples of every pixel.
 * After a round the error of the whole picture is estimated. While it is above the target, the next
 * round doubles the samples of the pixels that lower it most. So estimates are used only after
 * doublings. A decision is a pure function of the sums of all pixels, and these are a pure function
 * of scene, settings and decisions. So the picture has the same bits for any number of threads and
 * any order of tiles.
 *
 * The error is the root mean square over all values of the picture, each clamped to [0, 1] and
 * encoded by the transfer function. The reference is the picture with all sampled effects
 * converged.
 *
 * Reasons for the rule:
 *  - A pixel's own estimate has a single degree of freedom. If pixels whose halves agree by chance
 *    were not refined, the mean of the estimates would be too low. So the estimates of a pixel's
 *    eight neighbours, which are independent of its own, decide whether it is refined. The mean of
 *    the own estimates then stays unbiased.
 *  - Samples may miss an edge that passes between them, and then both halves agree. Such an edge
 *    separates pixels of different values. So a pixel's estimate is at least that of an unseen edge
 *    as strong as the largest difference to a neighbour: see unseen_edge in decide.c.
 *  - Small and bright things that a pixel's beam may meet are known before the pilot. Samples look
 *    for them. A share of 1 / n of the things counts as unseen until n samples have seen it:
 *    render/internal/beams.h.
 *  - Anything else that all samples of a pixel and of its neighbours miss remains unseen. A feature
 *    that covers a share v of them is missed by n samples with a probability of about (1 - v)^(9
 *    n). */
#ifndef PEN_RENDER_ADAPTIVE_H
#define PEN_RENDER_ADAPTIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/thread_pool.h"
#include "scene/settings.h"

/* The number of the rule. Another rule gives other rounds, and so other pictures. Rule 1 ignored
 * small and bright things. */
enum { PEN_ADAPTIVE_RULE = 2 };

/* The sums of a pixel's samples, for the first and the second half of its sequence. */
struct pen_pixel_sums {
    double sum[2][3]; /* of the samples that are kept: linear colour */
    double kept[2];   /* sum of the weights of the samples that the film can hold; a weight is 1
                         unless samples look for things (pen_beam_sample) */
    uint32_t samples; /* number of samples taken, in both halves: 0, or a power of two from 2 on */
    float before; /* the estimated error with half the samples; 0 if they are those of the pilot */
    uint32_t looks; /* enum pen_looks */
};

/* Whether samples look for the small things of a pixel (render/internal/beams.h). It is decided
 * when the pixel is first refined. If the samples of the pilot agree, they are dropped, and the
 * pixel begins again with samples that look. A mean of both would give the pilot's samples too much
 * weight. */
enum pen_looks { PEN_LOOKS_UNDECIDED, PEN_LOOKS, PEN_LOOKS_NOT };

/* The result of a pixel's sums. */
struct pen_pixel_estimate {
    float value[3]; /* encoded, in [0, 1] */
    float error;    /* mean square error of the three values, estimated from the halves */
};

/* The state of one view between rounds. Arrays have one value per pixel, row by row; one allocation
 * holds them all. */
struct pen_adaptive {
    const struct pen_settings *settings; /* those of the render */
    struct pen_settings sampling;        /* the settings that kernels get instead */
    struct pen_beams *beams;             /* set before the pilot; NULL: no thing in the view */
    bool has_beams;
    struct pen_pixel_sums *sums; /* at the start of the allocation */
    struct pen_pixel_estimate *estimates;
    float *unseen;      /* mean square errors of edges that perhaps no sample has seen */
    float *errors;      /* the errors of `estimates`, but at least `unseen` */
    float *things;      /* the most that unseen things may add to `errors` */
    uint16_t *priority; /* 1 + the level for pen_adaptive_select; 0: no more samples are allowed */
    unsigned char *wanted; /* pixels that the next round refines */
    bool refined;          /* a round after the pilot has been selected */
    void *slices;          /* for pen_adaptive_decide, whose first call makes them; NULL before */
};

/* Makes the state before the pilot, which wants all pixels. It borrows the settings.
 * Owns: free with pen_adaptive_free.
 * Fails: NULL; PEN_NO_MEMORY. */
struct pen_adaptive *pen_adaptive_new(const struct pen_settings *settings, struct pen_status *st);
void pen_adaptive_free(struct pen_adaptive *adaptive);

/* Prepares for doubling a pixel's samples: those taken become the first half, and the second half
 * is empty. */
void pen_pixel_double(struct pen_pixel_sums *sums);

/* The linear colour of a pixel: the mean of its samples; black without any. */
void pen_pixel_mean(const struct pen_pixel_sums *sums, double rgb[3]);

/* Sets the estimate of a pixel from its sums, and its linear colour, which is that of
 * pen_pixel_mean.
 * Threads: any number, for different pixels. */
void pen_adaptive_estimate(struct pen_adaptive *adaptive, size_t pixel, float rgb[3]);

/* Whether the halves of a pixel's samples agree, so that their variance is no evidence. */
bool pen_pixel_same(const struct pen_adaptive *adaptive, size_t pixel);

/* The same, while it is undecided whether the pixel's samples look for small things. */
bool pen_pixel_agrees(const struct pen_adaptive *adaptive, size_t pixel);

/* The things that samples of a pixel look for; NULL: none. */
const struct pen_beams *pen_adaptive_beams(const struct pen_adaptive *adaptive, size_t pixel);

/* Begins a round for a pixel: stores the error before it. Returns the number of samples that the
 * round adds.
 * Threads: any number, for different pixels. */
uint32_t pen_adaptive_begin_pixel(struct pen_adaptive *adaptive, size_t pixel);

/* The probability that an error is at most the upper end of its interval. */
#define PEN_ADAPTIVE_CONFIDENCE 0.99

/* The result of a round. The lower end of the interval allows that every pixel's error is as far
 * below the estimate of its halves as it is across an edge. */
struct pen_decision {
    double error, low, high; /* the estimated error and its interval */
    bool met;                /* high is at most the target */
    bool done;               /* no further round: the target is met, or no pixel can be refined */
    int level;               /* the pixels of the next round: pen_adaptive_select */
    double unproven; /* share of pixels that unseen things may change by more than the target; 0 if
                        the target is met, since the interval then includes them */
    uint64_t capped; /* pixels that would be refined if max_samples allowed more samples */
};

/* The goal of a decision. */
struct pen_goal {
    double target;
    /* The most camera rays that the next round may take; UINT64_MAX for any number. With a limit,
     * the next round aims at a part of the error only, so that rays are spent where they lower it
     * most. */
    uint64_t samples;
};

/* Decides after a round, for which all estimates are set: the error, and the pixels to refine in
 * order to reach the target.
 * Threads: as pen_render_run.
 * Fails: PEN_NO_MEMORY. */
bool pen_adaptive_decide(struct pen_adaptive *adaptive, struct pen_thread_pool *pool,
                         const struct pen_goal *goal, struct pen_decision *decision,
                         struct pen_status *st);

/* Selects the pixels of the next round: those whose priority is at least `level`. The priority is
 * the error of their neighbourhood per sample, in eighths of powers of two. Returns their number.
 * pen_adaptive_decide must have been called after the round. */
uint64_t pen_adaptive_select(struct pen_adaptive *adaptive, int level);

/* The distribution of samples: camera rays for each pixel. */
struct pen_sample_spread {
    double mean;
    uint32_t least, median, p95, most;
};
struct pen_sample_spread pen_adaptive_spread(const struct pen_adaptive *adaptive);

#endif
