/* SPDX-License-Identifier: MIT */
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/log.h"
#include "support/suite.h"

static int saved, reading;

/* Redirects standard error to a file until log_end. */
static void log_begin(void)
{
    char name[] = "/tmp/pen_test_log_XXXXXX";
    reading = mkstemp(name);
    ck_assert_int_ge(reading, 0);
    unlink(name);
    fflush(stderr);
    saved = dup(STDERR_FILENO);
    dup2(reading, STDERR_FILENO);
}

/* Restores standard error, and returns what was written to the file. */
static const char *log_end(void)
{
    static char text[1 << 20];
    dup2(saved, STDERR_FILENO);
    close(saved);
    ssize_t bytes = pread(reading, text, sizeof text - 1, 0);
    close(reading);
    text[bytes > 0 ? bytes : 0] = '\0';
    return text;
}

START_TEST(test_log__text_lines)
{
    log_begin();
    pen_log(PEN_LOG_INFO, "plain %d", 1);
    pen_log_set_name("worker");
    pen_log(PEN_LOG_ERROR, "two\nlines \x1b[31m \"quoted\" \xFF");
    pen_log(PEN_LOG_DEBUG, "not shown");
    const char *text = log_end();
    int year, length = 0;
    char level[8];
    ck_assert_int_eq(sscanf(text, "%d-%*d-%*dT%*d:%*d:%*d.%*dZ %7s%n", &year, level, &length), 2);
    ck_assert(year >= 2024 && year < 3000);
    ck_assert_str_eq(level, "info");
    ck_assert_ptr_nonnull(strstr(text, "] plain 1\n"));
    ck_assert_ptr_nonnull(strstr(text, " error worker["));
    ck_assert_ptr_nonnull(strstr(text, "] two\\nlines \\u001b[31m \"quoted\" ?\n"));
    ck_assert_ptr_null(strstr(text, "not shown"));
}
END_TEST

START_TEST(test_log__json_lines)
{
    pen_log_set_json(true);
    pen_log_set_level(PEN_LOG_WARN);
    pen_log_set_name("a \"name\" that is too long");
    log_begin();
    pen_log(PEN_LOG_INFO, "not shown");
    pen_log(PEN_LOG_WARN, "say \"%s\" \\ \t \xC3\xA9\xE2\x80\xAE", "x");
    const char *text = log_end();
    ck_assert_int_eq(strncmp(text, "{\"time\":\"20", 11), 0);
    ck_assert_ptr_nonnull(
        strstr(text, "\"level\":\"warn\",\"process\":\"a \\\"name\\\" that i\","));
    ck_assert_ptr_nonnull(
        strstr(text, ",\"message\":\"say \\\"x\\\" \\\\ \\u0009 \xC3\xA9\\u202e\"}\n"));
    ck_assert_ptr_eq(strchr(text, '\n'), strrchr(text, '\n'));
}
END_TEST

START_TEST(test_log__fields_name_the_job)
{
    const struct pen_log_about all = {.job = "01-ab",
                                      .request = "r.1_x",
                                      .batch = 12,
                                      .attempt = 3},
                               none = {0};
    const struct pen_log_about odd = {.job = "a b", .request = "x\"y", .batch = 7};
    char longer[66];
    memset(longer, 'a', 65);
    longer[65] = '\0';
    const struct pen_log_about far = {.job = longer, .request = longer + 1};
    log_begin();
    pen_log_about(PEN_LOG_INFO, &all, "text %d", 1);
    pen_log_about(PEN_LOG_INFO, &none, "text %d", 2);
    pen_log_about(PEN_LOG_INFO, &odd, "text %d", 3);
    pen_log_about(PEN_LOG_INFO, &far, "text %d", 4);
    pen_log_set_json(true);
    pen_log_about(PEN_LOG_INFO, &all, "json");
    pen_log_about(PEN_LOG_DEBUG, &all, "not shown");
    const char *text = log_end();
    ck_assert_ptr_nonnull(strstr(text, "] text 1 job=01-ab batch=12 attempt=3 request=r.1_x\n"));
    ck_assert_ptr_nonnull(strstr(text, "] text 2\n"));
    ck_assert_ptr_nonnull(strstr(text, "] text 3 batch=7\n"));
    ck_assert_ptr_nonnull(strstr(text, "] text 4 request=aaaa"));
    ck_assert_ptr_nonnull(strstr(text, ",\"job\":\"01-ab\",\"batch\":12,\"attempt\":3,"
                                       "\"request\":\"r.1_x\",\"message\":\"json\"}\n"));
    ck_assert_ptr_null(strstr(text, "not shown"));
}
END_TEST

