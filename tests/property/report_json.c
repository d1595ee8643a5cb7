/* SPDX-License-Identifier: MIT */
/* The report as JSON. Arguments are strings of hex floats: exact. */
#include <math.h>

#include "property/catalogue.h"
#include "property/report.h"

static void put_string(FILE *f, const char *key, const char *text, const char *after)
{
    fprintf(f, "\"%s\": \"", key);
    for (; text && *text; text++) {
        if (*text == '"' || *text == '\\')
            fputc('\\', f);
        fputc(*text, f);
    }
    fprintf(f, "\"%s", after);
}

static void put_case(FILE *f, const char *key, const struct row_case *c, const char *after)
{
    char text[4096];
    row_print(text, sizeof text, c);
    put_string(f, key, text, after);
}

/* JSON has no infinity. */
static void put_number(FILE *f, const char *key, double x, const char *after)
{
    if (isfinite(x))
        fprintf(f, "\"%s\": %.17g%s", key, x, after);
    else
        fprintf(f, "\"%s\": null%s", key, after);
}

static void put_series(FILE *f, const struct row_series *s)
{
    fputs("{", f);
    put_string(f, "name", s->name, ", ");
    fprintf(f, "\"values\": %llu, \"over\": %llu, ", (unsigned long long)s->count,
            (unsigned long long)s->over);
    put_number(f, "bound", s->bound >= 0 ? s->bound : (double)NAN, ", ");
    put_number(f, "median", row_quantile(s, .5), ", ");
    put_number(f, "p999", row_quantile(s, .999), ", ");
    put_number(f, "max", s->max, ", ");
    put_case(f, "worst", &s->worst, ", \"histogram\": [");
    const char *comma = "";
    for (int i = 0; i < ROW_BINS; i++) {
        if (s->bin[i] == 0)
            continue;
        fprintf(f, "%s[%.6g, %llu]", comma, row_bin_begin(i), (unsigned long long)s->bin[i]);
        comma = ", ";
    }
    fputs("]}", f);
}

static void put_kept(FILE *f, const struct row_kept *k)
{
    fputs("{", f);
    put_string(f, "why", k->why, ", ");
    put_case(f, "smallest", &k->small, ", ");
    put_case(f, "drawn", &k->as_drawn, "}");
}

static void put_row(FILE *f, const struct report_row *row)
{
    const struct row_result *r = &row->result;
    fputs("  {", f);
    put_string(f, "id", row->row->id, ", ");
    put_string(f, "test", row->row->name, ", ");
    put_string(f, "what", row->row->what, ", ");
    put_string(f, "oracle", row->row->oracle, ", ");
    put_string(f, "verdict", report_verdict(row), ", ");
    put_string(f, "why", row->row->why ? row->row->why : row->row->known, ",\n   ");
    fprintf(f,
            "\"cases\": %llu, \"skipped\": %llu, \"failures\": %llu, \"replayed\": %llu, "
            "\"crashed\": %d, \"cpu_seconds\": %.3f,\n   \"series\": [",
            (unsigned long long)r->tried, (unsigned long long)r->skipped,
            (unsigned long long)r->failures, (unsigned long long)r->replayed, r->crashed, r->cpu_s);
    for (int i = 0; i < r->series_count; i++) {
        fputs(i ? ",\n    " : "", f);
        put_series(f, &r->series[i]);
    }
    fputs("], \"counted\": {", f);
    for (int i = 0; i < r->tally_count; i++)
        fprintf(f, "%s\"%s\": %llu", i ? ", " : "", r->tally[i].name,
                (unsigned long long)r->tally[i].count);
    fputs("}, \"failed\": [", f);
    for (int i = 0; i < r->kept_count; i++) {
        fputs(i ? ", " : "", f);
        put_kept(f, &r->kept[i]);
    }
    fputs("]}", f);
}

void report_json(const struct report *report, FILE *f)
{
    struct report_sums s = report_sum(report);
    fprintf(f,
            "{\"seed\": %llu, \"jobs\": %d, \"wall_seconds\": %.3f, \"cpu_seconds\": %.3f, "
            "\"tested\": %d, \"failed\": %d, \"pending\": %d, \"inapplicable\": %d, "
            "\"cases\": %llu, \"failures\": %llu,\n \"rows\": [\n",
            (unsigned long long)report->seed, report->jobs, report->wall_s, s.cpu_s, s.tested,
            s.failed, s.pending, s.inapplicable, (unsigned long long)s.tried,
            (unsigned long long)s.failures);
    for (int i = 0; i < report->rows; i++) {
        fputs(i ? ",\n" : "", f);
        put_row(f, &report->row[i]);
    }
    fputs("\n ],\n \"price\": [", f);
    for (int i = 0; i < report->prices; i++) {
        const struct price *p = &report->price[i];
        fputs(i ? ",\n  {" : "\n  {", f);
        put_string(f, "primitive", p->primitive, ", ");
        put_string(f, "method", p->method, ", ");
        put_number(f, "ns", p->ns, ", ");
        put_number(f, "instructions", p->instructions > 0 ? p->instructions : (double)NAN, "}");
    }
    fputs("\n ]", f);
    catalogue_json(f);
    fputs("}\n", f);
}
