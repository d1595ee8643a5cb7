/* SPDX-License-Identifier: MIT */
/* The tables of states.h as data, and the names that states have in the API. */
#include "store/states.h"

#include <string.h>

#define ROW(from_state, to_state, name) {.from = from_state, .to = to_state, .function = name},

static const struct pen_arrow job_arrows[] = {PEN_JOB_ARROWS(ROW)};
static const struct pen_arrow batch_arrows[] = {PEN_BATCH_ARROWS(ROW)};

static const char *const job_names[PEN_JOB_STATE_COUNT] = {
    [PEN_JOB_QUEUED] = "queued",       [PEN_JOB_RUNNING] = "running",
    [PEN_JOB_SUCCEEDED] = "succeeded", [PEN_JOB_FAILED] = "failed",
    [PEN_JOB_CANCELLED] = "cancelled",
};

const struct pen_arrow *pen_job_arrows(int *count)
{
    *count = (int)(sizeof job_arrows / sizeof job_arrows[0]);
    return job_arrows;
}

const struct pen_arrow *pen_batch_arrows(int *count)
{
    *count = (int)(sizeof batch_arrows / sizeof batch_arrows[0]);
    return batch_arrows;
}

const char *pen_job_state_name(enum pen_job_state state)
{
    return (unsigned)state < PEN_JOB_STATE_COUNT ? job_names[state] : "unknown";
}

bool pen_job_state_of_name(const char *name, enum pen_job_state *state)
{
    for (int i = 0; i < PEN_JOB_STATE_COUNT; i++) {
        if (strcmp(job_names[i], name) == 0) {
            *state = (enum pen_job_state)i;
            return true;
        }
    }
    return false;
}
