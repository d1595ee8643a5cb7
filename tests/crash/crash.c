/* SPDX-License-Identifier: MIT */
/* The crash test: crash BUILD ROUNDS [SEED].
 *
 * In each round one thread submits jobs. Another thread kills processes of the daemon, stops a
 * worker for longer than its lease, drains the daemon, and cancels jobs. When all jobs have ended
 * undisturbed, the round checks:
 *
 *   acknowledged ⊆ stored     each acknowledged job is stored once
 *   no job fails by a kill    each job has succeeded, or was cancelled by this test
 *   the same bytes            pictures and ray counts are those of an undisturbed run
 *   nothing is left over      no rows contradict each other; no process outlives its supervisor
 *
 * Jobs come from three addresses, each with its own share of the work. Only the jobs that ended
 * last are kept, so jobs of earlier rounds are removed while processes are killed. Each of them is
 * stored, or is removed and has left its statistics. Retention keeps a job for a minute after its
 * end, so the test makes the jobs of a checked round older than that. */
#include <inttypes.h>
#include <pthread.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "client.h"
#include "daemon.h"
#include "database.h"
#include "jobs/jobs.h"
#include "kinds.h"
#include "support/store_rows.h"

enum { LEASE_MS = 600, KEEP_MS = 20, ROUND_JOBS = 6, KEY_BYTES = 48 };
enum { JOBS_END_MS = 120000, ACKNOWLEDGE_MS = 60000 };
enum { HOUSEKEEPING_MS = 50, CLIENTS = 3, EARLIER_JOBS = 64 };
_Static_assert((int)ROUND_JOBS < (int)DAEMON_KEEP_JOBS, "a round's own jobs may be removed");

struct job {
    int kind, priority, client;
    char id[PEN_ID_BYTES], key[KEY_BYTES]; /* id "": never acknowledged; key "": without */
    bool cancelled;                        /* a cancel of it was sent; its answer may be lost */
};

enum disturbance {
    KILL_SUPERVISOR,
    KILL_API,
    KILL_WORKER,
    STOP_WORKER,
    DRAIN,
    CANCEL,
    DATABASE, /* of PostgreSQL alone */
    DISTURBANCES
};

struct test {
    struct daemon daemon;
    struct pen_jobs *jobs;
    struct outcome wanted[KINDS];
    uint64_t random; /* of the main thread */
    int round;
    int done[DISTURBANCES], faults[DATABASE_FAULTS];
    int child_kills; /* since the supervisor's start: its pauses grow with each */
    int submitted, acknowledged, succeeded, cancelled, extra_killed, repeats;
    atomic_int checks, failures; /* of both threads */
    pthread_mutex_t lock;
    struct job job[ROUND_JOBS]; /* guarded by lock */
    int job_count;              /* guarded by lock */
    struct earlier {
        char id[PEN_ID_BYTES];
        bool succeeded;
    } earlier[EARLIER_JOBS]; /* jobs of earlier rounds that may be stored still */
    int earlier_count, removed;
    uint64_t submit_random; /* of the submitting thread */
};

static unsigned draw(uint64_t *state, unsigned below)
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (unsigned)((*state >> 33) % below);
}

static void check(struct test *t, bool ok, const char *what, const char *about)
{
    t->checks++;
    if (ok)
        return;
    t->failures++;
    printf("not ok: round %d: %s: %s\n", t->round, what, about);
    daemon_show_log(&t->daemon);
}

/* Submits one job; with a key, again until it is acknowledged. Returns whether it was. */
static bool submit(struct test *t, struct job *job)
{
    char body[4096], from[24];
    struct answer answer;
    snprintf(from, sizeof from, "10.0.0.%d", job->client + 1);
    kind_body(job->kind, job->priority, body, sizeof body);
    const int64_t until_ns = pen_clock_ns() + (int64_t)ACKNOWLEDGE_MS * daemon_patience() * 1000000;
    do {
        int port = atomic_load(&t->daemon.port);
        client_call(port, "POST", "/v1/jobs", job->key[0] ? job->key : NULL, from, body, &answer);
        if (answer.status == 202)
            return sscanf(answer.body, "{\"id\":\"%36[^\"]", job->id) == 1;
        pause_ms(50);
    } while (job->key[0] && pen_clock_ns() < until_ns);
    return false;
}

