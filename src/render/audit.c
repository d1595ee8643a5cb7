/* SPDX-License-Identifier: MIT */
/* Threads take the drawn pixels from a counter. The verdict on a pixel does not depend on other
 * pixels, so the result is the same for any number of threads. */
#include "render/audit.h"

#include <math.h>
#include <pthread.h>
#include <stdlib.h>

#include "film/encode.h"
#include "math/fn.h"
#include "math/sample.h"
#include "render/internal/audit_clusters.h"
#include "render/internal/kernel_input.h"
#include "render/internal/refine.h"
#include "render/transfer.h"

/* 99.99 % of Student's distribution with 7 degrees of freedom are within this. */
static const double STUDENT = 7.8846;

enum verdict { RIGHT, UNDECIDED, WRONG };

struct job {
    const struct pen_audit_task *task;
    struct pen_settings sampling; /* for rendering pixels again */
    struct pen_kernel_input input;
    const struct pen_kernel *kernel;
    struct pen_kernel_scratch **scratch; /* by thread */
    int threads;
    size_t *drawn; /* numbers of pixels */
    uint64_t count;
    pthread_mutex_t lock;
    uint64_t first,
        next; /* the pixels from the first begun one to the next; next is guarded by lock */
    uint64_t wrong, undecided;    /* guarded by lock */
    struct pen_audit_cell *cells; /* the same */
};

/* Draws pixels without replacement: skips numbers that were drawn before. */
static bool draw(struct job *job, size_t pixels, struct pen_status *st)
{
    const uint64_t wanted = job->task->pixels;
    unsigned char *taken = calloc(pixels, 1);
    job->count = wanted < pixels ? wanted : pixels;
    job->drawn = malloc(job->count * sizeof *job->drawn + 1);
    const uint64_t first = pen_mix64(job->task->seed);
    uint64_t n = 0;
    for (uint64_t i = 0; taken && job->drawn && n < job->count; i++) {
        const double place = (double)(pen_mix64(first + i) >> 11) * 0x1p-53;
        const size_t at = job->count == pixels ? (size_t)i : (size_t)(place * (double)pixels);
        if (!taken[at])
            job->drawn[n++] = at;
        taken[at] = 1;
    }
    const bool ok = (taken && job->drawn) ||
                    pen_fail(st, PEN_NO_MEMORY, "out of memory for the pixels of an audit");
    free(taken);
    return ok;
}

/* The number of samples for each replicate of a pixel. */
static uint32_t samples_for(const struct job *job, size_t at)
{
    const struct pen_audit_task *task = job->task;
    double all = task->samples;
    if (all == 0 && task->adaptive)
        all = (double)PEN_AUDIT_TIMES * task->adaptive->sums[at].samples;
    else if (all == 0)
        all = (double)PEN_AUDIT_TIMES * pen_camera_samples(job->input.lens.open, task->settings);
    if (job->task->samples == 0 && all < PEN_AUDIT_LEAST)
        all = PEN_AUDIT_LEAST;
    const double each = ceil(all / PEN_AUDIT_REPLICATES);
    return each < 1 << 30 ? (uint32_t)each : 1U << 30;
}

/* Renders the replicates of a pixel: their sums, and the colour of all of them together. */
static void render_again(const struct job *job, int thread, size_t at,
                         struct pen_pixel_sums replicate[PEN_AUDIT_REPLICATES], double rgb[3])
{
    const size_t width = (size_t)job->task->settings->width;
    const uint32_t samples = samples_for(job, at);
    struct pen_sample_range ranges[PEN_AUDIT_REPLICATES];
    struct pen_ray_counts rays = {.primary = 0};
    double kept = 0;
    for (uint32_t r = 0; r < PEN_AUDIT_REPLICATES; r++) {
        replicate[r] = (struct pen_pixel_sums){.samples = 0};
        ranges[r] = (struct pen_sample_range){.x = (int)(at % width),
                                              .y = (int)(at / width),
                                              .replicate = r,
                                              .end = samples,
                                              .sums = &replicate[r]};
    }
    pen_trace_samples(job->kernel, &job->input, job->scratch[thread], ranges, PEN_AUDIT_REPLICATES,
                      &rays);
    rgb[0] = rgb[1] = rgb[2] = 0;
    for (int r = 0; r < PEN_AUDIT_REPLICATES; r++) {
        pen_pixel_double(&replicate[r]);
        kept += replicate[r].kept[0];
        for (int c = 0; c < 3; c++)
            rgb[c] += replicate[r].sum[0][c];
    }
    for (int c = 0; c < 3; c++)
        rgb[c] = kept > 0 ? rgb[c] / kept : 0;
}

