/* SPDX-License-Identifier: MIT */
/* The states of jobs and batches: every transition, and the function that makes it. From this table
 * the driver builds triggers by which the database itself refuses any other change of state.
 *
 *     submit ──▶ QUEUED ──claim──▶ RUNNING ──commit──▶ SUCCEEDED ┐
 *                  │                  ├─fail, ended──▶ FAILED    ├──delete──▶ (gone)
 *                  └─────cancel───────┴──────cancel──▶ CANCELLED ┘
 *
 *     submit, commit ──▶ OPEN ──────────claim─────────▶ LEASED ──commit──▶ DONE
 *     (assemble)          ▲ └─cancel, fail,─▶ ENDED ◀─cancel, fail,┤
 *                         │   ended                        ended  │
 *                         └─────────release, expire, ended────────┘
 *
 * "ended" is pen_store_worker_ended, "expire" pen_store_expire_leases. A job fails by "ended" when
 * max_attempts crashes of workers in a row were charged to it, without a commit in between.
 *
 * A job is SUCCEEDED when all its batches are DONE. When it fails or is cancelled, its OPEN and
 * LEASED batches become ENDED in the same transaction, so that none can be claimed or committed
 * afterwards. Batches that are DONE stay, for the preview. */
#ifndef PEN_STORE_STATES_H
#define PEN_STORE_STATES_H

#include "store/store.h"

/* ARROW(from, to, function). */
#define PEN_JOB_ARROWS(ARROW)                                                                      \
    ARROW(PEN_JOB_QUEUED, PEN_JOB_RUNNING, "pen_store_claim")                                      \
    ARROW(PEN_JOB_QUEUED, PEN_JOB_CANCELLED, "pen_store_cancel")                                   \
    ARROW(PEN_JOB_RUNNING, PEN_JOB_SUCCEEDED, "pen_store_commit")                                  \
    ARROW(PEN_JOB_RUNNING, PEN_JOB_FAILED, "pen_store_fail")                                       \
    ARROW(PEN_JOB_RUNNING, PEN_JOB_FAILED, "pen_store_worker_ended")                               \
    ARROW(PEN_JOB_RUNNING, PEN_JOB_CANCELLED, "pen_store_cancel")

#define PEN_BATCH_ARROWS(ARROW)                                                                    \
    ARROW(PEN_BATCH_OPEN, PEN_BATCH_LEASED, "pen_store_claim")                                     \
    ARROW(PEN_BATCH_OPEN, PEN_BATCH_ENDED, "pen_store_cancel")                                     \
    ARROW(PEN_BATCH_OPEN, PEN_BATCH_ENDED, "pen_store_fail")                                       \
    ARROW(PEN_BATCH_OPEN, PEN_BATCH_ENDED, "pen_store_worker_ended")                               \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_DONE, "pen_store_commit")                                    \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_OPEN, "pen_store_release")                                   \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_OPEN, "pen_store_expire_leases")                             \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_OPEN, "pen_store_worker_ended")                              \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_ENDED, "pen_store_cancel")                                   \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_ENDED, "pen_store_fail")                                     \
    ARROW(PEN_BATCH_LEASED, PEN_BATCH_ENDED, "pen_store_worker_ended")

struct pen_arrow {
    int from, to;
    const char *function;
};

/* The tables as data; *count is the number of rows. */
const struct pen_arrow *pen_job_arrows(int *count);
const struct pen_arrow *pen_batch_arrows(int *count);

#endif