static void *submit_round(void *user)
{
    struct test *t = user;
    for (int i = 0; i < ROUND_JOBS; i++) {
        struct job job = {.kind = (int)draw(&t->submit_random, KINDS)};
        job.priority = (int)draw(&t->submit_random, 11) - 5;
        job.client = (int)draw(&t->submit_random, CLIENTS);
        if (draw(&t->submit_random, 3) > 0)
            snprintf(job.key, sizeof job.key, "%d-%d-%u", t->round, i,
                     draw(&t->submit_random, 1u << 30));
        bool acknowledged = submit(t, &job);
        pthread_mutex_lock(&t->lock);
        t->job[t->job_count++] = job;
        pthread_mutex_unlock(&t->lock);
        t->submitted++;
        t->acknowledged += acknowledged;
        check(t, acknowledged || !job.key[0], "a submit with a key is acknowledged at last",
              job.key);
        pause_ms((int)draw(&t->submit_random, 100));
    }
    return NULL;
}

static void start(struct test *t)
{
    t->child_kills = 0;
    if (t->daemon.pid == 0)
        check(t, daemon_start(&t->daemon), "the daemon starts", t->daemon.store);
}

static void kill_child(struct test *t, const char *role, enum disturbance disturbance)
{
    pid_t pid = daemon_child(&t->daemon, role);
    if (pid == 0)
        return;
    kill(pid, SIGKILL);
    t->done[disturbance]++;
    t->child_kills++;
}

/* Stops the worker for longer than its lease, while another one takes its work. */
static void stop_worker(struct test *t)
{
    pid_t pid = daemon_child(&t->daemon, "work");
    struct daemon extra;
    if (pid == 0)
        return;
    kill(pid, SIGSTOP);
    extra = daemon_extra_worker(&t->daemon);
    pause_ms(2 * LEASE_MS + (int)draw(&t->random, 600));
    kill(pid, SIGCONT);
    t->done[STOP_WORKER]++;
    pause_ms((int)draw(&t->random, 300));
    if (draw(&t->random, 2)) {
        const pid_t worker = daemon_child(&extra, "work");
        if (worker != 0 && draw(&t->random, 2)) /* else it gives its batch back */
            kill(worker, SIGKILL);
        check(t, daemon_kill(&extra), "a worker whose supervisor is killed ends", "");
        t->extra_killed++;
    } else {
        daemon_wait_for_worker(extra.pid);
        check(t, daemon_drain(&extra), "a daemon that only renders ends with exit code 0", "");
    }
}

static void cancel_some(struct test *t)
{
    char path[80];
    struct answer answer;
    pthread_mutex_lock(&t->lock);
    int i = t->job_count ? (int)draw(&t->random, (unsigned)t->job_count) : -1;
    if (i >= 0)
        snprintf(path, sizeof path, "/v1/jobs/%s/cancel", t->job[i].id);
    bool known = i >= 0 && t->job[i].id[0];
    if (known)
        t->job[i].cancelled = true;
    pthread_mutex_unlock(&t->lock);
    if (!known || client_call(t->daemon.port, "POST", path, NULL, NULL, NULL, &answer) != 202)
        return;
    t->done[CANCEL]++;
}

/* The test's own connection is lost, too. */
static void disturb_database(struct test *t)
{
    const enum database_fault fault = (enum database_fault)draw(&t->random, DATABASE_FAULTS);
    struct pen_status st;
    int64_t now_ms;
    database_disturb(fault, t->daemon.pid);
    t->faults[fault]++;
    for (int i = 0; i < 100 && !pen_store_now(pen_jobs_store(t->jobs), &now_ms, &st); i++)
        pause_ms(50);
}

static void disturb(struct test *t)
{
    pause_ms((int)draw(&t->random, 200));
    enum disturbance disturbance = (enum disturbance)draw(&t->random, DATABASE);
    if (database_url() && draw(&t->random, 2))
        disturbance = DATABASE;
    if (t->child_kills >= 3)
        disturbance = draw(&t->random, 2) ? KILL_SUPERVISOR : DRAIN;
    switch (disturbance) {
    case KILL_SUPERVISOR:
        check(t, daemon_kill(&t->daemon), "children of a killed supervisor end", "");
        t->done[disturbance]++;
        break;
    case KILL_API:
        kill_child(t, "api", disturbance);
        break;
    case KILL_WORKER:
        kill_child(t, "work", disturbance);
        break;
    case STOP_WORKER:
        if (draw(&t->random, 3) == 0) /* seldom: it takes long */
            stop_worker(t);
        break;
    case DRAIN:
        check(t, daemon_drain(&t->daemon), "a drained daemon ends in its time, with exit code 0",
              "");
        t->done[disturbance]++;
        break;
    case CANCEL:
        cancel_some(t);
        break;
    case DATABASE:
        disturb_database(t);
        t->done[disturbance]++;
        break;
    case DISTURBANCES:
        break;
    }
    if (t->daemon.pid == 0)
        start(t);
}

