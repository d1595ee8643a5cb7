/* SPDX-License-Identifier: MIT */
/* Adaptive rendering: to a target error instead of numbers of samples.
 *
 * The samples of a pixel are the first 2^k points of one scrambled Sobol' sequence
 * (math/sample.h). Their two halves are each as evenly spread as so many points can be, and
 * exchangeable. So with a and b the means of the halves, q(n) the mean square error of a mean of n
 * samples, and n samples in each half,
 *     (a - b)^2 / 4 is q(n) - q(2n) in the mean.
 * Independent halves would have q(2n) = q(n) / 2, so that this would be q(2n), the error of their
 * mean. These are better: the second half fills what the first leaves open. Across an edge q falls
 * as n^-1.5, and then q(2n) is 0.7 of what independent halves would have, and the halves tell 1.8
 * times as much as it is. A part of what they tell too much is known as soon as there was a
 * doubling before: see true_part in decide.c. They tell too little where q falls more slowly than
 * that of independent samples, as it does for a while with features as large as the cells that the
 * sequence fills next. The worst that was found: 0.74 of q with two samples, for stripes or waves
 * at 45 degrees that are 0.35 to 0.5 pixels from one to the next; 0.8 with eight, for checks of a
 * quarter of a pixel along its sides (tests/render/test_halves.c).
 *
 * Rendering goes in rounds. The first, the pilot, takes pen_settings_pilot samples of every pixel.
 * After a round the error of the whole picture is estimated. While that is above the target, the
 * next round doubles the samples of the pixels that lower it most, so that estimates are looked at
 * only after doublings. A decision is a pure function of the sums of all pixels, and these are a
 * pure function of scene, settings and decisions. So the picture has the same bits for any number
 * of threads and any order of tiles.
 *
 * The error is the root mean square of all values of the picture, each clamped to [0, 1] and
 * encoded by the transfer function, against the picture with all sampled effects converged.
 *
 * How the rule is made:
 *  - A pixel's own estimate has a single degree of freedom. If pixels whose halves agree by chance
 *    were left as they are, the mean of the estimates would be too low. So what is refined is
 *    chosen by the estimates of a pixel's eight neighbours, which are independent of its own; the
 *    mean of the own ones then stays true.
 *  - Samples may miss an edge that passes between them, and then both halves agree. Such an edge
 *    separates pixels of different values. So a pixel's estimate is at least that of an unseen edge
 *    as strong as the largest difference to a neighbour: see unseen_edge in decide.c.
 *  - Small and bright things that the beam of a pixel may meet are known before the pilot. Samples
 *    look for them, and a share of 1 / n of them counts as unseen until these have seen it:
 *    render/internal/beams.h.
 *  - What else all samples of a pixel and of its neighbours miss remains unseen: something that
 *    covers a share v of them is missed by n samples with a probability of about (1 - v)^(9 n). */
#ifndef PEN_RENDER_ADAPTIVE_H
#define PEN_RENDER_ADAPTIVE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"
#include "base/thread_pool.h"
#include "scene/settings.h"

/* The number of the rule: another rule gives other rounds, and so other pictures. 1 knew nothing of
 * small and bright things. */
enum { PEN_ADAPTIVE_RULE = 2 };

/* The samples of a pixel, those of the first and of the second half of its sequence. */
struct pen_pixel_sums {
    double sum[2][3]; /* of the samples that are kept: linear colour */
    double kept[2];   /* the weights of those that the film can hold: 1 for each, but where samples
                       * look for things (pen_beam_sample) */
    uint32_t samples; /* taken, of both halves: 0, or a power of two from 2 on */
    float before;     /* the estimated error with half of them; 0 with those of the pilot */
    uint32_t looks;   /* enum pen_looks */
};

/* Whether samples look for the small things of a pixel (render/internal/beams.h). It is decided
 * when the pixel is first refined. If samples of the pilot agree, they are dropped: the pixel is
 * begun again with samples that look, since a mean of both would have too much of the pilot's. */
enum pen_looks { PEN_LOOKS_UNDECIDED, PEN_LOOKS, PEN_LOOKS_NOT };

/* What follows from them. */
struct pen_pixel_estimate {
    float value[3]; /* encoded, in [0, 1] */
    float error;    /* mean square error of the three values, estimated from the halves */
};

/* The state of one view between rounds. Arrays have a value for each pixel, row by row; one
 * allocation holds them all. */