/* Judges a channel by its encoded value in the picture, the mean of all replicates, and their own
 * values. */
static enum verdict judge(double shown, double mean, const double *replicate, double threshold)
{
    double sum = 0, squares = 0;
    for (int r = 0; r < PEN_AUDIT_REPLICATES; r++)
        sum += replicate[r] / PEN_AUDIT_REPLICATES;
    for (int r = 0; r < PEN_AUDIT_REPLICATES; r++)
        squares += (replicate[r] - sum) * (replicate[r] - sum);
    const double off = STUDENT * sqrt(squares / (PEN_AUDIT_REPLICATES - 1) / PEN_AUDIT_REPLICATES);
    const double difference = shown > mean ? shown - mean : mean - shown;
    if (difference + off <= threshold)
        return RIGHT;
    return difference - off > threshold ? WRONG : UNDECIDED;
}

static enum verdict audit_pixel(const struct job *job, int thread, size_t at)
{
    const enum pen_transfer transfer = pen_settings_transfer(job->task->settings);
    struct pen_pixel_sums again[PEN_AUDIT_REPLICATES];
    enum verdict worst = RIGHT;
    double mean[3];
    render_again(job, thread, at, again, mean);
    for (int c = 0; c < 3; c++) {
        double replicate[PEN_AUDIT_REPLICATES];
        for (int i = 0; i < PEN_AUDIT_REPLICATES; i++) {
            const double kept = again[i].kept[0];
            const double linear = kept > 0 ? again[i].sum[0][c] / kept : mean[c];
            replicate[i] = pen_encode_unit(linear, transfer);
        }
        const double shown = pen_encode_unit((double)job->task->rgb[3 * at + (size_t)c], transfer);
        const enum verdict verdict =
            judge(shown, pen_encode_unit(mean[c], transfer), replicate, job->task->threshold);
        worst = verdict > worst ? verdict : worst;
    }
    return worst;
}

static bool is_cancelled(const struct job *job)
{
    return job->task->cancel && atomic_load_explicit(job->task->cancel, memory_order_relaxed);
}

/* Takes the next pixel for judgement, unless the audit is cancelled. Returns false if there is
 * none, or if the caller pauses. */
static bool take_pixel(struct job *job, uint64_t *i)
{
    const struct pen_audit_task *task = job->task;
    pthread_mutex_lock(&job->lock);
    if (job->next > job->first && job->next < job->count && task->pause &&
        task->pause(task->pause_user))
        job->count = job->next; /* later calls find no more either */
    *i = job->next;
    const bool more = job->next < job->count;
    job->next += more;
    pthread_mutex_unlock(&job->lock);
    return more;
}

static void audit_pixels(void *user, int thread)
{
    struct job *job = user;
    uint64_t i;
    while (!is_cancelled(job) && take_pixel(job, &i)) {
        const enum verdict verdict = audit_pixel(job, thread, job->drawn[i]);
        pthread_mutex_lock(&job->lock);
        if (verdict == WRONG)
            pen_audit_note_wrong(job->cells, job->task->settings, job->drawn[i]);
        job->wrong += verdict == WRONG;
        job->undecided += verdict == UNDECIDED;
        pthread_mutex_unlock(&job->lock);
    }
}

/* The settings for rendering pixels again: several camera rays, whose points can be continued. */
static struct pen_settings sampling_of(const struct pen_audit_task *task)
{
    struct pen_settings s = pen_settings_sampling(task->settings);
    s.samples_per_pixel = s.samples_per_pixel > 1 ? s.samples_per_pixel : 2;
    s.light_pattern = s.light_pattern == PEN_PATTERN_GRID ? PEN_PATTERN_SOBOL : s.light_pattern;
    s.seed = task->seed;
    return s;
}

