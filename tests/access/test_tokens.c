/* SPDX-License-Identifier: MIT */
/* Token files, what is accepted and refused, and the tokens of a server. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "access/tokens.h"
#include "base/log.h"
#include "support/suite.h"

enum { TEXT_BYTES = 4096 };

static char folder[40], path[64];

static void make_folder(void)
{
    snprintf(folder, sizeof folder, "/tmp/penumbra-test-XXXXXX");
    ck_assert_ptr_nonnull(mkdtemp(folder));
    snprintf(path, sizeof path, "%s/tokens", folder);
}

static void remove_folder(void)
{
    unlink(path);
    rmdir(path);
    rmdir(folder);
}

/* Replaces the file as an editor does, so that its inode differs. */
static void write_text(const char *text, size_t bytes, mode_t mode)
{
    char name[80];
    snprintf(name, sizeof name, "%s.new", path);
    FILE *file = fopen(name, "w");
    ck_assert_ptr_nonnull(file);
    ck_assert_uint_eq(fwrite(text, 1, bytes, file), bytes);
    ck_assert_int_eq(fclose(file), 0);
    ck_assert_int_eq(chmod(name, mode), 0);
    ck_assert_int_eq(rename(name, path), 0);
}

static void write_file(const char *text)
{
    write_text(text, strlen(text), 0600);
}

/* A token with its line in a file; ends_s 0: it never ends. */
struct known {
    char sent[PEN_TOKEN_BYTES + 16]; /* the value of Authorization */
    char line[256];                  /* with the comments at the head of a file */
};

static struct known make_known(const char *name, enum pen_scope scope, int64_t ends_s)
{
    struct known known;
    struct pen_token token;
    struct pen_token_list list = {.count = 1, .token = &token};
    struct pen_buf text = {0};
    struct pen_status st;
    char made[PEN_TOKEN_BYTES];
    ck_assert_msg(pen_token_make(&token, name, scope, made, &st), "%s", st.msg);
    if (ends_s)
        token.expires_s = ends_s;
    pen_token_list_print(&list, &text);
    ck_assert(!text.failed);
    snprintf(known.sent, sizeof known.sent, "Bearer %s", made);
    snprintf(known.line, sizeof known.line, "%s", (const char *)text.data);
    pen_buf_release(&text);
    return known;
}

static void write_known(const struct known *a, const struct known *b)
{
    char text[TEXT_BYTES];
    snprintf(text, sizeof text, "%s%s", a->line, b ? b->line : "");
    write_file(text);
}

static struct pen_tokens *open_set(void)
{
    struct pen_status st;
    struct pen_tokens *tokens = pen_tokens_open(path, &st);
    ck_assert_msg(tokens != NULL, "%s", st.msg);
    return tokens;
}

static bool knows(struct pen_tokens *tokens, const struct known *known)
{
    struct pen_token_holder holder;
    struct pen_status st;
    return pen_tokens_check(tokens, known->sent, &holder, &st);
}

START_TEST(test_tokens__a_new_token_has_the_form_that_pages_state)
{
    static const char alphabet[] =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    struct pen_token token, other;
    struct pen_status st;
    char text[PEN_TOKEN_BYTES], again[PEN_TOKEN_BYTES];
    ck_assert(pen_token_make(&token, "ci", PEN_SCOPE_READ, text, &st));
    ck_assert(pen_token_make(&other, "ci", PEN_SCOPE_READ, again, &st));
    ck_assert_uint_eq(strlen(text), 47);
    ck_assert_int_eq(strncmp(text, "pen_", 4), 0);
    ck_assert_uint_eq(strspn(text + 4, alphabet), 43);
    ck_assert_str_ne(text, again);
}
END_TEST

