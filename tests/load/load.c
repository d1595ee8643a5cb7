/* SPDX-License-Identifier: MIT */
/* Loads a daemon on the loopback interface in ways that could silence it, and measures how other
 * clients are served meanwhile. Prints lines `name value`, which the scripts beside it judge.
 *
 *   load crowd PORT PID JOB PICTURE PERCENT SECONDS
 *       Connections that hold resources without using them. At 100 per cent: 5000 idle ones, 1000
 *       that trickle, 1000 that vanish, 512 polls, 500 event streams of which half vanish, 100
 *       slow readers. After SECONDS the clients leave. Measures how long the process PID keeps
 *       their descriptors.
 *
 *   load half PORT COUNT SECONDS
 *       Halves of requests: COUNT connections, opened again whenever the server closes one.
 *
 *   load bad PORT PER_SECOND SECONDS
 *       Bad requests, each on its own connection. With port 0 the same load goes to a server of
 *       this program that only accepts and closes.
 *
 *   load post PORT FILE CLIENTS SECONDS
 *       Clients that post a file to /v1/jobs again and again.
 *
 *   load ask PORT PATH SECONDS
 *       Only the good requests. */
#include <arpa/inet.h>
#include <dirent.h>
#include <errno.h>
#include <netinet/in.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/time.h>
#include <time.h>
#include <unistd.h>

#include "base/clock.h"
#include "load/client.h"
#include "load/crowd.h"
#include "load/probe.h"

enum { PROBE_MS = 5, TRICKLE_MS = 9000, LEAVE_S = 60 };

static void print_probe(const char *name, struct probe *probe)
{
    struct probe_result result = probe_stop(probe);
    printf("%s-count %d\n%s-failed %d\n%s-p50-ms %.2f\n%s-p99-ms %.2f\n%s-most-ms %.2f\n", name,
           result.count, name, result.failed, name, result.p50_ms, name, result.p99_ms, name,
           result.most_ms);
}

/* Open descriptors of a process. */
static int count_files(int pid)
{
    char path[64];
    snprintf(path, sizeof path, "/proc/%d/fd", pid);
    DIR *folder = opendir(path);
    int count = 0;
    while (folder && readdir(folder))
        count++;
    if (folder)
        closedir(folder);
    return count;
}

static double resident_mib(int pid)
{
    char path[64], line[200];
    long kib = 0;
    snprintf(path, sizeof path, "/proc/%d/status", pid);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) {
        if (sscanf(line, "VmRSS: %ld", &kib) == 1)
            break;
    }
    if (file)
        fclose(file);
    return (double)kib / 1024;
}

/* Serves the crowd until the process has at most `files` descriptors; returns the seconds. */
static double wait_for_files(struct crowd *crowd, int pid, int files)
{
    int64_t begun = pen_clock_ns();
    double seconds = 0;
    while (count_files(pid) > files && seconds < LEAVE_S) {
        crowd_run(crowd, 100);
        seconds = (double)(pen_clock_ns() - begun) * 1e-9;
    }
    return seconds;
}

static int run_crowd(char **arg)
{
    static const int whole[MEMBER_KINDS] = {
        [MEMBER_IDLE] = 5000, [MEMBER_TRICKLE] = 1000, [MEMBER_VANISHED] = 1000,
        [MEMBER_POLL] = 512,  [MEMBER_STREAM] = 500,   [MEMBER_READER] = 100};
    const struct crowd_options options = {
        .port = atoi(arg[0]), .job = arg[2], .picture = arg[3], .trickle_ms = TRICKLE_MS};
    int pid = atoi(arg[1]), percent = atoi(arg[4]), seconds = atoi(arg[5]);
    int before = count_files(pid);
    struct crowd *crowd = crowd_new(&options);
    struct probe *health = probe_start(options.port, "/healthz", PROBE_MS);
    struct probe *job = probe_start(options.port, options.job, PROBE_MS);
    double most = 0;
    for (enum member_kind kind = 0; kind < MEMBER_KINDS; kind++)
        crowd_add(crowd, kind, whole[kind] * percent / 100, true);
    for (int i = 0; i < 4 * seconds; i++) {
        crowd_run(crowd, 250);
        double mib = resident_mib(pid);
        most = mib > most ? mib : most;
    }
    for (enum member_kind kind = 0; kind < MEMBER_KINDS; kind++) {
        if (whole[kind])
            printf("%s %d\n", member_names[kind], crowd_count(crowd, kind));
    }
    print_probe("health", health);
    print_probe("job", job);
    printf("resident-mib %.0f\n", most);
    int vanished = crowd_vanished(crowd);
    crowd_leave(crowd);
    printf("closed-freed-s %.1f\n", wait_for_files(crowd, pid, before + vanished));
    printf("vanished-freed-s %.1f\n", wait_for_files(crowd, pid, before + 4));
    printf("left %d\n", count_files(pid) - before);
    crowd_free(crowd);
    return 0;
}