/* Waits until no job is queued or running. Returns false if that takes too long. */
static bool wait_for_all(struct test *t)
{
    struct pen_store *store = pen_jobs_store(t->jobs);
    struct pen_status st;
    int64_t until_ns = pen_clock_ns() + (int64_t)JOBS_END_MS * daemon_patience() * 1000000;
    for (int state = PEN_JOB_QUEUED; state <= PEN_JOB_RUNNING;) {
        struct pen_job_filter filter = {.state = state, .limit = 1};
        struct pen_job_record *jobs;
        int count;
        must(pen_store_jobs(store, &filter, &jobs, &count, &st), &st, "list");
        pen_job_records_free(jobs, count);
        if (count == 0)
            state++;
        else if (pen_clock_ns() > until_ns)
            return false;
        else
            pause_ms(20);
    }
    return true;
}

static void compare(struct test *t, const char *id, int kind)
{
    struct outcome got = outcome_of(t->jobs, id, kind);
    check(t, outcome_same_pixels(&got, &t->wanted[kind]), "the pictures have the same bytes", id);
    check(t, json_equal(got.rays, t->wanted[kind].rays), "the ray counts are the same", id);
    outcome_release(&got);
}

/* Checks one stored job. job: what was submitted; NULL if its acknowledgement was lost. */
static void check_job(struct test *t, const struct pen_job_record *record, const struct job *job)
{
    json_t *request = json_loads(record->request, 0, NULL);
    int kind = kind_of(json_string_value(json_object_get(request, "name")));
    json_decref(request);
    check(t, kind >= 0 && (!job || job->kind == kind), "a job is what was submitted", record->id);
    if (record->state == PEN_JOB_SUCCEEDED) {
        t->succeeded++;
        compare(t, record->id, kind);
    } else {
        t->cancelled++;
        check(t, record->state == PEN_JOB_CANCELLED && job && job->cancelled,
              "no job fails by a kill", record->error ? record->error : record->id);
    }
}

static const struct job *find_job(const struct test *t, const char *id)
{
    for (int i = 0; i < t->job_count; i++) {
        if (strcmp(t->job[i].id, id) == 0)
            return &t->job[i];
    }
    return NULL;
}

/* Checks that a submit repeated with its key gives the same job, also after a restart. */
static void repeat_keys(struct test *t)
{
    for (int i = 0; i < t->job_count; i++) {
        struct job again = t->job[i];
        if (!again.key[0] || !again.id[0])
            continue;
        again.id[0] = '\0';
        check(t, submit(t, &again) && strcmp(again.id, t->job[i].id) == 0,
              "a repeated submit gives the same job", again.key);
        t->repeats++;
    }
}

/* Remembers an ended job of this round for check_earlier. */
static void remember(struct test *t, const struct pen_job_record *record)
{
    if (t->earlier_count == EARLIER_JOBS)
        t->earlier[0] = t->earlier[--t->earlier_count];
    struct earlier *job = &t->earlier[t->earlier_count++];
    snprintf(job->id, sizeof job->id, "%s", record->id);
    job->succeeded = record->state == PEN_JOB_SUCCEEDED;
}

/* A removed job has left its statistics. Forgets it. */
static void check_removed(struct test *t, int i)
{
    struct pen_buf stats;
    struct pen_status st;
    const struct earlier job = t->earlier[i];
    pen_buf_init(&stats);
    bool left = pen_store_removed_stats(pen_jobs_store(t->jobs), job.id, &stats, &st);
    check(t, left || (!job.succeeded && st.code == PEN_GONE),
          "a removed job has left its statistics", job.id);
    pen_buf_release(&stats);
    t->earlier[i] = t->earlier[--t->earlier_count];
    t->removed++;
}

