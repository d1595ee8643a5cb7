/* SPDX-License-Identifier: MIT */
/* Drawing, judging, counting. */
#include "property/row.h"

#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

#include "property/corpus.h"
#include "property/shrink.h"

void row_arg(struct row_case *c, double x)
{
    if (c->count < ROW_ARGS)
        c->arg[c->count++] = x;
}

void row_arg3(struct row_case *c, vec3 v)
{
    row_arg(c, v.x);
    row_arg(c, v.y);
    row_arg(c, v.z);
}

void row_fixed(struct row_case *c, double x)
{
    row_arg(c, x);
    c->fixed = c->count;
}

double row_next(const struct row_case *c, int *at)
{
    return *at < c->count ? c->arg[(*at)++] : 0;
}

vec3 row_next3(const struct row_case *c, int *at)
{
    double x = row_next(c, at), y = row_next(c, at);
    return pen_vec3(x, y, row_next(c, at));
}

void row_fail(struct row_verdict *v, const char *format, ...)
{
    if (v->failed)
        return; /* the first reason is the one to read */
    v->failed = true;
    va_list args;
    va_start(args, format);
    vsnprintf(v->why, sizeof v->why, format, args);
    va_end(args);
}

bool row_require(struct row_verdict *v, bool holds, const char *what)
{
    if (!holds)
        row_fail(v, "%s", what);
    return holds;
}

void row_skip(struct row_verdict *v)
{
    v->skipped = true;
}

void row_measure(struct row_verdict *v, const char *series, double value, double bound)
{
    if (v->errors < ROW_ERRORS)
        v->error[v->errors++] = (struct row_error){series, value, bound};
    if (bound >= 0 && !(value <= bound))
        row_fail(v, "%s: %.4g, allowed %.4g", series, value, bound);
}

void row_tally(struct row_verdict *v, const char *name)
{
    if (v->tallies < ROW_ERRORS)
        v->tally[v->tallies++] = name;
}

/* The bin of a value: 0 below 2^-8, then quarter octaves. */
static int bin_of(double value)
{
    if (!(value > 0x1p-8))
        return 0;
    if (!(value < 0x1p32))
        return ROW_BINS - 1;
    return 1 + (int)floor(4 * (log2(value) + 8));
}

double row_bin_begin(int bin)
{
    return bin == 0 ? 0 : exp2((bin - 1) / 4.0 - 8);
}

double row_quantile(const struct row_series *s, double part)
{
    uint64_t below = 0;
    for (int i = 0; i < ROW_BINS; i++) {
        below += s->bin[i];
        if ((double)below >= part * (double)s->count)
            return row_bin_begin(i + 1) < s->max ? row_bin_begin(i + 1) : s->max;
    }
    return s->max;
}

static struct row_series *series_named(struct row_result *r, const char *name)
{
    for (int i = 0; i < r->series_count; i++)
        if (strcmp(r->series[i].name, name) == 0)
            return &r->series[i];
    if (r->series_count == ROW_SERIES)
        return NULL;
    struct row_series *s = &r->series[r->series_count++];
    snprintf(s->name, sizeof s->name, "%s", name);
    s->max = -1;
    s->bound = -1;
    return s;
}

static void add_tally(struct row_result *r, const char *name, uint64_t count)
{
    int i = 0;
    while (i < r->tally_count && strcmp(r->tally[i].name, name) != 0)
        i++;
    if (i == ROW_TALLIES)
        return;
    if (i == r->tally_count)
        snprintf(r->tally[r->tally_count++].name, ROW_NAME, "%s", name);
    r->tally[i].count += count;
}

static void add_error(struct row_result *r, const struct row_error *e, const struct row_case *c)
{
    struct row_series *s = series_named(r, e->series);
    if (!s)
        return;
    double value = e->value == e->value ? e->value : INFINITY;
    s->count++;
    s->bin[bin_of(value)]++;
    s->over += e->bound >= 0 && !(e->value <= e->bound);
    s->bound = e->bound > s->bound ? e->bound : s->bound;
    if (value > s->max) {
        s->max = value;
        s->worst = *c;
    }
}

void row_take(struct pen_row_run *run, uint64_t index, const struct row_case *c,
              const struct row_verdict *v)
{
    struct row_result *r = run->result;
    if (v->skipped) {
        r->skipped++;
        return;
    }
    r->tried++;
    for (int i = 0; i < v->errors; i++)
        add_error(r, &v->error[i], c);
    for (int i = 0; i < v->tallies; i++)
        add_tally(r, v->tally[i], 1);
    if (!v->failed)
        return;
    r->failures++;
    if (r->kept_count == ROW_KEPT)
        return;
    struct row_kept *kept = &r->kept[r->kept_count++];
    kept->as_drawn = kept->small = *c;
    kept->index = index;
    snprintf(kept->why, sizeof kept->why, "%s", v->why);
}