static int run_half(char **arg)
{
    const struct crowd_options options = {.port = atoi(arg[0]), .trickle_ms = TRICKLE_MS};
    struct crowd *crowd = crowd_new(&options);
    struct probe *health = probe_start(options.port, "/healthz", PROBE_MS);
    crowd_add(crowd, MEMBER_TRICKLE, atoi(arg[1]), true);
    crowd_add(crowd, MEMBER_HALF, atoi(arg[1]), true);
    crowd_run(crowd, 1000 * atoi(arg[2]));
    print_probe("health", health);
    crowd_free(crowd);
    return 0;
}

/* Clients that do the same thing again and again. */
struct clients {
    int port, per_second, seconds;
    char *body;
    size_t body_bytes;
    atomic_int done, refused;
};

static void *send_bad(void *arg)
{
    static const char *const bad[] = {"GET /nowhere HTTP/1.1\r\nHost: localhost\r\n\r\n",
                                      "GET / HTTP/1.1\r\nHost : localhost\r\n\r\n",
                                      "\x16\x03\x01\x02\r\n\r\n",
                                      ("POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\n"
                                       "Content-Length: 2\r\n\r\n[]")};
    struct clients *clients = arg;
    char answer[4096];
    int64_t begun = pen_clock_ns(), each_ns = INT64_C(1000000000) / clients->per_second;
    for (int i = 0;; i++) {
        int64_t due = begun + i * each_ns, now = pen_clock_ns();
        if (now - begun > clients->seconds * INT64_C(1000000000))
            break;
        if (now < due)
            nanosleep(&(struct timespec){.tv_nsec = (long)((due - now) % 1000000000)}, NULL);
        int fd = load_connect(clients->port, 0);
        const struct linger reset = {.l_onoff = 1};
        setsockopt(fd, SOL_SOCKET, SO_LINGER, &reset, sizeof reset); /* leaves no TIME_WAIT */
        (void)!send(fd, bad[i % 4], strlen(bad[i % 4]), MSG_NOSIGNAL);
        atomic_fetch_add(&clients->refused, recv(fd, answer, sizeof answer, 0) > 12);
        atomic_fetch_add(&clients->done, 1);
        close(fd);
    }
    return NULL;
}

static void *post_file(void *arg)
{
    struct clients *clients = arg;
    char text[200], answer[4096];
    int64_t until = pen_clock_ns() + clients->seconds * INT64_C(1000000000);
    snprintf(text, sizeof text,
             "POST /v1/jobs HTTP/1.1\r\nHost: localhost\r\nContent-Length: %zu\r\n\r\n",
             clients->body_bytes);
    while (pen_clock_ns() < until) {
        int fd = load_connect(clients->port, 0);
        (void)!send(fd, text, strlen(text), MSG_NOSIGNAL);
        for (size_t sent = 0; sent < clients->body_bytes;) {
            ssize_t n = send(fd, clients->body + sent, clients->body_bytes - sent, MSG_NOSIGNAL);
            if (n <= 0)
                break;
            sent += (size_t)n;
        }
        ssize_t got = recv(fd, answer, sizeof answer, 0);
        atomic_fetch_add(&clients->refused, got < 12 || memcmp(answer + 9, "202", 3) != 0);
        atomic_fetch_add(&clients->done, 1);
        close(fd);
    }
    return NULL;
}

