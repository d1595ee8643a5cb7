/* SPDX-License-Identifier: MIT */
#include "cmd/client/report_source.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

#include "cmd/client/remote_job.h"
#include "cmd/files.h"
#include "cmd/report.h"
#include "report/report.h"
#include "study/comparison.h"

enum { REPORT_BYTES_MAX = 64 << 20, ID_LENGTH = 36 };

static const char jobs_path[] = "/v1/jobs/";

/* 8-4-4-4-12 hexadecimal digits. */
static bool is_job_id(const char *text)
{
    int i = 0;
    for (; i < ID_LENGTH && text[i]; i++) {
        const bool dash = i == 8 || i == 13 || i == 18 || i == 23;
        if (dash ? text[i] != '-' : !isxdigit((unsigned char)text[i]))
            return false;
    }
    return i == ID_LENGTH && !text[i];
}

static bool is_url(const char *text)
{
    return strncmp(text, "http://", 7) == 0 || strncmp(text, "https://", 8) == 0;
}

static bool add_error(struct pen_errors *errors, const struct pen_status *st)
{
    pen_errors_add(errors, st);
    return false;
}

static bool fetch(const struct pen_remote *remote, const char *id, json_t **report,
                  struct pen_errors *errors)
{
    struct pen_status st;
    struct pen_client *client = pen_client_open(remote, &st);
    if (!client)
        return add_error(errors, &st);
    const bool ok = pen_remote_report(client, id, report, errors);
    pen_client_close(client);
    return ok;
}

/* Returns true if two URLs of daemons differ at most in slashes at the end. */
static bool same_server(const char *a, const char *b)
{
    while (*a && *a == *b)
        a++, b++;
    return !a[strspn(a, "/")] && !b[strspn(b, "/")];
}

/* Splits http://HOST/v1/jobs/ID, which may continue, into daemon and job. A daemon other than that
 * of --server gets no token. */
static bool fetch_url(const char *url, const struct pen_remote *remote, json_t **report,
                      struct pen_errors *errors)
{
    struct pen_status st;
    char server[512], id[ID_LENGTH + 1] = "";
    const char *jobs = strstr(url, jobs_path);
    if (jobs)
        snprintf(id, sizeof id, "%s", jobs + strlen(jobs_path));
    if (!jobs || !is_job_id(id) || (size_t)(jobs - url) >= sizeof server) {
        pen_fail(&st, PEN_USAGE, "found \"%s\", allowed is http://HOST%sID", url, jobs_path);
        return add_error(errors, &st);
    }
    snprintf(server, sizeof server, "%.*s", (int)(jobs - url), url);
    struct pen_remote other = *remote;
    other.server = server;
    if (!same_server(server, remote->server))
        other.token = "";
    return fetch(&other, id, report, errors);
}

static bool read_file(const char *path, json_t **report, struct pen_errors *errors)
{
    struct pen_source source;
    struct pen_status st;
    json_error_t error;
    bool ok = pen_source_read(&source, path, REPORT_BYTES_MAX, &st);
    if (ok) {
        *report = json_loadb((const char *)source.text.data, source.text.bytes,
                             JSON_REJECT_DUPLICATES, &error);
        ok = *report ||
             pen_fail_line(&st, PEN_SYNTAX, error.line, error.column, "%.200s", error.text);
    }
    pen_source_release(&source);
    return ok || add_error(errors, &st);
}

bool pen_report_source_read(const char *name, const struct pen_remote *remote, json_t **report,
                            struct pen_errors *errors)
{
    struct pen_status st;
    bool ok;
    *report = NULL;
    if (remote && is_url(name))
        ok = fetch_url(name, remote, report, errors);
    else if (remote && is_job_id(name))
        ok = fetch(remote, name, report, errors);
    else
        ok = read_file(name, report, errors);
    return ok && (pen_comparison_check(*report, &st) || add_error(errors, &st));
}

bool pen_report_source_is_json(const char *path)
{
    FILE *file = fopen(path, "re");
    int c = file ? fgetc(file) : EOF;
    while (c != EOF && isspace(c))
        c = fgetc(file);
    if (file)
        fclose(file);
    return c == '{';
}

static int compare(const struct pen_report_compare *c, const json_t *before, const json_t *after)
{
    struct pen_status st;
    struct pen_buf text = {0};
    json_t *comparison = pen_comparison_new(before, after, &st);
    if (!comparison)
        return pen_report_json(NULL, c->json, &st);
    if (c->json)
        pen_report_line(json_incref(comparison));
    else if (!c->quiet && pen_report_write(comparison, "text", NULL, &text, &st))
        pen_report_show(stdout, (const char *)text.data);
    pen_buf_release(&text);
    const bool same = pen_comparison_judge(comparison, c->time, &st);
    json_decref(comparison);
    if (same)
        return 0;
    return c->quiet ? pen_code_exit(st.code) : pen_report("penumbra", NULL, &st);
}

int pen_report_compare(const struct pen_report_compare *c)
{
    struct pen_errors errors = {0};
    json_t *before = NULL, *after = NULL;
    int code;
    if (!pen_report_source_read(c->before, NULL, &before, &errors))
        code = pen_report_errors_json(c->before, c->json, &errors);
    else if (!pen_report_source_read(c->after, NULL, &after, &errors))
        code = pen_report_errors_json(c->after, c->json, &errors);
    else
        code = compare(c, before, after);
    json_decref(before);
    json_decref(after);
    return code;
}
