/* SPDX-License-Identifier: MIT */
/* Runs the rows of the table with the number of cases that they ask for, in parallel processes.
 * Writes report.md, report.json and index.html. Exit status: 0 if no row failed, 1 if one did, 2
 * for a wrong command line.
 *
 *   stability [--out DIR] [--corpus FILE] [--jobs N] [--seed N] [--cases N] [--rows PART]
 *             [--also FILE]... [--no-price]
 *   stability --replay NAME ARGUMENT...     judges one case, as reports print it
 *   stability --price-of N CALLS            for callgrind */
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "property/corpus.h"
#include "property/report.h"

enum { CHUNK = 250000, TASKS_MAX = 1024, JOBS_MAX = 64, ALSO_MAX = 4 };

struct options {
    const char *out, *corpus, *rows;
    const char *also[ALSO_MAX]; /* files of rows that others judged */
    uint64_t seed, cases;
    int jobs, also_count;
    bool price;
};

/* A range of the cases of a row. */
struct task {
    int row;
    uint64_t first, cases;
    enum { TASK_WAITS, TASK_RUNS, TASK_ENDED } state;
    pid_t pid; /* while it runs */
};

struct suite {
    struct options options;
    struct corpus corpus;
    struct task task[TASKS_MAX];
    struct row_result *result; /* by task; shared with the processes */
    struct report report;
    int tasks;
};

static bool parse_options(int argc, char **argv, struct options *o)
{
    for (int i = 1; i < argc; i++) {
        const char *key = argv[i], *value = i + 1 < argc ? argv[i + 1] : NULL;
        if (strcmp(key, "--no-price") == 0) {
            o->price = false;
            continue;
        }
        if (!value)
            return false;
        i++;
        if (strcmp(key, "--out") == 0)
            o->out = value;
        else if (strcmp(key, "--corpus") == 0)
            o->corpus = value;
        else if (strcmp(key, "--rows") == 0)
            o->rows = value;
        else if (strcmp(key, "--also") == 0 && o->also_count < ALSO_MAX)
            o->also[o->also_count++] = value;
        else if (strcmp(key, "--seed") == 0)
            o->seed = strtoull(value, NULL, 0);
        else if (strcmp(key, "--cases") == 0)
            o->cases = strtoull(value, NULL, 0);
        else if (strcmp(key, "--jobs") == 0)
            o->jobs = atoi(value);
        else
            return false;
    }
    o->jobs = o->jobs < 1 ? 1 : o->jobs > JOBS_MAX ? JOBS_MAX : o->jobs;
    return true;
}

static bool chosen(const struct options *o, const struct row *row)
{
    return row->status == ROW_TESTED && (!o->rows || strstr(row->name, o->rows));
}

static uint64_t full_cases(const struct row *row)
{
    return row->full ? row->full : 1000000;
}

/* Cuts the rows into tasks; rows that are asked for fewer cases than a chunk are one task. */
static void plan(struct suite *s)
{
    const struct row *row;
    for (int i = 0; i < ROWS_MAX && (row = row_at(i)); i++) {
        s->report.rows++;
        s->report.row[i] = (struct report_row){.row = row, .ran = chosen(&s->options, row)};
        if (!s->report.row[i].ran)
            continue;
        uint64_t full = full_cases(row), cases = full;
        if (s->options.cases && (s->options.cases < full || s->options.rows))
            cases = s->options.cases;
        for (uint64_t first = 0; first < cases && s->tasks < TASKS_MAX; first += CHUNK) {
            uint64_t left = cases - first;
            s->task[s->tasks++] =
                (struct task){i, first, left < CHUNK ? left : CHUNK, TASK_WAITS, 0};
        }
    }
}

static void begin(struct suite *s, int i)
{
    struct task *task = &s->task[i];
    fflush(stdout);
    task->state = TASK_RUNS;
    task->pid = fork();
    if (task->pid != 0)
        return;
    struct pen_row_run run = {row_at(task->row),
                              s->options.seed,
                              task->first,
                              task->cases,
                              task->first == 0 ? &s->corpus : NULL,
                              &s->result[i]};
    row_run(&run);
    fflush(stdout);
    _exit(0);
}

