/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/orphans.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "cmd/daemon/roles.h"

enum { NAME_BYTES = 160, NAMES_MAX = 32, PAGE = 100 };

/* Different workers. More than fit are left to time. */
struct names {
    int count;
    char list[NAMES_MAX][NAME_BYTES];
};

/* "PID (NAME) STATE …" of the kernel; the process is gone, or a zombie, or another program. */
static bool is_worker(int pid)
{
    char path[40], line[128], state = 'Z';
    snprintf(path, sizeof path, "/proc/%d/stat", pid);
    FILE *file = fopen(path, "re");
    if (!file)
        return false;
    bool found = fgets(line, sizeof line, file) != NULL;
    fclose(file);
    const char *end = found ? strstr(line, "(" PEN_WORKER_PROCESS ") ") : NULL;
    if (end)
        state = end[sizeof "(" PEN_WORKER_PROCESS ") " - 1];
    return state != 'Z' && state != 'X';
}

bool pen_worker_may_live(const char *name)
{
    char here[NAME_BYTES];
    pen_worker_name(0, 0, here, sizeof here);
    size_t host = (size_t)(strstr(here, ":0:0") - here);
    int pid, end = 0;
    if (strncmp(name, here, host) != 0 || sscanf(name + host, ":%d:%*d%n", &pid, &end) != 1 ||
        end == 0 || name[host + (size_t)end] != '\0')
        return true;
    return pid != getpid() && is_worker(pid);
}

static void note_name(struct names *names, const char *name)
{
    if (names->count == NAMES_MAX)
        return;
    for (int i = 0; i < names->count; i++) {
        if (strcmp(names->list[i], name) == 0)
            return;
    }
    snprintf(names->list[names->count++], NAME_BYTES, "%s", name);
}

static bool note_batch(void *user, const struct pen_batch_record *batch)
{
    if (batch->state == PEN_BATCH_LEASED && batch->worker)
        note_name(user, batch->worker);
    return true;
}

/* Only those who are dead count here: however long the list, there is room for some. */
static bool note_dead(void *user, const struct pen_worker_record *worker)
{
    if (!pen_worker_may_live(worker->name))
        note_name(user, worker->name);
    return true;
}

/* One page of running jobs, from the newest below *below on; *below becomes 0 after the last. */
static bool note_jobs(struct pen_store *store, int64_t *below, struct names *names,
                      struct pen_status *st)
{
    struct pen_job_filter filter = {.state = PEN_JOB_RUNNING, .below = *below, .limit = PAGE};
    struct pen_job_record *jobs;
    int count;
    if (!pen_store_jobs(store, &filter, &jobs, &count, st))
        return false;
    bool ok = true;
    for (int i = 0; ok && i < count; i++) {
        ok = pen_store_batches(store, jobs[i].id, note_batch, names, st);
        if (!ok && st->code == PEN_NOT_FOUND) /* it ended and was deleted meanwhile */
            ok = true;
    }
    *below = count == PAGE ? jobs[count - 1].number : 0;
    pen_job_records_free(jobs, count);
    return ok;
}

bool pen_orphans_sweep(struct pen_store *store, int *opened, struct pen_status *st)
{
    struct names *names = calloc(1, sizeof *names);
    int64_t below = 0;
    *opened = 0;
    if (!names)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    bool ok;
    do
        ok = note_jobs(store, &below, names, st);
    while (ok && below > 0);
    for (int i = 0; ok && i < names->count; i++) {
        int more = 0;
        if (pen_worker_may_live(names->list[i]))
            continue;
        ok = pen_store_expire_leases(store, names->list[i], &more, st);
        *opened += more;
    }
    free(names);
    return ok;
}

bool pen_orphans_forget(struct pen_store *store, struct pen_status *st)
{
    struct names *names = calloc(1, sizeof *names);
    if (!names)
        return pen_fail(st, PEN_NO_MEMORY, "out of memory");
    bool ok = pen_store_workers(store, note_dead, names, st);
    for (int i = 0; ok && i < names->count; i++)
        ok = pen_store_worker_gone(store, names->list[i], st);
    free(names);
    return ok;
}