static bool make_scratch(struct job *job, struct pen_status *st)
{
    job->scratch = calloc((size_t)job->threads, sizeof *job->scratch);
    for (int i = 0; job->scratch && i < job->threads; i++)
        if (!(job->scratch[i] = pen_kernel_scratch_new(&job->input)))
            return pen_fail(st, PEN_NO_MEMORY, "out of memory for the light paths of an audit");
    return job->scratch || pen_fail(st, PEN_NO_MEMORY, "out of memory for the threads of an audit");
}

static void release(struct job *job)
{
    for (int i = 0; job->scratch && i < job->threads; i++)
        pen_kernel_scratch_free(job->scratch[i]);
    free(job->scratch);
    free(job->drawn);
}

bool pen_audit_continue(struct pen_thread_pool *pool, const struct pen_audit_task *task,
                        struct pen_audit_progress *progress, struct pen_audit *audit,
                        struct pen_status *st)
{
    const size_t pixels = (size_t)task->settings->width * (size_t)task->settings->height;
    struct job job = {.task = task,
                      .sampling = sampling_of(task),
                      .lock = PTHREAD_MUTEX_INITIALIZER,
                      .first = progress->done,
                      .next = progress->done,
                      .wrong = progress->wrong,
                      .undecided = progress->undecided,
                      .cells = progress->cells};
    job.input = pen_kernel_input_of(task->scene, task->view, &job.sampling);
    job.kernel = pen_kernel_select(job.input.effects, pen_cpu_isa());
    job.threads = pen_render_threads(pool, task->settings);
    const bool ok = draw(&job, pixels, st) && make_scratch(&job, st);
    const uint64_t all = job.count;
    if (ok)
        pen_thread_pool_run(pool, job.threads, audit_pixels, &job);
    if (!ok || is_cancelled(&job)) {
        release(&job);
        return ok && pen_fail(st, PEN_CANCELLED, "the audit was cancelled");
    }
    progress->done = job.next;
    progress->left = all - job.next;
    progress->wrong = job.wrong;
    progress->undecided = job.undecided;
    *audit = (struct pen_audit){.pixels = job.count,
                                .wrong = job.wrong,
                                .undecided = job.undecided,
                                .threshold = task->threshold,
                                .seed = task->seed};
    pen_audit_find_clusters(job.cells, task->settings, job.drawn, audit);
    release(&job);
    const uint64_t not_right = audit->wrong + audit->undecided;
    audit->bound = job.count == pixels ? (double)not_right / (double)pixels
                                       : pen_audit_bound(not_right, job.count);
    return true;
}

bool pen_audit_run(struct pen_thread_pool *pool, const struct pen_audit_task *task,
                   struct pen_audit *audit, struct pen_status *st)
{
    struct pen_audit_progress progress = {0};
    return pen_audit_continue(pool, task, &progress, audit, st);
}

/* The logarithm of the probability of k or fewer of n, each with probability p. It is the
 * probability of k, times one plus the relative contributions of smaller numbers. */
static double log_at_most(double k, double n, double p)
{
    double log_k = n * pen_ln(1 - p), sum = 1, term = 1;
    for (double i = 0; i < k; i++)
        log_k += pen_ln((n - i) / (i + 1) * p / (1 - p));
    for (double i = k; i > 0 && term > sum * 1e-17; i--) {
        term *= i / (n - i + 1) * (1 - p) / p;
        sum += term;
    }
    return log_k + pen_ln(sum);
}

double pen_audit_bound(uint64_t wrong, uint64_t pixels)
{
    const double chance = 0.05, k = (double)wrong, n = (double)pixels;
    double low = 0, high = 1;
    if (wrong >= pixels)
        return 1;
    for (int i = 0; i < 60; i++) {
        const double middle = (low + high) / 2;
        if (log_at_most(k, n, middle) > pen_ln(chance))
            low = middle;
        else
            high = middle;
    }
    return high;
}