static int running(const struct suite *s, pid_t pid)
{
    for (int i = 0; i < s->tasks; i++)
        if (s->task[i].state == TASK_RUNS && s->task[i].pid == pid)
            return i;
    return -1;
}

/* Adds up what the tasks of a row found, in their order, once all have ended. */
static void collect(struct suite *s, int row)
{
    struct report_row *r = &s->report.row[row];
    for (int i = 0; i < s->tasks; i++)
        if (s->task[i].row == row && s->task[i].state != TASK_ENDED)
            return;
    for (int i = 0; i < s->tasks; i++)
        if (s->task[i].row == row)
            row_result_add(&r->result, &s->result[i]);
    printf("%-26s %9llu cases %8llu failures %7.1f s  %s\n", r->row->name,
           (unsigned long long)r->result.tried, (unsigned long long)r->result.failures,
           r->result.cpu_s, report_verdict(r));
}

static void end_one(struct suite *s)
{
    int status, i = -1;
    while (i < 0) {
        pid_t pid = wait(&status);
        if (pid < 0 && errno != EINTR)
            return;
        i = pid > 0 ? running(s, pid) : -1;
    }
    s->task[i].state = TASK_ENDED;
    s->result[i].crashed = status != 0;
    collect(s, s->task[i].row);
}

static void run_all(struct suite *s)
{
    int alive = 0;
    int64_t begun = pen_clock_ns();
    for (int i = 0; i < s->tasks; i++) {
        if (alive == s->options.jobs) {
            end_one(s);
            alive--;
        }
        begin(s, i);
        alive++;
    }
    for (; alive > 0; alive--)
        end_one(s);
    s->report.wall_s = (double)(pen_clock_ns() - begun) * 1e-9;
}

/* A row's lines: what failed, what was worst if `worst`, and older cases as far as there is
 * room. */
static void renew_lines(struct suite *s, const struct corpus *old, const struct report_row *row,
                        bool worst)
{
    const struct row_result *r = &row->result;
    const char *name = row->row->name;
    const struct row_case *c;
    corpus_drop(&s->corpus, name);
    for (int k = 0; k < r->kept_count; k++)
        corpus_add(&s->corpus, name, &r->kept[k].small);
    for (int k = 0; worst && k < r->series_count; k++)
        corpus_add(&s->corpus, name, &r->series[k].worst);
    for (int k = 0; (c = corpus_case(old, name, k)); k++)
        corpus_add(&s->corpus, name, c);
}

/* Only a row that ran in full says what is worst: it judged the cases of the corpus too, so what is
 * recorded gives way to nothing but what is worse. A shorter run records new failures alone. */
static void update_corpus(struct suite *s)
{
    static struct corpus old;
    bool renewed = false;
    old = s->corpus;
    for (int i = 0; i < s->report.rows; i++) {
        const struct report_row *row = &s->report.row[i];
        bool full = !s->options.cases || s->options.cases >= full_cases(row->row);
        if (!row->ran || !(full || (row->result.failures && !row->row->known)))
            continue;
        renew_lines(s, &old, row, full);
        renewed = true;
    }
    if (renewed && s->options.corpus && !corpus_write(&s->corpus, s->options.corpus))
        fprintf(stderr, "stability: cannot write %s\n", s->options.corpus);
}

typedef void write_fn(const struct report *report, FILE *f);

static bool write_one(const struct suite *s, const char *name, write_fn *write)
{
    char path[1024];
    snprintf(path, sizeof path, "%s/%s", s->options.out, name);
    FILE *f = fopen(path, "w");
    if (!f) {
        fprintf(stderr, "stability: cannot write %s\n", path);
        return false;
    }
    write(&s->report, f);
    return fclose(f) == 0;
}

