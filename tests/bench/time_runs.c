/* SPDX-License-Identifier: MIT */
/* Times whole programs, interleaved, so that other load on the machine slows all alike.
 *
 * usage: time_runs RUNS < COMMANDS
 *
 * COMMANDS has a line for each command: a name, a tab, a command for the shell. Unless RUNS is 1,
 * each is first run once without timing. Then all of them run in turn, RUNS times. Writes a JSON
 * array with a member for each command: name, the medians wall_ms (by the clock) and cpu_ms (of
 * processor time, which other load changes less), and the times of all runs. Fails if a command
 * fails. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "base/clock.h"
#include "bench/median.h"

enum { COMMANDS_MAX = 1000, RUNS_MAX = 100 };

struct command {
    char *name, *text;
    double wall[RUNS_MAX], cpu[RUNS_MAX];
};

static double ms_of(struct timeval t)
{
    return (double)t.tv_sec * 1e3 + (double)t.tv_usec / 1e3;
}

/* Runs a command; its output goes nowhere unless it fails. */
static void run(struct command *c, int number)
{
    int64_t start = pen_clock_ns();
    pid_t child = fork();
    if (child == 0) {
        execl("/bin/sh", "sh", "-c", c->text, (char *)NULL);
        _exit(127);
    }
    struct rusage used;
    int status;
    if (child < 0 || wait4(child, &status, 0, &used) != child || status != 0) {
        fprintf(stderr, "time_runs: %s failed: %s\n", c->name, c->text);
        exit(1);
    }
    if (number < 0)
        return;
    c->wall[number] = (double)(pen_clock_ns() - start) / 1e6;
    c->cpu[number] = ms_of(used.ru_utime) + ms_of(used.ru_stime);
}

static double median(const double *times, int runs)
{
    double sorted[RUNS_MAX];
    memcpy(sorted, times, (size_t)runs * sizeof *times);
    return bench_median(sorted, runs);
}

static void put_times(const char *key, const double *times, int runs)
{
    printf(", \"%s_ms\": %.3f, \"%s_ms_of_runs\": [", key, median(times, runs), key);
    for (int i = 0; i < runs; i++)
        printf("%s%.3f", i ? ", " : "", times[i]);
    printf("]");
}

static int read_commands(struct command *command)
{
    char line[4096];
    int count = 0;
    while (count < COMMANDS_MAX && fgets(line, sizeof line, stdin)) {
        line[strcspn(line, "\n")] = 0;
        char *tab = strchr(line, '\t');
        if (!tab)
            continue;
        *tab = 0;
        command[count].name = strdup(line);
        command[count].text = strdup(tab + 1);
        if (!command[count].name || !command[count].text)
            exit(1);
        count++;
    }
    return count;
}

int main(int argc, char **argv)
{
    static struct command command[COMMANDS_MAX];
    int runs = argc == 2 ? atoi(argv[1]) : 0;
    if (runs < 1 || runs > RUNS_MAX) {
        fprintf(stderr, "usage: time_runs RUNS < COMMANDS   (1 to %d runs)\n", RUNS_MAX);
        return 2;
    }
    int count = read_commands(command);
    for (int r = runs > 1 ? -1 : 0; r < runs; r++) {
        for (int i = 0; i < count; i++)
            run(&command[i], r);
        fprintf(stderr, r < 0 ? "warm-up done\n" : "run %d of %d done\n", r + 1, runs);
    }
    for (int i = 0; i < count; i++) {
        printf("%s{\"name\": \"%s\"", i ? ",\n " : "[", command[i].name);
        put_times("wall", command[i].wall, runs);
        put_times("cpu", command[i].cpu, runs);
        printf("}");
    }
    printf("]\n");
    return 0;
}