START_TEST(test_tokens__good_files_are_read)
{
    make_folder();
    char text[TEXT_BYTES], expiry[PEN_TOKEN_EXPIRY_BYTES];
    struct pen_token_list list;
    struct pen_status st;
    snprintf(text, sizeof text,
             "# who may use it\n\n   # another comment\r\n"
             "a read never %064d\n"
             "\tb-2_c  submit\t2027-02-28T23:59:59Z %064d  \r\n"
             "n234567890123456789012345678901x admin 2000-01-01T00:00:00Z %063dA",
             1, 2, 3);
    write_text(text, strlen(text), 0400);
    ck_assert_msg(pen_token_list_read(&list, path, geteuid(), &st), "%d: %s", st.line, st.msg);
    ck_assert_uint_eq(list.count, 3);
    ck_assert_str_eq(list.token[1].name, "b-2_c");
    ck_assert_int_eq(list.token[0].scope, PEN_SCOPE_READ);
    ck_assert_int_eq(list.token[1].scope, PEN_SCOPE_SUBMIT);
    ck_assert_int_eq(list.token[2].scope, PEN_SCOPE_ADMIN);
    ck_assert_int_eq(list.token[0].expires_s, INT64_MAX);
    ck_assert_int_eq(list.token[2].expires_s, 946684800);
    ck_assert_uint_eq(list.token[2].hash[31], 0x3a);
    pen_token_expiry(&list.token[1], expiry);
    ck_assert_str_eq(expiry, "2027-02-28T23:59:59Z");
    pen_token_list_release(&list);
    write_file("");
    ck_assert(pen_token_list_read(&list, path, geteuid(), &st));
    ck_assert_uint_eq(list.count, 0);
    pen_token_list_release(&list);
    remove_folder();
}
END_TEST

/* `line` is the second line of a file; %s stands for a hash. */
static void expect_refused(const char *line, int column, const char *message)
{
    static const char hash[] = "5ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e75ec7e70000";
    char head[96], text[TEXT_BYTES];
    struct pen_token_list list;
    struct pen_status st;
    const char *at = strstr(line, "%s");
    snprintf(head, sizeof head, "first read never %064d\n", 7);
    snprintf(text, sizeof text, "%s%.*s%s%s\n", head, at ? (int)(at - line) : (int)strlen(line),
             line, at ? hash : "", at ? at + 2 : "");
    write_file(text);
    ck_assert_msg(!pen_token_list_read(&list, path, geteuid(), &st), "%s", line);
    ck_assert_int_eq(st.code, PEN_SYNTAX);
    ck_assert_msg(st.line == 2 && st.column == column, "%s: %d:%d", line, st.line, st.column);
    ck_assert_msg(strstr(st.msg, message) != NULL, "%s: %s", line, st.msg);
    ck_assert_msg(!strstr(st.msg, "5ec7e7"), "a hash is shown: %s", st.msg);
    pen_token_list_release(&list);
}

START_TEST(test_tokens__wrong_lines_are_refused)
{
    make_folder();
    static const struct {
        const char *line;
        int column;
        const char *message;
    } wrong[] = {
        {"ci", 1, "found 1 field, allowed are 4"},
        {"ci read %s", 1, "found 3 fields"},
        {"ci read never %s more", 1, "found 5 fields"},
        {"ci read never %s # comment", 1, "found 6 fields"},
        {"Ci read never %s", 1, "wrong name, allowed is a letter"},
        {"1ci read never %s", 1, "wrong name"},
        {"c.i read never %s", 1, "wrong name"},
        {"n2345678901234567890123456789012x read never %s", 1, "wrong name"},
        {"pen_5ec7e7secret read never %s x", 1, "found 5 fields"},
        {"ci write never %s", 4, "wrong scope, allowed is read, submit or admin"},
        {"ci READ never %s", 4, "wrong scope"},
        {" ci read 2027-01-31 %s", 10, "wrong expiry, allowed is a time in UTC"},
        {"ci read 2027-01-31T12:00:00 %s", 9, "wrong expiry"},
        {"ci read 2027-01-31T12:00:00+01:00 %s", 9, "wrong expiry"},
        {"ci read 2027-02-29T12:00:00Z %s", 9, "wrong expiry"},
        {"ci read 2027-1-31T12:00:00Z %s", 9, "wrong expiry"},
        {"ci read 2027-01-31T24:00:00Z %s", 9, "wrong expiry"},
        {"ci read 2027-01-31T12:00:60Z %s", 9, "wrong expiry"},
        {"ci read Never %s", 9, "wrong expiry"},
        {"ci read never 5ec7e7", 15, "wrong hash, allowed is 64 hex digits"},
        {"ci read never %s00", 15, "wrong hash"},
        {"ci read never x%s", 15, "wrong hash"},
        {"first read never %s", 1, "the name or the hash of a line above again"},
        {"ci read never 0000000000000000000000000000000000000000000000000000000000000007", 1,
         "the name or the hash of a line above again"},
    };
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        expect_refused(wrong[i].line, wrong[i].column, wrong[i].message);
    remove_folder();
}
END_TEST

