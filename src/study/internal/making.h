/* SPDX-License-Identifier: MIT */
/* A study while it is made: its runs are counted, it may be cancelled and kept between them, and go
 * on in another process.
 *
 * What is kept is one document for every kind: {version, kind, host, pool_threads, elapsed_ms,
 * began_ms, breaks, done, the study's own members, rows: [{members, runs: [{members}]}]}. A kind
 * says by lists of members what its structs keep; this file alone writes and reads them. A document
 * may be of another build, or damaged: it is used as a whole or not at all. */
#ifndef PEN_STUDY_INTERNAL_MAKING_H
#define PEN_STUDY_INTERNAL_MAKING_H

#include <stddef.h>

#include "study/study.h"

/* A member of a struct. */
enum pen_kept_type {
    PEN_KEPT_SAME,   /* uint64_t, which must be the same in the study that goes on */
    PEN_KEPT_INT,    /* int, at least 0 */
    PEN_KEPT_BOOL,   /* bool */
    PEN_KEPT_NUMBER, /* double; null if it is not finite */
    PEN_KEPT_COUNT,  /* uint64_t, also a hash */
    PEN_KEPT_KERNEL, /* const char *, the name of a kernel */
    PEN_KEPT_LIST    /* json_t *, a list */
};
struct pen_kept_member {
    const char *name; /* NULL ends a list of members */
    enum pen_kept_type type;
    size_t offset;
};

/* The members of struct pen_ray_counts that begins at this place of a struct. */
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

/* What a kind keeps. Functions get making->study. */
struct pen_kept_shape {
    const char *kind;
    const struct pen_kept_member *study, *results; /* of making->study and making->results */
    const struct pen_kept_member *row, *run;
    void *(*row_at)(void *study, int row);
    void *(*run_at)(void *study, int row, int run);
    /* How many runs of a row are kept; -1: the row itself is not known yet. */
    int (*runs)(const void *study, int row);
    /* Takes the number of runs that a document has of a row. Returns whether it may be. */
    bool (*take_runs)(void *study, int row, int count);
    /* Whether the study's own members fit each other; and whether the rows fit them. May be NULL.
     */
    bool (*fits)(const void *study);
    bool (*rows_fit)(const void *study);
    /* The picture at a place; NULL: the kind keeps none. */
    struct pen_study_picture (*picture)(const void *study, int place);
};

struct pen_making {
    const struct pen_study_frame *frame;
    const struct pen_kept_shape *shape;
    void *study, *results;
    int rows, pictures, width, height; /* pictures: places */
    int done, total;                   /* runs */
    int breaks;                        /* how often a process has gone on where another had ended */
    int64_t begun_ns;                  /* as if all runs had been made by this process */
    int64_t began_ms;                  /* wall clock */
    json_t *host;                      /* of this process; null unless the study may be kept */
};

/* Begins to count time. Owns: end *making in any case. Fails: PEN_NO_MEMORY. */
bool pen_making_begin(struct pen_making *making, struct pen_status *st);
void pen_making_end(struct pen_making *making);

/* Takes over what an earlier process has kept, if it is of this study, host, build and number of
 * threads, and whole; else the study stays new. Then reports progress. Returns whether it goes on.
 */
bool pen_making_resume(struct pen_making *making);

/* The time since the study has begun. Units: ms. */
double pen_making_spent_ms(const struct pen_making *making);

/* Fails with PEN_CANCELLED if the study has been cancelled. */
bool pen_making_check(const struct pen_making *making, struct pen_status *st);

/* Counts a run, and reports progress. */
void pen_making_count(struct pen_making *making);

/* Lets the caller keep the study. Fails: PEN_UNAVAILABLE, if it is to end here. */
bool pen_making_between(struct pen_making *making, struct pen_status *st);

/* Both, for the end of a run. */
static inline bool pen_making_end_run(struct pen_making *making, struct pen_status *st)
{
    pen_making_count(making);
    return pen_making_between(making, st);
}

#endif
