/* SPDX-License-Identifier: MIT */
/* The statements of the rules, read from the objects of the store. Each can be prepared, uses only
 * SQL that SQLite and PostgreSQL share, and reads no large table from end to end. */
#include <ctype.h>
#include <glob.h>
#include <regex.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "store/db.h"
#include "support/store.h"
#include "support/suite.h"

enum { MOST = 400, LEAST = 100 };

static char *statements[MOST];
static int count;

static bool begins_statement(const char *text)
{
    static const char *const words[] = {"SELECT ", "INSERT INTO ", "UPDATE ", "DELETE FROM "};
    for (size_t i = 0; i < sizeof words / sizeof words[0]; i++) {
        if (strncmp(text, words[i], strlen(words[i])) == 0)
            return true;
    }
    return false;
}

static bool is_known(const char *text)
{
    for (int i = 0; i < count; i++) {
        if (strcmp(statements[i], text) == 0)
            return true;
    }
    return false;
}

/* Literals are texts between zero bytes. */
static void read_object(const char *path)
{
    static char data[4 << 20];
    FILE *file = fopen(path, "rb");
    ck_assert_ptr_nonnull(file);
    const size_t bytes = fread(data, 1, sizeof data - 1, file);
    ck_assert_uint_lt(bytes, sizeof data - 1);
    fclose(file);
    for (size_t at = 0; at < bytes; at += strlen(data + at) + 1) {
        const char *text = data + at;
        while (!isprint((unsigned char)*text) && *text)
            text++;
        if (!begins_statement(text) || is_known(text))
            continue;
        ck_assert_int_lt(count, MOST);
        statements[count++] = strdup(text);
    }
}

/* The objects lie beside the test, in the build's folder. Those of an engine have SQL of their
 * own. */
static void read_statements(void)
{
    char path[1024];
    glob_t found;
    ssize_t length = readlink("/proc/self/exe", path, sizeof path - 64);
    ck_assert_int_gt(length, 0);
    path[length] = '\0';
    for (int i = 0; i < 3; i++)
        *strrchr(path, '/') = '\0';
    strcat(path, "/src/store/*.o");
    ck_assert_int_eq(glob(path, 0, NULL, &found), 0);
    for (size_t i = 0; i < found.gl_pathc; i++) {
        if (!strstr(found.gl_pathv[i], "/db_"))
            read_object(found.gl_pathv[i]);
    }
    globfree(&found);
    printf("%d statements\n", count);
    ck_assert_int_ge(count, LEAST);
}

/* What one of the engines refuses, or understands in another way (src/store/SQL.md). */
static const struct {
    const char *pattern, *why;
} refused[] = {
    {"\\?", "parameters are $1, $2, ..."},
    {"[xX]'", "blobs are parameters"},
    {"(LIKE|GLOB|REGEXP|MATCH) ", "engines differ in case and words"},
    {"(iif|ifnull|instr|printf|total|unixepoch|strftime|datetime|julianday|hex|group_concat)\\(",
     "a function of SQLite"},
    {"json", "JSON is a matter of C"},
    {"(max|min)\\([^()]*,", "write CASE"},
    {"(greatest|least)\\(", "write CASE"},
    {"INSERT OR |REPLACE |AUTOINCREMENT|rowid|PRAGMA|INDEXED BY|COLLATE NOCASE", "of SQLite"},
    {"FOR UPDATE", "write {skip_locked}, or lock by an UPDATE"},
    {"DELETE FROM [a-z]+ USING", "SQLite has no DELETE USING"},
    {"^WITH |WITH RECURSIVE", "no CTE"},
    {"RETURNING [^(]* AS ", "RETURNING has no alias"},
    {"AND 1( |$)|AND 0( |$)|WHERE 1( |$)", "numbers are no conditions"},
    {"\\$[0-9]+ IS ", "an untyped parameter"},
    {"==|\"|`", "another spelling of SQL"},
    {"LIMIT [^ )]+,", "write OFFSET"},
    {"[^(]sum\\(|^sum\\(", "PostgreSQL's sum is NUMERIC: CAST(sum(...) AS BIGINT)"},
    {"DO UPDATE SET [a-z_]+ = [a-z_]+ [+-]", "DO UPDATE names the table"},
    {"now_ms\\(\\)", "now is (SELECT now_ms())"},
    {"::", "a cast of PostgreSQL"},
};

/* Takes out what is right, so that what is left shows what is not. */
static void leave_out(char *text, const char *part)
{
    for (char *at; (at = strstr(text, part)) != NULL;)
        memmove(at, at + strlen(part), strlen(at + strlen(part)) + 1);
}

static const char *offence(const char *statement)
{
    char text[8192];
    snprintf(text, sizeof text, "%s", statement);
    leave_out(text, "(SELECT now_ms())");
    leave_out(text, "CAST(sum(");
    leave_out(text, "CAST(coalesce(sum(");
    for (size_t i = 0; i < sizeof refused / sizeof refused[0]; i++) {
        regex_t pattern;
        ck_assert_int_eq(regcomp(&pattern, refused[i].pattern, REG_EXTENDED | REG_NOSUB), 0);
        const int match = regexec(&pattern, text, 0, NULL, 0);
        regfree(&pattern);
        if (match == 0)
            return refused[i].why;
    }
    return NULL;
}