static void expect_code(enum pen_code code, uid_t owner, const char *message)
{
    struct pen_token_list list;
    struct pen_status st;
    ck_assert(!pen_token_list_read(&list, path, owner, &st));
    ck_assert_int_eq(st.code, code);
    ck_assert_msg(strstr(st.msg, message) != NULL, "%s", st.msg);
    pen_token_list_release(&list);
}

START_TEST(test_tokens__files_of_wrong_kind_or_rights_are_refused)
{
    make_folder();
    static const mode_t wrong[] = {0640, 0604, 0610, 0601, 0620, 0602, 0644};
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++) {
        write_text("", 0, wrong[i]);
        expect_code(PEN_FORBIDDEN, geteuid(), "allowed is 0600");
    }
    write_text("\n\0\n", 3, 0600);
    expect_code(PEN_SYNTAX, geteuid(), "zero byte");
    unlink(path);
    expect_code(PEN_NOT_FOUND, geteuid(), "cannot open");
    ck_assert_int_eq(mkdir(path, 0700), 0);
    expect_code(PEN_FORBIDDEN, geteuid(), "not a regular file");
    rmdir(path);
    ck_assert_int_eq(mkfifo(path, 0600), 0);
    expect_code(PEN_FORBIDDEN, geteuid(), "not a regular file");
    remove_folder();
}
END_TEST

START_TEST(test_tokens__files_of_another_owner_are_refused)
{
    make_folder();
    enum { OTHER = 12345 };
    struct pen_token_list list;
    struct pen_status st;
    write_file("");
    if (geteuid() != 0) {
        expect_code(PEN_FORBIDDEN, OTHER, "found the owner");
    } else {
        ck_assert_msg(pen_token_list_read(&list, path, OTHER, &st), "root's file: %s", st.msg);
        pen_token_list_release(&list);
        ck_assert_int_eq(chown(path, OTHER, OTHER), 0);
        expect_code(PEN_FORBIDDEN, 0, "found the owner 12345, allowed are 0");
        ck_assert_ptr_null(pen_tokens_open(path, &st));
    }
    remove_folder();
}
END_TEST

START_TEST(test_tokens__a_file_that_is_too_large_is_refused)
{
    make_folder();
    enum { BYTES = (1 << 20) + 1 };
    char *text = malloc(BYTES);
    ck_assert_ptr_nonnull(text);
    memset(text, '\n', BYTES);
    write_text(text, BYTES - 1, 0600);
    struct pen_token_list list;
    struct pen_status st;
    ck_assert(pen_token_list_read(&list, path, geteuid(), &st));
    pen_token_list_release(&list);
    write_text(text, BYTES, 0600);
    expect_code(PEN_TOO_LARGE, geteuid(), "larger than 1048576 bytes");
    free(text);
    remove_folder();
}
END_TEST