static void judge_one(struct pen_row_run *run, uint64_t index, const struct row_case *c,
                      row_judge_fn *judge)
{
    struct row_verdict v = {.failed = false};
    struct row_result *r = run->result;
    judge(c, &v);
    int kept = r->kept_count;
    row_take(run, index, c, &v);
    if (r->kept_count > kept)
        shrink_case(&r->kept[kept].small, judge, r->kept[kept].why);
}

static struct random random_of(const struct pen_row_run *run, uint64_t index)
{
    uint64_t h = 0xcbf29ce484222325u; /* FNV-1a of the name */
    for (const char *p = run->row->name; *p; p++)
        h = (h ^ (unsigned char)*p) * 0x100000001b3u;
    struct random r = {run->seed ^ h, run->seed};
    r.state = random_bits(&r) + index * 0xd1342543de82ef95u;
    r.state = random_bits(&r);
    return r;
}

/* G10: moves some arguments of a stored case by a few ulps, or all by a power of two. */
static void mutate(struct random *r, struct row_case *c)
{
    static const int step[] = {0, 0, 0, 1, -1, 2, -2, 64, -64};
    double scale = random_below(r, 4) ? 1 : exp2((int)random_below(r, 9) - 4);
    for (int i = c->fixed; i < c->count; i++)
        c->arg[i] = random_nudge(c->arg[i] * scale, step[random_below(r, 9)]);
}

static void replay(struct pen_row_run *run, row_judge_fn *judge)
{
    const struct row_case *old;
    for (int i = 0; (old = corpus_case(run->corpus, run->row->name, i)); i++) {
        judge_one(run, UINT64_MAX, old, judge);
        run->result->replayed++;
    }
    /* Each again, a little changed. */
    for (int k = 0; k < 16 && run->cases > 0; k++) {
        struct random r = random_of(run, UINT64_MAX - (uint64_t)k);
        for (int i = 0; (old = corpus_case(run->corpus, run->row->name, i)); i++) {
            struct row_case c = *old;
            mutate(&r, &c);
            judge_one(run, UINT64_MAX, &c, judge);
        }
    }
}

void row_each(struct pen_row_run *run, row_draw_fn *draw, row_judge_fn *judge)
{
    if (run->corpus)
        replay(run, judge);
    for (uint64_t i = run->first; i < run->first + run->cases; i++) {
        struct row_draw d = {random_of(run, i), i};
        struct row_case c = {.count = 0};
        draw(&d, &c);
        if (c.count > 0)
            judge_one(run, i, &c, judge);
        else
            run->result->skipped++;
    }
}

static double cpu_seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

void row_run(struct pen_row_run *run)
{
    double begun = cpu_seconds();
    run->row->run(run);
    run->result->cpu_s += cpu_seconds() - begun;
}

static void add_series(struct row_result *to, const struct row_series *from)
{
    struct row_series *s = series_named(to, from->name);
    if (!s)
        return;
    s->count += from->count;
    s->over += from->over;
    for (int i = 0; i < ROW_BINS; i++)
        s->bin[i] += from->bin[i];
    s->bound = from->bound > s->bound ? from->bound : s->bound;
    if (from->max > s->max) {
        s->max = from->max;
        s->worst = from->worst;
    }
}

void row_result_add(struct row_result *to, const struct row_result *from)
{
    to->tried += from->tried;
    to->skipped += from->skipped;
    to->failures += from->failures;
    to->replayed += from->replayed;
    to->crashed += from->crashed;
    to->cpu_s += from->cpu_s;
    for (int i = 0; i < from->series_count; i++)
        add_series(to, &from->series[i]);
    for (int i = 0; i < from->tally_count; i++)
        add_tally(to, from->tally[i].name, from->tally[i].count);
    for (int i = 0; i < from->kept_count && to->kept_count < ROW_KEPT; i++)
        to->kept[to->kept_count++] = from->kept[i];
}

int row_print(char *text, size_t size, const struct row_case *c)
{
    int length = 0;
    if (size > 0)
        text[0] = 0;
    for (int i = 0; i < c->count; i++) {
        size_t used = (size_t)length < size ? (size_t)length : size;
        length += snprintf(text + used, size - used, i < c->fixed ? "%s%.17g" : "%s%a",
                           i ? " " : "", c->arg[i]);
    }
    return length;
}
