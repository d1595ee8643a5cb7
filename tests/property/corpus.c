/* SPDX-License-Identifier: MIT */
#include "property/corpus.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static bool parse_line(char *text, struct corpus_line *line)
{
    char *rest, *word = strtok_r(text, " \n", &rest);
    *line = (struct corpus_line){.c = {.count = 0}};
    if (!word || strlen(word) >= sizeof line->name)
        return false;
    strcpy(line->name, word);
    while ((word = strtok_r(NULL, " \n", &rest))) {
        char *end;
        double x = strtod(word, &end);
        if (*end || line->c.count == ROW_ARGS)
            return false;
        if (strchr(word, 'x'))
            row_arg(&line->c, x);
        else
            row_fixed(&line->c, x);
    }
    return line->c.count > 0;
}

int corpus_read(struct corpus *corpus, const char *path)
{
    char text[4096];
    int number = 0, bad = 0;
    corpus->count = 0;
    FILE *f = fopen(path, "r");
    if (!f)
        return 0;
    while (!bad && fgets(text, sizeof text, f)) {
        number++;
        if (text[0] == '#' || text[0] == '\n')
            continue;
        if (corpus->count == CORPUS_MAX || !parse_line(text, &corpus->line[corpus->count++]))
            bad = number;
    }
    fclose(f);
    return bad;
}

const struct row_case *corpus_case(const struct corpus *corpus, const char *row, int i)
{
    for (int k = 0; k < corpus->count; k++)
        if (strcmp(corpus->line[k].name, row) == 0 && i-- == 0)
            return &corpus->line[k].c;
    return NULL;
}

static bool same_case(const struct row_case *a, const struct row_case *b)
{
    return a->count == b->count && memcmp(a->arg, b->arg, (size_t)a->count * sizeof a->arg[0]) == 0;
}

void corpus_drop(struct corpus *corpus, const char *row)
{
    int kept = 0;
    for (int i = 0; i < corpus->count; i++)
        if (strcmp(corpus->line[i].name, row) != 0)
            corpus->line[kept++] = corpus->line[i];
    corpus->count = kept;
}

void corpus_add(struct corpus *corpus, const char *row, const struct row_case *c)
{
    int count = 0;
    for (int i = 0; i < corpus->count; i++) {
        if (strcmp(corpus->line[i].name, row) != 0)
            continue;
        if (same_case(&corpus->line[i].c, c))
            return;
        count++;
    }
    if (count >= CORPUS_PER_ROW || corpus->count == CORPUS_MAX || c->count == 0)
        return;
    struct corpus_line *line = &corpus->line[corpus->count++];
    snprintf(line->name, sizeof line->name, "%s", row);
    line->c = *c;
}

static int by_text(const void *a, const void *b)
{
    return strcmp(*(char *const *)a, *(char *const *)b);
}

static char *line_text(const struct corpus_line *line)
{
    char args[4096];
    size_t size = sizeof args + ROW_NAME + 4;
    char *text = malloc(size);
    row_print(args, sizeof args, &line->c);
    if (text)
        snprintf(text, size, "%s %s\n", line->name, args);
    return text;
}

bool corpus_write(struct corpus *corpus, const char *path)
{
    static char *text[CORPUS_MAX];
    bool ok = true;
    for (int i = 0; i < corpus->count; i++)
        ok = (text[i] = line_text(&corpus->line[i])) && ok;
    if (!ok)
        return false;
    qsort(text, (size_t)corpus->count, sizeof text[0], by_text);
    FILE *f = fopen(path, "w");
    if (!f)
        return false;
    fputs("# Cases that `make check` replays: a row's name, then the arguments of one case.\n"
          "# `make stability` adds failing and worst cases; see tests/property/README.md.\n",
          f);
    for (int i = 0; i < corpus->count; i++) {
        fputs(text[i], f);
        free(text[i]);
    }
    return fclose(f) == 0;
}