START_TEST(test_tokens__a_list_that_is_printed_reads_back)
{
    make_folder();
    char name[PEN_TOKEN_NAME_BYTES], text[PEN_TOKEN_BYTES];
    struct pen_token_list list = {0}, again;
    struct pen_token token;
    struct pen_buf printed = {0};
    struct pen_status st;
    for (int i = 0; i < 100; i++) {
        snprintf(name, sizeof name, "t%d", i);
        ck_assert(pen_token_make(&token, name, (enum pen_scope)(1 + i % 3), text, &st));
        token.expires_s = i % 5 ? 86399 + INT64_C(123456789) * i : INT64_MAX;
        ck_assert(pen_token_list_add(&list, &token, &st));
    }
    ck_assert(!pen_token_list_add(&list, &token, &st));
    ck_assert_int_eq(st.code, PEN_CONFLICT);
    ck_assert(pen_token_list_remove(&list, "t0"));
    ck_assert(pen_token_list_remove(&list, "t99"));
    ck_assert(pen_token_list_remove(&list, "t50"));
    ck_assert(!pen_token_list_remove(&list, "t50"));
    pen_token_list_print(&list, &printed);
    write_text((const char *)printed.data, printed.bytes, 0600);
    ck_assert_msg(pen_token_list_read(&again, path, geteuid(), &st), "%d: %s", st.line, st.msg);
    ck_assert_uint_eq(again.count, 97);
    for (size_t i = 0; i < again.count; i++) {
        const struct pen_token *a = &again.token[i], *b = &list.token[i];
        ck_assert_str_eq(a->name, b->name);
        ck_assert_int_eq(a->scope, b->scope);
        ck_assert_int_eq(a->expires_s, b->expires_s);
        ck_assert_mem_eq(a->hash, b->hash, sizeof a->hash);
    }
    pen_buf_release(&printed);
    pen_token_list_release(&list);
    pen_token_list_release(&again);
    remove_folder();
}
END_TEST

START_TEST(test_tokens__a_token_tells_its_holder)
{
    make_folder();
    const struct known ci = make_known("ci", PEN_SCOPE_SUBMIT, 0),
                       lena = make_known("lena", PEN_SCOPE_ADMIN, time(NULL) + 3600);
    write_known(&ci, &lena);
    struct pen_tokens *tokens = open_set();
    struct pen_token_holder holder;
    struct pen_status st;
    ck_assert(pen_tokens_check(tokens, ci.sent, &holder, &st));
    ck_assert_str_eq(holder.name, "ci");
    ck_assert_int_eq(holder.scope, PEN_SCOPE_SUBMIT);
    ck_assert(pen_tokens_holds(tokens, &holder));
    ck_assert(pen_tokens_check(tokens, lena.sent, &holder, &st));
    ck_assert_str_eq(holder.name, "lena");
    ck_assert_int_eq(holder.scope, PEN_SCOPE_ADMIN);
    char other[96];
    snprintf(other, sizeof other, "bEARER \t %.60s \t", lena.sent + strlen("Bearer "));
    ck_assert(pen_tokens_check(tokens, other, &holder, &st));
    pen_tokens_close(tokens);
    remove_folder();
}
END_TEST

static void expect_unauthorized(struct pen_tokens *tokens, const char *sent, const char *message)
{
    struct pen_token_holder holder;
    struct pen_status st;
    ck_assert_msg(!pen_tokens_check(tokens, sent, &holder, &st), "%s", sent ? sent : "none");
    ck_assert_int_eq(st.code, PEN_UNAUTHORIZED);
    ck_assert_str_eq(st.msg, message);
}