/* Makes all ended jobs a minute and more older. */
static void age_jobs(const struct test *t)
{
    store_change(t->daemon.store,
                 "UPDATE job SET finished_ms = finished_ms - 70000 WHERE state > 1", NULL, 0);
}

static void check_earlier(struct test *t)
{
    for (int i = t->earlier_count - 1; i >= 0; i--) {
        struct pen_job_record record;
        struct pen_status st;
        bool stored = pen_store_job(pen_jobs_store(t->jobs), t->earlier[i].id, &record, &st);
        check(t, stored || st.code == PEN_GONE, "an earlier job is stored or was removed",
              t->earlier[i].id);
        if (stored)
            pen_job_record_release(&record);
        else
            check_removed(t, i);
    }
}

/* Checks the jobs in the store that are this round's, and what became of those before. */
static void check_round(struct test *t, int64_t begun_ms)
{
    struct pen_store *store = pen_jobs_store(t->jobs);
    struct pen_status st;
    struct pen_job_filter filter = {.state = -1, .limit = 500};
    struct pen_job_record *records;
    int count, found_jobs = 0, created = 0;
    check(t, wait_for_all(t), "all jobs end", "");
    repeat_keys(t);
    check(t, store_contradictions(t->daemon.store) == 0, "no rows contradict each other", "");
    must(pen_store_jobs(store, &filter, &records, &count, &st), &st, "list");
    for (int i = 0; i < count; i++) {
        const struct job *job = find_job(t, records[i].id);
        if (records[i].created_ms < begun_ms)
            continue;
        created++;
        found_jobs += job != NULL;
        check_job(t, &records[i], job);
    }
    check_earlier(t);
    for (int i = 0; i < count; i++) {
        if (records[i].created_ms >= begun_ms)
            remember(t, &records[i]);
    }
    age_jobs(t);
    pen_job_records_free(records, count);
    int acknowledged = 0;
    for (int i = 0; i < t->job_count; i++)
        acknowledged += t->job[i].id[0] != '\0';
    check(t, found_jobs == acknowledged, "every acknowledged job is stored", "");
    check(t, created <= t->job_count, "no job is stored twice", "");
    check(t, store_contradictions(t->daemon.store) == 0, "no rows contradict each other", "");
}

static void run_round(struct test *t)
{
    pthread_t thread;
    t->job_count = 0;
    const int64_t begun_ms = pen_clock_wall_ms();
    pthread_create(&thread, NULL, submit_round, t);
    for (int n = 3 + (int)draw(&t->random, 4); n > 0; n--)
        disturb(t);
    pthread_join(thread, NULL);
    check_round(t, begun_ms);
}

static void run_undisturbed(struct test *t)
{
    for (int k = 0; k < KINDS; k++) {
        struct job job = {.kind = k};
        struct pen_status st;
        snprintf(job.key, sizeof job.key, "undisturbed-%d", k);
        check(t, submit(t, &job) && wait_for_all(t), "an undisturbed job succeeds", kind_name(k));
        t->wanted[k] = outcome_of(t->jobs, job.id, k);
        must(pen_store_delete(pen_jobs_store(t->jobs), job.id, NULL, NULL, &st), &st, "delete");
    }
}

/* The number of lines of the log that contain a text. */
static int count_log(const struct test *t, const char *what)
{
    char line[4096];
    int count = 0;
    FILE *log = fopen(t->daemon.log, "re");
    while (log && fgets(line, sizeof line, log))
        count += strstr(line, what) != NULL;
    if (log)
        fclose(log);
    return count;
}

/* Prints how often the disturbances had an effect: without any, the test would prove nothing. */
static void print_effects(const struct test *t)
{
    printf("leases of dead workers released %d times, leases run out %d times; results refused "
           "as stale %d times; rounds went on from what was kept %d times\n",
           count_log(t, "released"), count_log(t, "their leases ran out"),
           count_log(t, "no longer held"), count_log(t, "goes on after"));
}