static bool write_reports(const struct suite *s)
{
    mkdir(s->options.out, 0777);
    return write_one(s, "report.md", report_markdown) && write_one(s, "report.json", report_json) &&
           write_one(s, "index.html", report_html);
}

static int price_of(char **argv)
{
    return price_run(atoi(argv[2]), atol(argv[3])) ? 0 : 2;
}

/* Judges the one case that the arguments say. */
static int replay(int argc, char **argv)
{
    static struct corpus one;
    static struct row_result result;
    struct row_case c = {.count = 0};
    for (int i = 3; i < argc; i++)
        (strchr(argv[i], 'x') ? row_arg : row_fixed)(&c, strtod(argv[i], NULL));
    c.fixed = c.count; /* as it is */
    corpus_add(&one, argv[2], &c);
    const struct row *row;
    for (int i = 0; (row = row_at(i)); i++) {
        struct pen_row_run run = {row, 1, 0, 0, &one, &result};
        if (strcmp(row->name, argv[2]) != 0 || row->status != ROW_TESTED)
            continue;
        row_run(&run);
        for (int k = 0; k < result.series_count; k++)
            printf("%s: %.6g\n", result.series[k].name, result.series[k].max);
        printf("%s\n", result.failures ? result.kept[0].why : result.tried ? "holds" : "skipped");
        return result.failures != 0;
    }
    fprintf(stderr, "stability: no row is called %s\n", argv[2]);
    return 2;
}

static bool add_others(struct suite *s)
{
    for (int i = 0; i < s->options.also_count; i++) {
        if (report_also(&s->report, s->options.also[i]))
            continue;
        fprintf(stderr, "stability: %s is not a file of rows\n", s->options.also[i]);
        return false;
    }
    return true;
}

static int run_suite(struct suite *s, const char *program)
{
    int bad = s->options.corpus ? corpus_read(&s->corpus, s->options.corpus) : 0;
    if (bad) {
        fprintf(stderr, "stability: %s:%d: not a case\n", s->options.corpus, bad);
        return 2;
    }
    plan(s);
    if (s->tasks == 0) {
        fprintf(stderr, "stability: no row is called %s\n", s->options.rows);
        return 2;
    }
    size_t bytes = sizeof *s->result * (size_t)s->tasks;
    s->result = mmap(NULL, bytes, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    if (s->result == MAP_FAILED) {
        fprintf(stderr, "stability: out of memory\n");
        return 2;
    }
    printf("seed %llu\n", (unsigned long long)s->options.seed);
    run_all(s);
    if (s->options.price) {
        s->report.prices = price_measure(s->report.price);
        price_count(program, s->report.price, s->report.prices);
    }
    update_corpus(s);
    if (!add_others(s) || !write_reports(s))
        return 2;
    struct report_sums sums = report_sum(&s->report);
    printf("%d rows, %d failed, %d pending, %d do not apply; %llu cases, %llu failures; %.0f s of "
           "processor time, %.0f s; %s/index.html\n",
           sums.tested, sums.failed, sums.pending, sums.inapplicable,
           (unsigned long long)sums.tried, (unsigned long long)sums.failures, sums.cpu_s,
           s->report.wall_s, s->options.out);
    return sums.failed > 0;
}

int main(int argc, char **argv)
{
    static struct suite suite;
    static struct report_row rows[ROWS_MAX];
    suite.options = (struct options){.out = "build/stability", .seed = 1, .jobs = 1, .price = true};
    suite.report.row = rows;
    if (argc == 4 && strcmp(argv[1], "--price-of") == 0)
        return price_of(argv);
    if (argc > 3 && strcmp(argv[1], "--replay") == 0)
        return replay(argc, argv);
    if (!parse_options(argc, argv, &suite.options)) {
        fprintf(stderr, "stability: wrong command line; see the head of stability.c\n");
        return 2;
    }
    suite.report.seed = suite.options.seed;
    suite.report.jobs = suite.options.jobs;
    return run_suite(&suite, argv[0]);
}
