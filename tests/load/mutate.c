/* SPDX-License-Identifier: MIT */
/* Sends mutated requests (requests.h) to a server, on several connections at once.
 *
 *     mutate PORT SECONDS [SEED [JOB [TOKEN]]]
 *         JOB is the id of a job, TOKEN a client's token. Prints the number of connections; exit 1
 *         if the server is gone. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "load/cases.h"
#include "load/client.h"
#include "load/requests.h"

enum { CLIENTS = 8, QUIET_MS = 20, REFUSED_MAX = 50 };

static struct {
    int port;
    double until;
    struct load_names names;
    atomic_int next_seed, connections, refused;
    atomic_bool gone;
} all;

/* Sends a text in up to four pieces. */
static void send_pieces(int fd, const struct load_text *text, struct random *random)
{
    size_t sent = 0;
    for (int i = 0; i < 4 && sent < text->bytes; i++) {
        size_t left = text->bytes - sent;
        size_t piece =
            i == 3 || random_below(random, 3) ? left : 1 + random_below(random, (uint32_t)left);
        if (!load_send(fd, text->data + sent, piece))
            return;
        sent += piece;
    }
}

static void *send_requests(void *arg)
{
    static _Thread_local struct load_text text;
    char answer[100];
    struct random random = random_begin((uint64_t)atomic_fetch_add(&all.next_seed, 1));
    int refused = 0; /* one after the other */
    (void)arg;
    while (load_seconds() < all.until && refused < REFUSED_MAX) {
        int fd = load_try(all.port, 0);
        if (fd < 0) {
            refused++;
            atomic_fetch_add(&all.refused, 1);
            nanosleep(&(struct timespec){.tv_nsec = 200000000}, NULL);
            continue;
        }
        refused = 0;
        load_mutate(&text, &all.names, &random);
        send_pieces(fd, &text, &random);
        load_read(fd, QUIET_MS, NULL, answer, sizeof answer);
        close(fd);
        atomic_fetch_add(&all.connections, 1);
    }
    if (refused == REFUSED_MAX)
        atomic_store(&all.gone, true);
    return NULL;
}

static bool is_alive(void)
{
    char answer[1000] = "";
    int fd = load_try(all.port, 0);
    if (fd < 0)
        return false;
    load_send(fd, LOAD_GOOD, strlen(LOAD_GOOD));
    load_read(fd, 10000, "\r\n\r\n", answer, sizeof answer);
    close(fd);
    return load_status(answer, NULL) == 200;
}

int main(int argc, char **argv)
{
    pthread_t thread[CLIENTS];
    if (argc < 3 || argc > 6) {
        fprintf(stderr, "usage: mutate PORT SECONDS [SEED [JOB [TOKEN]]]\n");
        return 2;
    }
    all.port = atoi(argv[1]);
    all.until = load_seconds() + atof(argv[2]);
    all.next_seed = argc > 3 ? atoi(argv[3]) : 1;
    all.names.job = argc > 4 ? argv[4] : "x";
    all.names.token = argc > 5 ? argv[5] : "pen_x";
    for (int i = 0; i < CLIENTS; i++) {
        if (pthread_create(&thread[i], NULL, send_requests, NULL) != 0)
            return 2;
    }
    for (int i = 0; i < CLIENTS; i++)
        pthread_join(thread[i], NULL);
    printf("%d connections, %d refused\n", atomic_load(&all.connections),
           atomic_load(&all.refused));
    if (!atomic_load(&all.gone) && is_alive())
        return 0;
    printf("the server is gone\n");
    return 1;
}