START_TEST(test_tokens__what_is_no_valid_token_is_refused)
{
    make_folder();
    static const char none[] = "no token was sent; send the field Authorization: Bearer TOKEN",
                      invalid[] = "the token is unknown or no longer valid";
    static const char *const missing[] = {NULL,         "",           "Bearer", "Bearer ",
                                          "Bearer\t",   "Basic x",    "pen_x",  "Bearerpen_x",
                                          "Bearer a b", "Bearer  \t "};
    const struct known now = make_known("now", PEN_SCOPE_READ, 0),
                       past = make_known("past", PEN_SCOPE_ADMIN, time(NULL));
    write_known(&now, &past);
    struct pen_tokens *tokens = open_set();
    for (size_t i = 0; i < sizeof missing / sizeof missing[0]; i++)
        expect_unauthorized(tokens, missing[i], none);
    expect_unauthorized(tokens, past.sent, invalid);
    char sent[sizeof now.sent + 1];
    for (size_t i = strlen("Bearer "); now.sent[i]; i++) { /* each character counts */
        snprintf(sent, sizeof sent, "%s", now.sent);
        sent[i] = sent[i] == 'A' ? 'B' : 'A';
        expect_unauthorized(tokens, sent, invalid);
    }
    snprintf(sent, sizeof sent, "%sA", now.sent);
    expect_unauthorized(tokens, sent, invalid);
    sent[strlen(sent) - 2] = '\0';
    expect_unauthorized(tokens, sent, invalid);
    ck_assert(knows(tokens, &now));
    pen_tokens_close(tokens);
    remove_folder();
}
END_TEST

/* Puts other words at the place of `a submit never` in the line of a token. */
static void rewrite(struct known *known, const char *words)
{
    char *at = strstr(known->line, "a submit never"), rest[128];
    ck_assert_ptr_nonnull(at);
    snprintf(rest, sizeof rest, "%s", at + strlen("a submit never"));
    snprintf(at, sizeof known->line - (size_t)(at - known->line), "%s%s", words, rest);
}

/* Whether the holder of a token has it still when its line has other words. */
static bool holds_with(const char *words)
{
    struct known known = make_known("a", PEN_SCOPE_SUBMIT, 0);
    struct pen_token_holder holder;
    struct pen_status st;
    write_known(&known, NULL);
    struct pen_tokens *tokens = open_set();
    ck_assert(pen_tokens_check(tokens, known.sent, &holder, &st));
    ck_assert(pen_tokens_holds(tokens, &holder));
    rewrite(&known, words);
    write_known(&known, NULL);
    pen_tokens_refresh(tokens);
    ck_assert(!pen_tokens_fault(tokens, &st));
    const bool holds = pen_tokens_holds(tokens, &holder);
    pen_tokens_close(tokens);
    return holds;
}

START_TEST(test_tokens__a_holder_loses_a_token_that_expires_or_allows_less)
{
    make_folder();
    ck_assert(holds_with("a submit 2999-01-01T00:00:00Z"));
    ck_assert(holds_with("a admin never"));
    ck_assert(!holds_with("a submit 2020-01-01T00:00:00Z"));
    ck_assert(!holds_with("a read never"));
    ck_assert(!holds_with("b submit never"));
    remove_folder();
}
END_TEST

START_TEST(test_tokens__a_changed_file_is_read_again)
{
    make_folder();
    const struct known a = make_known("a", PEN_SCOPE_SUBMIT, 0),
                       b = make_known("b", PEN_SCOPE_READ, 0),
                       other = make_known("a", PEN_SCOPE_SUBMIT, 0);
    struct pen_token_holder holder;
    struct pen_status st;
    write_known(&a, NULL);
    struct pen_tokens *tokens = open_set();
    ck_assert(pen_tokens_check(tokens, a.sent, &holder, &st));
    write_known(&a, &b);
    ck_assert(!knows(tokens, &b));
    pen_tokens_refresh(tokens);
    ck_assert(knows(tokens, &b));
    ck_assert(pen_tokens_holds(tokens, &holder));
    write_known(&other, &b); /* the same name and scope */
    pen_tokens_refresh(tokens);
    ck_assert(!pen_tokens_holds(tokens, &holder));
    ck_assert(!knows(tokens, &a));
    ck_assert(knows(tokens, &other));
    write_known(&b, NULL);
    pen_tokens_refresh(tokens);
    ck_assert(!knows(tokens, &other));
    ck_assert(!pen_tokens_fault(tokens, &st));
    pen_tokens_close(tokens);
    remove_folder();
}
END_TEST

