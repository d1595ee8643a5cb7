/* SPDX-License-Identifier: MIT */
/* The n-th allocation of a request fails, and all after it, for every n. The client always gets the
 * right answer, a 503 or a closed connection. The server continues. */
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "support/alloc.h"
#include "support/server.h"
#include "support/suite.h"

enum { ROUNDS_MAX = 20000 };

/* Sends a request and reads the status, without allocating anything (libcheck's assertions do).
 * 0: the connection was closed without an answer; -1: silence. */
static int ask_quietly(int fd, const char *request)
{
    static char text[1 << 16];
    size_t used = 0;
    int status = -1;
    client_send(fd, request);
    while (used < sizeof text - 1) {
        ssize_t got = recv(fd, text + used, sizeof text - 1 - used, 0);
        if (got <= 0)
            return got == 0 || errno == ECONNRESET ? 0 : -1;
        used += (size_t)got;
        text[used] = '\0';
        if (strstr(text, "\r\n\r\n") && sscanf(text, "HTTP/1.1 %d", &status) == 1)
            return status;
    }
    return -1;
}

static int ask(const struct server *server, const char *request)
{
    int fd = server_connect(server);
    int status = ask_quietly(fd, request);
    close(fd);
    return status;
}

/* Whether every other thread of this process waits for something. */
static bool others_wait(void)
{
    char name[300], state = 'S';
    DIR *tasks = opendir("/proc/self/task");
    ck_assert(tasks != NULL);
    for (struct dirent *task; (task = readdir(tasks)) && state == 'S';) {
        if (task->d_name[0] == '.' || atoi(task->d_name) == getpid())
            continue;
        snprintf(name, sizeof name, "/proc/self/task/%s/stat", task->d_name);
        FILE *stat = fopen(name, "r");
        if (!stat)
            continue; /* the thread has ended */
        if (fscanf(stat, "%*d (%*[^)]) %c", &state) != 1)
            state = '?';
        fclose(stat);
    }
    closedir(tasks);
    return state == 'S';
}

/* Waits until the server's threads have started. A sanitizer's runtime allocates in a new thread,
 * and ends the process if it cannot. */
static void wait_for_threads(void)
{
    for (int quiet = 0, tries = 0; quiet < 3; tries++) {
        ck_assert_int_lt(tries, 3000);
        quiet = others_wait() ? quiet + 1 : 0;
        usleep(10000);
    }
}

static void fail_every_allocation(const char *request, int good)
{
    struct server server;
    server_start(&server, &(struct server_options){0});
    ck_assert_int_eq(ask(&server, request), good);
    wait_for_threads();
    int refusals = 0;
    for (long n = 0;; n++) {
        ck_assert_int_lt(n, ROUNDS_MAX);
        int fd = server_connect(&server);
        alloc_fail_after(n);
        int status = ask_quietly(fd, request);
        bool refused = alloc_succeed();
        close(fd);
        ck_assert_msg(status == good || status == 503 || status == 0, "allocation %ld: %d", n,
                      status);
        refusals += status != good;
        if (!refused)
            break;
    }
    ck_assert_int_gt(refusals, 0);
    ck_assert_int_eq(ask(&server, request), good);
    server_stop(&server);
}

START_TEST(test_memory__of_a_refusal)
{
    fail_every_allocation("GET /nowhere HTTP/1.1\r\nHost: localhost\r\n\r\n", 404);
}
END_TEST

START_TEST(test_memory__of_a_file)
{
    fail_every_allocation("GET /v1/scenes HTTP/1.1\r\nHost: localhost\r\n\r\n", 200);
}
END_TEST

START_TEST(test_memory__of_a_list)
{
    fail_every_allocation("GET /v1/jobs?state=queued HTTP/1.1\r\nHost: localhost\r\n\r\n", 200);
}
END_TEST

START_TEST(test_memory__of_a_bad_body)
{
    fail_every_allocation("POST /v1/validate HTTP/1.1\r\nHost: localhost\r\n"
                          "Content-Length: 33\r\n\r\n{\"format\": \"penumbra-scene/1\", 5}\n",
                          400);
}
END_TEST

START_TEST(test_memory__of_a_submit)
{
    fail_every_allocation("POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: 28\r\n\r\n"
                          "{\"scene\": \"builtin:spheres\"}",
                          202);
}
END_TEST

PEN_SUITE("memory", test_memory__of_a_refusal, test_memory__of_a_file, test_memory__of_a_list,
          test_memory__of_a_bad_body, test_memory__of_a_submit)
