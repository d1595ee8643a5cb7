/* SPDX-License-Identifier: MIT */
#include "load/probe.h"

#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "load/client.h"

enum { TIMES_MAX = 100000, ANSWER_S = 20 };

struct probe {
    pthread_t thread;
    atomic_bool stop;
    int port, every_ms;
    char path[200];
    int count, failed;
    double ms[TIMES_MAX];
};

static bool ask(const struct probe *probe)
{
    char text[400], answer[4096];
    const struct timeval limit = {.tv_sec = ANSWER_S};
    int fd = load_connect(probe->port, 0);
    setsockopt(fd, SOL_SOCKET, SO_RCVTIMEO, &limit, sizeof limit);
    snprintf(text, sizeof text, "GET %s HTTP/1.1\r\nHost: localhost\r\n\r\n", probe->path);
    (void)!send(fd, text, strlen(text), MSG_NOSIGNAL);
    ssize_t got = recv(fd, answer, sizeof answer, 0);
    close(fd);
    return got > 12 && memcmp(answer + 9, "200", 3) == 0;
}

static void *run(void *arg)
{
    struct probe *probe = arg;
    const struct timespec pause = {.tv_nsec = probe->every_ms * 1000000L};
    while (!atomic_load(&probe->stop) && probe->count < TIMES_MAX) {
        int64_t begun = pen_clock_ns();
        probe->failed += !ask(probe);
        probe->ms[probe->count++] = (double)(pen_clock_ns() - begun) * 1e-6;
        nanosleep(&pause, NULL);
    }
    return NULL;
}

struct probe *probe_start(int port, const char *path, int every_ms)
{
    struct probe *probe = calloc(1, sizeof *probe);
    if (!probe)
        exit(2);
    probe->port = port;
    probe->every_ms = every_ms;
    snprintf(probe->path, sizeof probe->path, "%s", path);
    if (pthread_create(&probe->thread, NULL, run, probe) != 0)
        exit(2);
    return probe;
}

static int compare(const void *a, const void *b)
{
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

struct probe_result probe_stop(struct probe *probe)
{
    atomic_store(&probe->stop, true);
    pthread_join(probe->thread, NULL);
    struct probe_result result = {.count = probe->count, .failed = probe->failed};
    if (probe->count > 0) {
        qsort(probe->ms, (size_t)probe->count, sizeof probe->ms[0], compare);
        result.p50_ms = probe->ms[probe->count / 2];
        result.p99_ms = probe->ms[probe->count * 99 / 100];
        result.most_ms = probe->ms[probe->count - 1];
    }
    free(probe);
    return result;
}