struct pen_adaptive {
    const struct pen_settings *settings; /* those of the render */
    struct pen_settings sampling;        /* what kernels get instead */
    struct pen_beams *beams;             /* set before the pilot; NULL: no thing in the view */
    bool has_beams;
    struct pen_pixel_sums *sums; /* at the start of the allocation */
    struct pen_pixel_estimate *estimates;
    float *unseen;         /* mean square errors of edges that no sample may have seen */
    float *errors;         /* those of estimates, but at least unseen */
    float *things;         /* what unseen things may add to that, at most */
    uint16_t *priority;    /* 1 + that of pen_adaptive_select; 0: no more samples are allowed */
    unsigned char *wanted; /* pixels that the next round refines */
    bool refined;          /* a round after the pilot has been selected */
    void *slices; /* for pen_adaptive_decide, which makes them; NULL before its first call */
};

/* The state before the pilot, which wants all pixels. It borrows the settings.
 * Owns: free with pen_adaptive_free. Fails: NULL; PEN_NO_MEMORY. */
struct pen_adaptive *pen_adaptive_new(const struct pen_settings *settings, struct pen_status *st);
void pen_adaptive_free(struct pen_adaptive *adaptive);

/* Makes room for as many samples as a pixel has: those are the first half from now on, and the
 * second half is empty. */
void pen_pixel_double(struct pen_pixel_sums *sums);

/* The linear colour of a pixel: the mean of its samples; black without any. */
void pen_pixel_mean(const struct pen_pixel_sums *sums, double rgb[3]);

/* Sets the estimate of a pixel from its sums, and its linear colour: that of pen_pixel_mean.
 * Threads: any number, for different pixels. */
void pen_adaptive_estimate(struct pen_adaptive *adaptive, size_t pixel, float rgb[3]);

/* Whether the halves of a pixel's samples agree: their variance is no evidence. */
bool pen_pixel_same(const struct pen_adaptive *adaptive, size_t pixel);

/* The same, if it is not decided yet whether its samples look for small things. */
bool pen_pixel_agrees(const struct pen_adaptive *adaptive, size_t pixel);

/* What samples of a pixel look for; NULL: for nothing. */
const struct pen_beams *pen_adaptive_beams(const struct pen_adaptive *adaptive, size_t pixel);

/* Begins a round for a pixel: notes the error before it. Returns how many samples the round adds.
 * Threads: any number, for different pixels. */
uint32_t pen_adaptive_begin_pixel(struct pen_adaptive *adaptive, size_t pixel);

/* The probability with which an error is at most the upper end of its interval. */
#define PEN_ADAPTIVE_CONFIDENCE 0.99

/* What is known after a round. The lower end of the interval allows for every pixel's error to be
 * as far below what its halves tell as it is across an edge. */
struct pen_decision {
    double error, low, high; /* the estimated error and its interval */
    bool met;                /* high is at most the target */
    bool done;               /* no further round: the target is met, or nothing can be refined */
    int level;               /* what the next round refines: pen_adaptive_select */
    double unproven; /* the share of pixels that unseen things may change by more than the target,
                      * unless it is met: then the interval has room for them */
    uint64_t capped; /* pixels that would be refined if max_samples let them have more samples */
};

/* What a decision aims at. */
struct pen_goal {
    double target;
    /* The most camera rays that the next round may take, UINT64_MAX for any number. With a limit
     * the next round goes no further than to a part of the error, so that rays are spent where they
     * lower it most. */
    uint64_t samples;
};

/* Decides after a round, all of whose estimates are set: what the error is, and which pixels have
 * to be refined to bring it to the target. Threads: as pen_render_run. Fails: PEN_NO_MEMORY. */
bool pen_adaptive_decide(struct pen_adaptive *adaptive, struct pen_thread_pool *pool,
                         const struct pen_goal *goal, struct pen_decision *decision,
                         struct pen_status *st);

/* Selects the pixels of the next round, those whose priority is at least of that level: the error
 * of their neighbourhood for each sample, in eighths of powers of two. Returns how many they are.
 * pen_adaptive_decide must have been called after the round. */
uint64_t pen_adaptive_select(struct pen_adaptive *adaptive, int level);

/* The distribution of samples: camera rays for each pixel. */
struct pen_sample_spread {
    double mean;
    uint32_t least, median, p95, most;
};
struct pen_sample_spread pen_adaptive_spread(const struct pen_adaptive *adaptive);

#endif