static int report(const struct test *t, int rounds, int64_t begin_ns)
{
    int kills =
        t->done[KILL_SUPERVISOR] + t->done[KILL_API] + t->done[KILL_WORKER] + t->extra_killed;
    printf("%d rounds in %.0f s: %d kills (%d supervisor, %d api, %d worker, %d extra worker), %d "
           "workers stopped past their lease, %d drains, %d cancels\n",
           rounds, (double)(pen_clock_ns() - begin_ns) * 1e-9, kills, t->done[KILL_SUPERVISOR],
           t->done[KILL_API], t->done[KILL_WORKER], t->extra_killed, t->done[STOP_WORKER],
           t->done[DRAIN], t->done[CANCEL]);
    for (int i = 0; database_url() && i < DATABASE_FAULTS; i++)
        printf("%d %s%s", t->faults[i], database_fault_name((enum database_fault)i),
               i + 1 < DATABASE_FAULTS ? ", " : "\n");
    printf("%d jobs submitted, %d acknowledged; of the stored ones %d succeeded, %d "
           "cancelled; %d submits repeated; %d jobs removed since newer ones had ended\n",
           t->submitted, t->acknowledged, t->succeeded, t->cancelled, t->repeats, t->removed);
    printf("%d%%: Checks: %d, Failures: %d, Errors: 0\n",
           100 * (t->checks - t->failures) / t->checks, t->checks, t->failures);
    return t->failures ? 1 : 0;
}

static void set_up(struct test *t, const char *build, char folder[])
{
    static char program[4096], store[128], log[128];
    char lease[16], keep[16], housekeeping[16];
    struct pen_limits limits = pen_limits_default();
    struct pen_status st;
    if (!mkdtemp(folder)) {
        perror(folder);
        exit(2);
    }
    snprintf(program, sizeof program, "%s/penumbrad", build);
    if (database_url())
        snprintf(store, sizeof store, "%s", database_url());
    else
        snprintf(store, sizeof store, "%s/penumbra.db", folder);
    snprintf(log, sizeof log, "%s/log", folder);
    snprintf(lease, sizeof lease, "%d", LEASE_MS);
    snprintf(keep, sizeof keep, "%d", KEEP_MS);
    snprintf(housekeeping, sizeof housekeeping, "%d", HOUSEKEEPING_MS);
    setenv("PENUMBRA_HOUSEKEEPING_MS", housekeeping, 1);
    setenv("PENUMBRA_LEASE_MS", lease, 1);
    setenv("PENUMBRA_KEEP_MS", keep, 1);
    t->daemon = (struct daemon){.program = program, .store = store, .log = log};
    prctl(PR_SET_CHILD_SUBREAPER, 1); /* adopts the children of a killed supervisor */
    start(t);
    t->jobs = pen_jobs_open(store, &limits, &st);
    must(t->jobs != NULL, &st, store);
    if (database_url())
        database_break_commits();
}

/* Removes the folder, unless a check has failed. */
static void tear_down(struct test *t, const char *folder)
{
    check(t, daemon_drain(&t->daemon), "the last drain", "");
    check(t, t->removed > 0, "jobs were removed while processes were killed", "");
    check(t, daemon_processes(&t->daemon) == 0, "no process of the daemon is left over", "");
    check(t, count_log(t, "Sanitizer") + count_log(t, "runtime error:") == 0,
          "no sanitizer reports an error", t->daemon.log);
    print_effects(t);
    pen_jobs_close(t->jobs);
    for (int k = 0; k < KINDS; k++)
        outcome_release(&t->wanted[k]);
    char command[300];
    if (t->failures)
        printf("see %s\n", folder);
    snprintf(command, sizeof command, "rm -rf %s", folder);
    if (!t->failures && system(command) != 0)
        printf("cannot remove %s\n", folder);
}

int main(int argc, char **argv)
{
    static struct test test = {.lock = PTHREAD_MUTEX_INITIALIZER};
    struct test *t = &test;
    char folder[] = "/tmp/penumbra-crash-XXXXXX";
    if (argc < 3) {
        fprintf(stderr, "usage: crash BUILD ROUNDS [SEED]\n");
        return 2;
    }
    int rounds = atoi(argv[2]);
    uint64_t seed = argc > 3 ? strtoull(argv[3], NULL, 10) : (uint64_t)pen_clock_wall_ms();
    printf("seed %" PRIu64 "\n", seed);
    fflush(stdout);
    t->random = seed;
    t->submit_random = seed ^ 0x9e3779b97f4a7c15u;
    int64_t begin_ns = pen_clock_ns();
    set_up(t, argv[1], folder);
    run_undisturbed(t);
    for (t->round = 1; t->round <= rounds; t->round++)
        run_round(t);
    tear_down(t, folder);
    return report(t, rounds, begin_ns);
}
