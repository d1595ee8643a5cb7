/* SPDX-License-Identifier: MIT */
/* Determinism: each golden film, in each way of rendering that must not matter. A case is a way and
 * a film; the table of golden hashes has the right result. */
#include "accel/accel.h"
#include "property/films.h"
#include "property/rows.h"

static const struct films_variant threads[] = {
    {.threads = 1, .tile = 8}, {.threads = 2, .tile = 8},  {.threads = 3, .tile = 8},
    {.threads = 8, .tile = 8}, {.threads = 64, .tile = 4},
};

static const struct films_variant tiles[] = {
    {.threads = 2, .tile = 1},
    {.threads = 2, .tile = 7},
    {.threads = 2, .tile = 32},
    {.threads = 2},
    {.threads = 2, .tile = 13, .order = FILMS_SHUFFLED},
    {.threads = 3, .tile = 9, .cut = true},
};

static const struct films_variant accelerators[] = {
    {.threads = 2, .tile = 16, .accelerator = PEN_ACCEL_AUTO},
    {.threads = 2, .tile = 16, .accelerator = PEN_ACCEL_NONE},
    {.threads = 2, .tile = 16, .accelerator = PEN_ACCEL_CBR},
    {.threads = 2, .tile = 16, .accelerator = PEN_ACCEL_MANUAL},
    {.threads = 2, .tile = 16, .accelerator = PEN_ACCEL_MEDIAN},
};

static const struct films_variant sets[] = {
    {.threads = 2, .tile = 16, .isa = "avx512"},
    {.threads = 2, .tile = 16, .isa = "avx2"},
    {.threads = 2, .tile = 16, .isa = "base"},
    {.threads = 2, .tile = 16, .isa = "base", .accelerator = PEN_ACCEL_NONE},
    {.threads = 2, .tile = 16, .isa = "base", .accelerator = PEN_ACCEL_CBR},
    {.threads = 2, .tile = 16, .isa = "base", .accelerator = PEN_ACCEL_MANUAL},
    {.threads = 2, .tile = 16, .isa = "base", .accelerator = PEN_ACCEL_MEDIAN},
};

static const struct films_variant plain[] = {{.threads = 2, .tile = 16}};

/* Subnormal results flushed, subnormal operands taken for 0, rounding down, up and to zero. */
static const struct films_variant states[] = {
    {.threads = 2, .tile = 16, .strange = 0x8000}, {.threads = 2, .tile = 16, .strange = 0x0040},
    {.threads = 2, .tile = 16, .strange = 0x2000}, {.threads = 2, .tile = 16, .strange = 0x4000},
    {.threads = 2, .tile = 16, .strange = 0x6000},
};

/* The list that the row under way is about. */
static const struct films_variant *variant;
static size_t ways;

/* All ways of one film before the next; neighbours in the list of films are alike, so few cases
 * take films from all over it. */
static void draw(struct row_draw *d, struct row_case *c)
{
    enum { STRIDE = 101 }; /* a prime that no list of films has as a factor */
    uint64_t films = (uint64_t)films_count();
    if (films == 0 || d->index >= ways * films)
        return;
    row_fixed(c, (double)(d->index % ways));
    row_fixed(c, (double)((d->index / ways * STRIDE + 11) % films));
    row_fixed(c, (double)random_below(&d->random, 1u << 31)); /* orders tiles */
}

static void judge(const struct row_case *c, struct row_verdict *v)
{
    int at = 0;
    double which = row_next(c, &at), film = row_next(c, &at), seed = row_next(c, &at);
    char why[ROW_WHY] = "";
    if (!(which >= 0 && which < (double)ways && film >= 0 && film < films_count())) {
        row_skip(v);
        return;
    }
    struct films_variant chosen = variant[(size_t)which];
    chosen.seed = (uint64_t)seed;
    if (!films_match((int)film, &chosen, why, sizeof why))
        row_fail(v, "%s", why);
}

static void each(struct pen_row_run *run, const struct films_variant *list, size_t count)
{
    variant = list;
    ways = count;
    row_each(run, draw, judge);
}

#define COUNT(list) (sizeof list / sizeof list[0])

void rows_films_threads(struct pen_row_run *run)
{
    each(run, threads, COUNT(threads));
}

void rows_films_tiles(struct pen_row_run *run)
{
    each(run, tiles, COUNT(tiles));
}

void rows_films_accelerators(struct pen_row_run *run)
{
    each(run, accelerators, COUNT(accelerators));
}

void rows_films_sets(struct pen_row_run *run)
{
    each(run, sets, COUNT(sets));
}

void rows_films_plain(struct pen_row_run *run)
{
    each(run, plain, COUNT(plain));
}

void rows_films_states(struct pen_row_run *run)
{
    each(run, states, COUNT(states));
}