START_TEST(test_log__long_messages_are_cut_to_one_line)
{
    static char longer[20000];
    memset(longer, '\x01', sizeof longer - 1); /* six bytes each when escaped */
    for (int json = 0; json < 2; json++) {
        pen_log_set_json(json);
        log_begin();
        pen_log(PEN_LOG_INFO, "%s", longer);
        const char *text = log_end();
        ck_assert_uint_le(strlen(text), 4096);
        ck_assert_uint_ge(strlen(text), 3000);
        ck_assert_ptr_eq(strchr(text, '\n'), text + strlen(text) - 1);
        ck_assert(!json || strcmp(text + strlen(text) - 3, "\"}\n") == 0);
    }
}
END_TEST

START_TEST(test_log__keeps_errno)
{
    log_begin();
    errno = ENOSPC;
    pen_log(PEN_LOG_INFO, "x");
    int kept = errno;
    log_end();
    ck_assert_int_eq(kept, ENOSPC);
}
END_TEST

static void *chatter(void *letter)
{
    char word[201];
    memset(word, *(const char *)letter, sizeof word - 1);
    word[sizeof word - 1] = '\0';
    for (int i = 0; i < 300; i++)
        pen_log(PEN_LOG_INFO, "%s", word);
    return NULL;
}

START_TEST(test_log__lines_of_threads_do_not_mix)
{
    pthread_t thread[4];
    char letters[] = "abcd";
    log_begin();
    fcntl(STDERR_FILENO, F_SETFL, O_APPEND);
    for (int i = 0; i < 4; i++)
        ck_assert_int_eq(pthread_create(&thread[i], NULL, chatter, &letters[i]), 0);
    for (int i = 0; i < 4; i++)
        pthread_join(thread[i], NULL);
    const char *text = log_end();
    int lines = 0;
    for (const char *at = text; *at; lines++) {
        const char *end = strchr(at, '\n'), *word = strstr(at, "] ");
        ck_assert(end && word && end - word == 202);
        ck_assert_uint_eq(strspn(word + 2, (char[]){word[2], '\0'}), 200);
        at = end + 1;
    }
    ck_assert_int_eq(lines, 4 * 300);
}
END_TEST

/* Reads a pipe to its end. */
static void *read_all(void *user)
{
    static char text[1 << 21];
    const int *fd = user;
    size_t used = 0;
    ssize_t got;
    while ((got = read(*fd, text + used, sizeof text - 1 - used)) > 0)
        used += (size_t)got;
    return text;
}

/* A call waits for the thread for a second, or not at all once it has ended. */
static void end_writer(void)
{
    enum { CALLS = 60 };
    for (int i = 0; i < CALLS; i++)
        pen_log_writer_stop();
}

/* Nobody reads standard error: lines are logged all the same, and end of the thread does not wait
 * for long. Once somebody reads, each line was written or is counted as lost. */
