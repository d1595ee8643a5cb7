/* SPDX-License-Identifier: MIT */
/* Sends each request of cases.h between two good ones on one connection, and prints the answers:
 *     200+  answered, and the next request too         200.  answered, then closed (R: by a reset)
 *     cut   closed without an answer                   wait  no answer within 1.5 s
 *
 *     strict PORT          prints the table
 *     strict PORT check    fails unless the answers are those that the daemon must give
 *     strict PORT front    the same for a front, which may accept more chunk sizes and refuse a
 *                          long head with any 4xx */
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "load/cases.h"
#include "load/client.h"

enum { QUIET_MS = 1500, ANSWER_BYTES = 65536 };

struct outcome {
    int status, behind; /* of the request and of the request behind it; 0: none */
    enum load_end end;
};

static struct outcome send_case(int port, const struct load_case *item)
{
    static const char last[] = LOAD_GET LOAD_HOST "Connection: close\r\n\r\n";
    static char request[LOAD_CASE_MAX + sizeof last], answer[ANSWER_BYTES];
    struct outcome outcome = {0};
    int fd = load_connect(port, 0);
    load_send(fd, LOAD_GOOD, strlen(LOAD_GOOD));
    load_read(fd, QUIET_MS, "}", answer, sizeof answer);
    size_t bytes = load_case_write(item, request);
    memcpy(request + bytes, last, sizeof last - 1);
    load_send(fd, request, bytes + sizeof last - 1);
    outcome.end = load_read(fd, QUIET_MS, NULL, answer, sizeof answer);
    const char *rest = answer;
    outcome.status = load_status(rest, &rest);
    outcome.behind = load_status(rest, &rest);
    close(fd);
    return outcome;
}

static bool is_due(const struct load_case *item, struct outcome got, bool front)
{
    bool refused = got.status >= 400 || (!got.status && got.end != LOAD_OPEN);
    if (got.status == 500 || got.behind == 500)
        return false;
    switch (item->due) {
    case DUE_ANSWER:
        return got.status == 200;
    case DUE_ANY:
        return true;
    case DUE_REFUSAL:
        return refused;
    case DUE_SIZE:
        if (front && got.status == 200)
            return true;
        /* fall through */
    case DUE_END:
        return refused && got.behind != 200;
    case DUE_LONG:
        return refused && (front || got.status == 431 || got.status == 414 || !got.status);
    }
    return false;
}

static void print(const struct load_case *item, struct outcome got, bool due)
{
    char text[8];
    if (!got.status)
        snprintf(text, sizeof text, "%s", got.end == LOAD_OPEN ? "wait" : "cut");
    else
        snprintf(text, sizeof text, "%d%c%s", got.status % 1000, got.behind ? '+' : '.',
                 got.end == LOAD_RESET ? "R" : "");
    printf("%-24s%-8s%s\n", item->name, text, due ? "" : "wrong");
}

int main(int argc, char **argv)
{
    if (argc < 2 || argc > 3) {
        fprintf(stderr, "usage: strict PORT [check|front]\n");
        return 2;
    }
    bool judged = argc > 2, front = judged && strcmp(argv[2], "front") == 0;
    int wrong = 0;
    for (size_t i = 0; i < load_case_count; i++) {
        struct outcome got = send_case(atoi(argv[1]), &load_cases[i]);
        bool due = !judged || is_due(&load_cases[i], got, front);
        print(&load_cases[i], got, due);
        wrong += !due;
    }
    return wrong > 0;
}
