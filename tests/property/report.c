/* SPDX-License-Identifier: MIT */
/* The report as Markdown and as JSON. */
#include "property/report.h"

#include <string.h>

#include "base/cpu.h"
#include "property/catalogue.h"
#include "property/oracle.h"

bool report_failed(const struct report_row *row)
{
    return row->ran && (row->result.failures > 0 || row->result.crashed || row->result.tried == 0);
}

const char *report_verdict(const struct report_row *row)
{
    if (row->row->status == ROW_PENDING)
        return "pending";
    if (row->row->status == ROW_INAPPLICABLE)
        return "does not apply";
    if (!row->ran)
        return "not run";
    if (!report_failed(row))
        return "passed";
    return row->row->known ? "FAILED, a known defect" : "FAILED";
}

struct report_sums report_sum(const struct report *report)
{
    struct report_sums s = {.tried = 0};
    for (int i = 0; i < report->rows; i++) {
        const struct report_row *row = &report->row[i];
        s.pending += row->row->status == ROW_PENDING;
        s.inapplicable += row->row->status == ROW_INAPPLICABLE;
        s.tested += row->ran;
        s.failed += report_failed(row);
        s.tried += row->result.tried;
        s.failures += row->result.failures;
        s.cpu_s += row->result.cpu_s;
    }
    return s;
}

/* Text inside a table's cell. */
static void put_cell(FILE *f, const char *text)
{
    for (; *text; text++) {
        if (*text == '|')
            fputc('\\', f);
        fputc(*text, f);
    }
}

static void markdown_row(const struct report_row *row, FILE *f)
{
    const struct row *r = row->row;
    fprintf(f, "| %s | `%s` | ", r->id, r->name);
    put_cell(f, r->what);
    if (r->status != ROW_TESTED) {
        fprintf(f, " – %s: ", report_verdict(row));
        put_cell(f, r->why);
        fprintf(f, " |  |  |  | %s |  |\n", report_verdict(row));
        return;
    }
    fputs(" | ", f);
    put_cell(f, r->oracle);
    fprintf(f, " | %llu | %llu | %s%s%s | %.1f |\n", (unsigned long long)row->result.tried,
            (unsigned long long)row->result.failures, report_verdict(row), r->known ? ": " : "",
            r->known ? r->known : "", row->result.cpu_s);
}

static void markdown_series(const struct report_row *row, FILE *f)
{
    for (int i = 0; i < row->result.series_count; i++) {
        const struct row_series *s = &row->result.series[i];
        char text[4096];
        row_print(text, sizeof text, &s->worst);
        fprintf(f, "| %s | ", row->row->id);
        put_cell(f, s->name);
        fprintf(f, " | %llu | %.3g | %.3g | %.4g | ", (unsigned long long)s->count,
                row_quantile(s, .5), row_quantile(s, .999), s->max);
        if (s->bound >= 0)
            fprintf(f, "%g | %llu", s->bound, (unsigned long long)s->over);
        else
            fputs("– | –", f);
        fprintf(f, " | `%s` |\n", text);
    }
}

static void markdown_failures(const struct report_row *row, FILE *f)
{
    char text[4096];
    if (row->result.crashed)
        fprintf(f, "- %s `%s`: %d processes ended by a signal or an assertion\n", row->row->id,
                row->row->name, row->result.crashed);
    for (int i = 0; i < row->result.kept_count; i++) {
        const struct row_kept *k = &row->result.kept[i];
        row_print(text, sizeof text, &k->small);
        fprintf(f, "- %s `%s`: %s\n  - smallest form: `%s`\n", row->row->id, row->row->name, k->why,
                text);
        row_print(text, sizeof text, &k->as_drawn);
        if (k->index == UINT64_MAX)
            fprintf(f, "  - from the corpus: `%s`\n", text);
        else
            fprintf(f, "  - case %llu: `%s`\n", (unsigned long long)k->index, text);
    }
}

static void markdown_tallies(const struct report_row *row, FILE *f)
{
    for (int i = 0; i < row->result.tally_count; i++)
        fprintf(f, "| %s | %s | %llu |\n", row->row->id, row->result.tally[i].name,
                (unsigned long long)row->result.tally[i].count);
}

static void markdown_prices(const struct report *report, FILE *f)
{
    if (report->prices == 0)
        return;
    fputs("\n## Cost\n\nOf one ray and one primitive: a ray is tested against a list of primitives "
          "in "
          "the cache, and the nearest hit is kept. ns: medians of interleaved runs on a shared "
          "machine.\n\n"
          "| primitive | method | ns | instructions |\n|---|---|---|---|\n",
          f);
    for (int i = 0; i < report->prices; i++) {
        const struct price *p = &report->price[i];
        fprintf(f, "| %s | %s | %.2f | ", p->primitive, p->method, p->ns);
        fprintf(f, p->instructions > 0 ? "%.1f |\n" : "– |\n", p->instructions);
    }
}

void report_markdown(const struct report *report, FILE *f)
{
    struct report_sums s = report_sum(report);
    fprintf(
        f,
        "# Stability\n\nSeed %llu, %d processes, %.0f s of processor time, %.0f s of wall time; "
        "%s; compiler %s; oracle: %s.\n\n%d rows tested, %d of them failed; %d pending, %d do "
        "not apply. %llu cases, %llu failures.\n\n"
        "| id | test | what | oracle | cases | failures | verdict | s |\n"
        "|---|---|---|---|---|---|---|---|\n",
        (unsigned long long)report->seed, report->jobs, s.cpu_s, report->wall_s,
        pen_isa_name(pen_cpu_isa()), __VERSION__, oracle_arithmetic(), s.tested, s.failed,
        s.pending, s.inapplicable, (unsigned long long)s.tried, (unsigned long long)s.failures);
    for (int i = 0; i < report->rows; i++)
        markdown_row(&report->row[i], f);
    fputs("\n## Failures\n\n", f);
    for (int i = 0; i < report->rows; i++)
        markdown_failures(&report->row[i], f);
    if (s.failed == 0)
        fputs("None.\n", f);
    fputs("\n## Errors\n\nQuantiles are rounded up to a quarter octave.\n\n"
          "| id | quantity | values | median | 99.9 % | max | bound | over | worst case |\n"
          "|---|---|---|---|---|---|---|---|---|\n",
          f);
    for (int i = 0; i < report->rows; i++)
        markdown_series(&report->row[i], f);
    fputs("\n## Counts\n\n| id | what was counted | cases |\n|---|---|---|\n", f);
    for (int i = 0; i < report->rows; i++)
        markdown_tallies(&report->row[i], f);
    catalogue_markdown(f);
    markdown_prices(report, f);
}