START_TEST(test_log__thread_keeps_callers_from_waiting)
{
    enum { LINES = 20000 };
    int ends[2];
    pthread_t reader;
    void *text;
    fflush(stderr);
    saved = dup(STDERR_FILENO);
    ck_assert(pipe(ends) == 0 && dup2(ends[1], STDERR_FILENO) >= 0);
    ck_assert(pen_log_writer_start());
    for (int i = 0; i < LINES; i++)
        pen_log(PEN_LOG_INFO, "line %d", i);
    pen_log_writer_stop();
    ck_assert_int_eq(pthread_create(&reader, NULL, read_all, &ends[0]), 0);
    end_writer();
    pen_log(PEN_LOG_INFO, "line %d", LINES); /* written here: the thread has ended */
    dup2(saved, STDERR_FILENO);
    close(saved);
    close(ends[1]);
    pthread_join(reader, &text);
    close(ends[0]);
    int written = 0, last = -1;
    unsigned long long lost = 0;
    for (char *at = text, *end; *at; at = end + 1) {
        int number;
        unsigned long long now;
        const char *message = strstr(at, "] ");
        end = strchr(at, '\n');
        ck_assert(end && message && message < end);
        if (sscanf(message, "] line %d", &number) == 1) {
            ck_assert_int_eq(number, last + 1 + (int)lost * (number == LINES));
            last = number;
            written++;
        } else {
            ck_assert_int_eq(sscanf(message, "] %llu lines of the log were lost", &now), 1);
            lost += now;
        }
    }
    ck_assert_int_gt(written, 1000);
    ck_assert_uint_gt(lost, 0);
    ck_assert_uint_eq((unsigned long long)written + lost, LINES + 1);
}
END_TEST

START_TEST(test_log__thread_is_of_its_process_only)
{
    log_begin();
    fcntl(STDERR_FILENO, F_SETFL, O_APPEND);
    ck_assert(pen_log_writer_start());
    pen_log(PEN_LOG_INFO, "parent");
    const pid_t child = fork();
    if (child == 0) {
        pen_log(PEN_LOG_INFO, "child");
        _exit(0);
    }
    ck_assert_int_eq(waitpid(child, NULL, 0), child);
    end_writer();
    const char *text = log_end();
    ck_assert_ptr_nonnull(strstr(text, "] parent\n"));
    ck_assert_ptr_nonnull(strstr(text, "] child\n"));
}
END_TEST

START_TEST(test_log__ring_keeps_the_last_lines_of_every_level)
{
    static struct pen_log_ring ring;
    char last[512], small[60];
    pen_log_set_level(PEN_LOG_ERROR);
    pen_log_set_ring(&ring);
    pen_log_ring_last(&ring, 3, last, sizeof last);
    ck_assert_str_eq(last, "");
    pen_log(PEN_LOG_DEBUG, "line 1");
    pen_log_ring_last(&ring, 3, last, sizeof last);
    ck_assert_ptr_nonnull(strstr(last, "line 1\n"));
    for (int i = 2; i <= 1000; i++)
        pen_log(PEN_LOG_DEBUG, "line %d", i);
    pen_log_ring_last(&ring, 3, last, sizeof last);
    ck_assert_ptr_null(strstr(last, "line 997\n"));
    const char *line = strstr(last, "line 998\n");
    ck_assert(line && strstr(line, "line 999\n") && strstr(line, "line 1000\n"));
    ck_assert(last[0] == '2' && last[strlen(last) - 1] == '\n');
    pen_log_ring_last(&ring, 3, small, sizeof small); /* fits one line only */
    ck_assert(small[0] == '2' && strstr(small, "line 1000\n") && !strstr(small, "line 999\n"));
    pen_log_set_ring(NULL);
    pen_log(PEN_LOG_DEBUG, "gone");
    pen_log_ring_last(&ring, 1, last, sizeof last);
    ck_assert_ptr_null(strstr(last, "gone"));
}
END_TEST

PEN_SUITE("log", test_log__ring_keeps_the_last_lines_of_every_level, test_log__text_lines,
          test_log__json_lines, test_log__fields_name_the_job,
          test_log__long_messages_are_cut_to_one_line, test_log__keeps_errno,
          test_log__lines_of_threads_do_not_mix, test_log__thread_keeps_callers_from_waiting,
          test_log__thread_is_of_its_process_only)
