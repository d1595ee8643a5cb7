/* SPDX-License-Identifier: MIT */
/* The parts of a study in progress that all kinds share: counting runs, cancelling, saving and
 * resuming.
 *
 * The saved state is one document for every kind: {version, kind, host, pool_threads, elapsed_ms,
 * began_ms, breaks, done, the study's own members, rows: [{members, runs: [{members}]}]}. Each kind
 * lists the members of its structs that are saved. making.c alone writes and reads them. A document
 * may be damaged, or come from another build. It is used as a whole or not at all. */
#ifndef PEN_STUDY_INTERNAL_MAKING_H
#define PEN_STUDY_INTERNAL_MAKING_H

#include <stddef.h>

#include "study/study.h"

/* The type of a saved member of a struct. */
enum pen_kept_type {
    PEN_KEPT_SAME,   /* uint64_t that must be equal in the study that resumes */
    PEN_KEPT_INT,    /* int, at least 0 */
    PEN_KEPT_BOOL,   /* bool */
    PEN_KEPT_NUMBER, /* double; null if it is not finite */
    PEN_KEPT_COUNT,  /* uint64_t, a count or a hash */
    PEN_KEPT_KERNEL, /* const char *, the name of a kernel */
    PEN_KEPT_LIST    /* json_t *, a list */
};
struct pen_kept_member {
    const char *name; /* NULL ends a list of members */
    enum pen_kept_type type;
    size_t offset;
};

/* List entries for the members of a struct pen_ray_counts, which is a member of another struct. */
#define PEN_KEPT_RAYS(type, member)                                                                \
    {"primary", PEN_KEPT_COUNT, offsetof(type, member.primary)},                                   \
        {"shadow", PEN_KEPT_COUNT, offsetof(type, member.shadow)},                                 \
        {"reflection", PEN_KEPT_COUNT, offsetof(type, member.reflection)},                         \
        {"transmission", PEN_KEPT_COUNT, offsetof(type, member.transmission)},                     \
        {"dropped_samples", PEN_KEPT_COUNT, offsetof(type, member.dropped_samples)},               \
        {"unmatched_exits", PEN_KEPT_COUNT, offsetof(type, member.unmatched_exits)},               \
    {                                                                                              \
        "truncated_paths", PEN_KEPT_COUNT, offsetof(type, member.truncated_paths)                  \
    }

/* The parts of a kind of study that are saved. The functions get making->study. */
struct pen_kept_shape {
    const char *kind;
    const struct pen_kept_member *study, *results; /* of making->study and making->results */
    const struct pen_kept_member *row, *run;
    void *(*row_at)(void *study, int row);
    void *(*run_at)(void *study, int row, int run);
    /* The number of runs of a row that are saved. */
    int (*runs)(const void *study, int row);
    /* Sets the number of runs of a row, as read from a document. Returns false if this number is
     * impossible. */
    bool (*take_runs)(void *study, int row, int count);
    /* Checks that the study's own members are consistent, and that the rows are consistent with
     * them. May be NULL. */
    bool (*fits)(const void *study);
    bool (*rows_fit)(const void *study);
    /* The picture at a place. NULL: this kind saves no pictures. */
    struct pen_study_picture (*picture)(const void *study, int place);
};

/* A study in progress. */
struct pen_making {
    const struct pen_study_frame *frame;
    const struct pen_kept_shape *shape;
    void *study, *results;
    int rows, pictures, width, height; /* pictures: number of places */
    int done, total;                   /* runs */
    int breaks;                        /* how often another process resumed the study */
    int64_t begun_ns;                  /* start time, as if this process had made all runs */
    int64_t began_ms;                  /* start by the wall clock */
    json_t *host;                      /* host of this process; null if the study cannot be saved */
};

/* Starts the time of a study.
 * Owns: call pen_making_end, after success and after failure.
 * Fails: PEN_NO_MEMORY. */
bool pen_making_begin(struct pen_making *making, struct pen_status *st);
void pen_making_end(struct pen_making *making);

/* Loads the state that an earlier process saved. It must be complete, and its study, host, build
 * and number of threads must be the same. Otherwise the study starts from the beginning. Then
 * reports progress. Returns whether the study was resumed. */
bool pen_making_resume(struct pen_making *making);

/* The time since the study began, without the time between processes.
 * Units: ms. */
double pen_making_spent_ms(const struct pen_making *making);

/* Fails with PEN_CANCELLED if the study has been cancelled. */
bool pen_making_check(const struct pen_making *making, struct pen_status *st);

/* Counts a run, and reports progress. */
void pen_making_count(struct pen_making *making);

/* Calls frame->between, which may save the study.
 * Fails: PEN_UNAVAILABLE, if it returns false. */
bool pen_making_between(struct pen_making *making, struct pen_status *st);

/* Ends a run: counts it, and calls frame->between.
 * Fails: as pen_making_between. */
static inline bool pen_making_end_run(struct pen_making *making, struct pen_status *st)
{
    pen_making_count(making);
    return pen_making_between(making, st);
}

#endif