/* How many lines of the log have a text. */
static int count_logged(const struct pen_log_ring *ring, const char *text)
{
    static char log[PEN_LOG_RING_BYTES];
    int count = 0;
    pen_log_ring_last(ring, 1000, log, sizeof log);
    for (const char *at = log; (at = strstr(at, text)); at++)
        count++;
    return count;
}

static struct pen_log_ring ring;

START_TEST(test_tokens__a_broken_file_leaves_the_last_good_tokens)
{
    make_folder();
    static const char stay[] = "the tokens that were read before stay in force";
    const struct known a = make_known("a", PEN_SCOPE_READ, 0);
    struct pen_status st;
    pen_log_set_ring(&ring);
    write_known(&a, NULL);
    struct pen_tokens *tokens = open_set();
    write_file("# tokens\na read never 5ec7e7\n");
    for (int i = 0; i < 3; i++)
        pen_tokens_refresh(tokens);
    ck_assert(knows(tokens, &a));
    ck_assert(pen_tokens_fault(tokens, &st));
    ck_assert_msg(strstr(st.msg, "tokens:2:14: wrong hash") != NULL, "%s", st.msg);
    ck_assert_int_eq(count_logged(&ring, stay), 1);
    ck_assert_int_eq(count_logged(&ring, "5ec7e7"), 0);
    unlink(path);
    pen_tokens_refresh(tokens);
    pen_tokens_refresh(tokens);
    ck_assert(knows(tokens, &a));
    ck_assert(pen_tokens_fault(tokens, &st));
    ck_assert_int_eq(count_logged(&ring, stay), 2);
    write_known(&a, NULL);
    pen_tokens_refresh(tokens);
    ck_assert(!pen_tokens_fault(tokens, &st));
    ck_assert_int_eq(count_logged(&ring, "read again, it has 1 token"), 1);
    ck_assert_int_eq(chmod(path, 0644), 0); /* changes neither time nor size of the contents */
    pen_tokens_refresh(tokens);
    ck_assert(pen_tokens_fault(tokens, &st));
    ck_assert_msg(strstr(st.msg, "found the mode 0644") != NULL, "%s", st.msg);
    ck_assert(knows(tokens, &a));
    pen_tokens_close(tokens);
    pen_log_set_ring(NULL);
    remove_folder();
}
END_TEST

START_TEST(test_tokens__a_set_does_not_open_a_broken_file)
{
    make_folder();
    struct pen_status st;
    write_file("a read never 5ec7e7\n");
    ck_assert_ptr_null(pen_tokens_open(path, &st));
    ck_assert_msg(strstr(st.msg, path) && strstr(st.msg, ":1:14: wrong hash"), "%s", st.msg);
    ck_assert_int_eq(st.code, PEN_SYNTAX);
    write_text("", 0, 0644);
    ck_assert_ptr_null(pen_tokens_open(path, &st));
    ck_assert_msg(strstr(st.msg, path) && strstr(st.msg, "mode 0644"), "%s", st.msg);
    unlink(path);
    ck_assert_ptr_null(pen_tokens_open(path, &st));
    ck_assert_msg(strstr(st.msg, path) && strstr(st.msg, "cannot open"), "%s", st.msg);
    remove_folder();
}
END_TEST

PEN_SUITE("tokens", test_tokens__a_new_token_has_the_form_that_pages_state,
          test_tokens__good_files_are_read, test_tokens__wrong_lines_are_refused,
          test_tokens__files_of_wrong_kind_or_rights_are_refused,
          test_tokens__files_of_another_owner_are_refused,
          test_tokens__a_file_that_is_too_large_is_refused,
          test_tokens__a_list_that_is_printed_reads_back, test_tokens__a_token_tells_its_holder,
          test_tokens__what_is_no_valid_token_is_refused,
          test_tokens__a_holder_loses_a_token_that_expires_or_allows_less,
          test_tokens__a_changed_file_is_read_again,
          test_tokens__a_broken_file_leaves_the_last_good_tokens,
          test_tokens__a_set_does_not_open_a_broken_file)
