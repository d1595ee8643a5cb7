/* SPDX-License-Identifier: MIT */
/* Clients that begin a TLS handshake and send nothing more.
 *
 *     stall PORT COUNT SECONDS [PID]
 *         Prints how many connections were made, how many are open after SECONDS, and the
 *         processor time of the process PID meanwhile, in per cent of one processor. */
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <unistd.h>

#include "load/client.h"

/* A record of 512 bytes, in it the beginning of a ClientHello of 508 bytes. */
static const char hello[] = "\x16\x03\x01\x02\0\x01\0\x01\xfc\x03\x03\x01\x02\x03\x04\x05";

/* Seconds of user and system time: fields 14 and 15 of proc_pid_stat(5). */
static double processor_seconds(int pid)
{
    char path[64], text[1000] = "";
    unsigned long user = 0, kernel = 0;
    snprintf(path, sizeof path, "/proc/%d/stat", pid);
    FILE *file = fopen(path, "r");
    if (file) {
        (void)!fgets(text, sizeof text, file);
        fclose(file);
    }
    const char *name_end = strrchr(text, ')');
    if (!name_end || sscanf(name_end + 1, " %*c %*d %*d %*d %*d %*d %*u %*u %*u %*u %*u %lu %lu",
                            &user, &kernel) != 2) {
        fprintf(stderr, "stall: there is no process %d\n", pid);
        exit(2);
    }
    return (double)(user + kernel) / (double)sysconf(_SC_CLK_TCK);
}

static bool is_open(int fd)
{
    char byte;
    struct pollfd readable = {.fd = fd, .events = POLLIN};
    return fd >= 0 && (poll(&readable, 1, 0) == 0 || recv(fd, &byte, 1, MSG_PEEK) > 0);
}

int main(int argc, char **argv)
{
    if (argc < 4 || argc > 5) {
        fprintf(stderr, "usage: stall PORT COUNT SECONDS [PID]\n");
        return 2;
    }
    int port = atoi(argv[1]), count = atoi(argv[2]), pid = argc > 4 ? atoi(argv[4]) : getpid();
    unsigned seconds = (unsigned)atoi(argv[3]);
    int *fd = calloc((size_t)count, sizeof *fd), made = 0, open = 0;
    struct rlimit files;
    if (!fd || getrlimit(RLIMIT_NOFILE, &files) != 0)
        return 2;
    files.rlim_cur = files.rlim_max;
    setrlimit(RLIMIT_NOFILE, &files);
    for (int i = 0; i < count; i++) {
        fd[i] = load_try(port, 0);
        made += fd[i] >= 0 && load_send(fd[i], hello, sizeof hello - 1);
    }
    double before = processor_seconds(pid);
    sleep(seconds);
    double used = processor_seconds(pid) - before;
    for (int i = 0; i < count; i++)
        open += is_open(fd[i]);
    printf("made %d\nopen %d\n", made, open);
    if (argc > 4)
        printf("processor-percent %.2f\n", 100 * used / seconds);
    free(fd);
    return made < count;
}
