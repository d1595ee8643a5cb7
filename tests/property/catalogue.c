/* SPDX-License-Identifier: MIT */
/* The catalogue in the three reports: a line per case. */
#include "property/catalogue.h"

#include <stdlib.h>
#include <string.h>

bool catalogue_has(const struct row *row, int number)
{
    for (const char *id = row->id; (id = strchr(id, 'H')); id++)
        if (strtol(id + 1, NULL, 10) == number)
            return true;
    return false;
}

const char *catalogue_status(const struct catalogue_case *c)
{
    return c->status == ROW_TESTED    ? "tested"
           : c->status == ROW_PENDING ? "pending"
                                      : "does not apply";
}

/* How one of the three writes names of tests, and what stands between them. */
struct style {
    const char *before, *after, *between, *known;
};

static void put_name(FILE *f, const struct style *style, const char *name, int length, int *count)
{
    fprintf(f, "%s%s%.*s%s", (*count)++ ? style->between : "", style->before, length, name,
            style->after);
}

/* All tests of a case: rows, then others. */
static void put_tests(FILE *f, int number, const struct style *style)
{
    const struct row *row;
    int count = 0;
    for (int i = 0; (row = row_at(i)); i++)
        if (row->status == ROW_TESTED && catalogue_has(row, number)) {
            put_name(f, style, row->name, (int)strlen(row->name), &count);
            fputs(row->known ? style->known : "", f);
        }
    for (const char *name = catalogue_case(number)->tests; *name;) {
        int length = (int)strcspn(name, " ");
        put_name(f, style, name, length, &count);
        name += length + (name[length] == ' ');
    }
}

void catalogue_markdown(FILE *f)
{
    fputs("\n## The catalogue\n\nRows of this suite and tests of `make check`.\n\n"
          "| id | case | status | tests |\n|---|---|---|---|\n",
          f);
    for (int i = CATALOGUE_FIRST; i <= CATALOGUE_LAST; i++) {
        const struct catalogue_case *c = catalogue_case(i);
        fprintf(f, "| H%03d | %s | %s%s%s | ", i, c->what, catalogue_status(c), c->why ? ": " : "",
                c->why ? c->why : "");
        put_tests(f, i, &(struct style){"`", "`", " ", " (a known defect)"});
        fputs(" |\n", f);
    }
}

void catalogue_json(FILE *f)
{
    fputs(",\n \"catalogue\": [", f);
    for (int i = CATALOGUE_FIRST; i <= CATALOGUE_LAST; i++) {
        const struct catalogue_case *c = catalogue_case(i);
        fprintf(f, "%s\n  {\"id\": \"H%03d\", \"what\": \"%s\", \"status\": \"%s\", ",
                i > CATALOGUE_FIRST ? "," : "", i, c->what, catalogue_status(c));
        fprintf(f, "\"why\": \"%s\", \"tests\": [", c->why ? c->why : "");
        put_tests(f, i, &(struct style){"\"", "\"", ", ", ""});
        fputs("]}", f);
    }
    fputs("\n ]", f);
}

void catalogue_html(FILE *f)
{
    fputs("<h2>The catalogue</h2><p>Where each hard case is tested: rows above, and tests of "
          "<code>make check</code>.</p><table><tr><th>id<th>case<th>status<th>tests\n",
          f);
    for (int i = CATALOGUE_FIRST; i <= CATALOGUE_LAST; i++) {
        const struct catalogue_case *c = catalogue_case(i);
        fprintf(f, "<tr><td>H%03d<td>%s<td class=%s>%s%s%s<td>", i, c->what,
                c->status == ROW_TESTED ? "good" : "soft", catalogue_status(c), c->why ? ": " : "",
                c->why ? c->why : "");
        put_tests(f, i, &(struct style){"<code>", "</code>", " ", " (a known defect)"});
        fputc('\n', f);
    }
    fputs("</table>\n", f);
}