static void run_clients(struct clients *clients, void *(*work)(void *), int count)
{
    enum { CLIENTS_MAX = 64 };
    pthread_t thread[CLIENTS_MAX];
    int64_t begun = pen_clock_ns();
    int started = 0;
    while (started < count && started < CLIENTS_MAX &&
           pthread_create(&thread[started], NULL, work, clients) == 0)
        started++;
    for (int i = 0; i < started; i++)
        pthread_join(thread[i], NULL);
    printf("done %d\nper-second %.1f\n", atomic_load(&clients->done),
           atomic_load(&clients->done) / ((double)(pen_clock_ns() - begun) * 1e-9));
}

static void *accept_and_close(void *arg)
{
    const int listening = *(const int *)arg;
    for (;;)
        close(accept(listening, NULL, NULL));
    return NULL;
}

/* Starts a server that only accepts and closes. Returns its port. */
static int start_closer(void)
{
    static int listening;
    struct sockaddr_in address = {.sin_family = AF_INET, .sin_addr.s_addr = htonl(INADDR_LOOPBACK)};
    socklen_t bytes = sizeof address;
    pthread_t thread;
    listening = socket(AF_INET, SOCK_STREAM | SOCK_CLOEXEC, 0);
    if (bind(listening, (struct sockaddr *)&address, bytes) != 0 || listen(listening, 4096) != 0 ||
        getsockname(listening, (struct sockaddr *)&address, &bytes) != 0 ||
        pthread_create(&thread, NULL, accept_and_close, &listening) != 0)
        exit(2);
    pthread_detach(thread);
    return ntohs(address.sin_port);
}

static int run_bad(char **arg)
{
    enum { THREADS = 32 };
    struct clients clients = {.port = atoi(arg[0]),
                              .per_second = (atoi(arg[1]) + THREADS - 1) / THREADS,
                              .seconds = atoi(arg[2])};
    if (!clients.port) {
        clients.port = start_closer();
        run_clients(&clients, send_bad, THREADS);
        return 0;
    }
    struct probe *health = probe_start(clients.port, "/healthz", PROBE_MS);
    run_clients(&clients, send_bad, THREADS);
    printf("answered %d\n", atomic_load(&clients.refused));
    print_probe("health", health);
    return 0;
}

static int run_post(char **arg)
{
    struct clients clients = {.port = atoi(arg[0]), .seconds = atoi(arg[3])};
    FILE *file = fopen(arg[1], "r");
    if (!file || fseek(file, 0, SEEK_END) != 0)
        return 2;
    clients.body_bytes = (size_t)ftell(file);
    clients.body = malloc(clients.body_bytes);
    rewind(file);
    if (!clients.body || fread(clients.body, 1, clients.body_bytes, file) != clients.body_bytes)
        return 2;
    fclose(file);
    struct probe *list = probe_start(clients.port, "/v1/jobs?limit=5", PROBE_MS);
    struct probe *ready = probe_start(clients.port, "/readyz", PROBE_MS);
    run_clients(&clients, post_file, atoi(arg[2]));
    printf("refused %d\n", atomic_load(&clients.refused));
    print_probe("list", list);
    print_probe("ready", ready);
    free(clients.body);
    return 0;
}

static int run_ask(char **arg)
{
    struct probe *probe = probe_start(atoi(arg[0]), arg[1], PROBE_MS);
    sleep((unsigned)atoi(arg[2]));
    print_probe("ask", probe);
    return 0;
}

static void allow_many_files(void)
{
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) == 0) {
        files.rlim_cur = files.rlim_max;
        setrlimit(RLIMIT_NOFILE, &files);
    }
}

int main(int argc, char **argv)
{
    static const struct {
        const char *name;
        int args;
        int (*run)(char **arg);
    } modes[] = {{"crowd", 6, run_crowd},
                 {"half", 3, run_half},
                 {"bad", 3, run_bad},
                 {"post", 4, run_post},
                 {"ask", 3, run_ask}};
    allow_many_files();
    for (size_t i = 0; i < sizeof modes / sizeof modes[0]; i++) {
        if (argc == modes[i].args + 2 && strcmp(argv[1], modes[i].name) == 0)
            return modes[i].run(argv + 2);
    }
    fprintf(stderr, "usage: see the beginning of tests/load/load.c\n");
    return 2;
}