START_TEST(test_sql__the_common_sql_is_kept)
{
    static const char *const wrong[] = {
        "SELECT max(a, b) FROM job",
        "SELECT iif(state = 1, 2, 3) FROM job",
        "INSERT OR IGNORE INTO job (id) VALUES ($1)",
        "SELECT number FROM job WHERE id = ?",
        "SELECT number FROM job WHERE $1 IS NULL OR id = $1",
        "SELECT sum(bytes) FROM object",
        "SELECT number FROM job FOR UPDATE",
        "SELECT rowid FROM job",
        "UPDATE job SET state = 1 WHERE number = $1 AND 1",
        "SELECT number FROM job WHERE created_ms < now_ms()",
        "INSERT INTO turn (turn) VALUES (0) ON CONFLICT (client) DO UPDATE SET turn = turn + 1",
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        ck_assert_msg(offence(wrong[i]) != NULL, "not noticed: %s", wrong[i]);
    read_statements();
    for (int i = 0; i < count; i++) {
        const char *why = offence(statements[i]);
        ck_assert_msg(!why, "%s: %s", why, statements[i]);
    }
}
END_TEST

static struct store_bed bed;

static struct pen_db *open_db(void)
{
    struct pen_status st;
    store_bed_open(&bed);
    struct pen_db *db = pen_db_open(bed.url, false, &st);
    store_must(db != NULL, &st, "open");
    return db;
}

/* By psql, which does not need the types of parameters. */
static void prepare_all(void)
{
    static const char word[] = "{skip_locked}";
    char path[128], command[512];
    snprintf(path, sizeof path, "%s/statements", bed.folder);
    FILE *file = fopen(path, "w");
    ck_assert_ptr_nonnull(file);
    fprintf(file, "SET search_path = %s;\n", bed.schema);
    for (int i = 0; i < count; i++) {
        const char *sql = statements[i];
        fprintf(file, "PREPARE s%d AS ", i);
        for (const char *at; (at = strstr(sql, word)) != NULL; sql = at + sizeof word - 1)
            fprintf(file, "%.*sFOR UPDATE SKIP LOCKED", (int)(at - sql), sql);
        fprintf(file, "%s;\n", sql);
    }
    ck_assert_int_eq(fclose(file), 0);
    snprintf(command, sizeof command, "psql -qX -v ON_ERROR_STOP=1 -d test -f %s", path);
    ck_assert_int_eq(system(command), 0);
}

START_TEST(test_sql__every_statement_is_prepared)
{
    struct pen_db *db = open_db();
    struct pen_status st = {0};
    read_statements();
    if (bed.schema[0])
        prepare_all();
    for (int i = 0; i < count && !bed.schema[0]; i++) {
        struct pen_rows *rows = pen_db_rows(db, &st, statements[i], "");
        ck_assert_msg(pen_db_done(rows), "%s: %s", statements[i], st.msg);
    }
    pen_db_close(db);
    store_bed_close(&bed);
}
END_TEST

/* Tables that grow with jobs. An index may be read whole where it is a partial one of a state, but
 * not that of all batches; nor may SQLite make one for a statement. */
static bool is_long(const char *step)
{
    static const char *const tables[] = {"job",  "batch",     "object",  "part",
                                         "view", "attribute", "removed", "scene"};
    char scan[64];
    if (strstr(step, "AUTOMATIC") || strstr(step, "batch_by_job (job>"))
        return true;
    for (size_t i = 0; i < sizeof tables / sizeof tables[0]; i++) {
        snprintf(scan, sizeof scan, "SCAN %s", tables[i]);
        const size_t length = strlen(scan);
        if (strncmp(step, scan, length) == 0 && (step[length] == '\0' || step[length] == ' '))
            return strstr(step, "INDEX") == NULL;
    }
    return false;
}

START_TEST(test_sql__no_statement_reads_a_large_table_from_end_to_end)
{
    static char plan[MOST][8192];
    struct pen_db *db = open_db();
    struct pen_status st = {0};
    int offences = 0;
    ck_assert(is_long("SCAN job") && !is_long("SCAN job USING INDEX job_by_end"));
    read_statements();
    for (int i = 0; i < count && !bed.schema[0]; i++) { /* plans of SQLite */
        snprintf(plan[i], sizeof plan[i], "EXPLAIN QUERY PLAN %s", statements[i]);
        struct pen_rows *rows = pen_db_rows(db, &st, plan[i], "");
        while (pen_db_next(rows)) {
            const char *step = pen_db_text(rows, 3);
            if (getenv("PEN_PLANS"))
                printf("%s\n    %s\n", statements[i], step);
            if (is_long(step))
                offences += printf("%s: %s\n", step, statements[i]) > 0;
        }
        ck_assert_msg(pen_db_done(rows), "%s: %s", statements[i], st.msg);
    }
    pen_db_close(db);
    store_bed_close(&bed);
    ck_assert_int_eq(offences, 0);
}
END_TEST

PEN_SUITE("store SQL", test_sql__the_common_sql_is_kept, test_sql__every_statement_is_prepared,
          test_sql__no_statement_reads_a_large_table_from_end_to_end)
