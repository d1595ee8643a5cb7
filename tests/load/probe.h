/* SPDX-License-Identifier: MIT */
/* Good requests during a load, each on its own connection, and the times of their answers. */
#ifndef TESTS_LOAD_PROBE_H
#define TESTS_LOAD_PROBE_H

struct probe;

/* Starts a thread that requests a path every `every_ms`. Ends the program if it cannot. */
struct probe *probe_start(int port, const char *path, int every_ms);

struct probe_result {
    int count, failed; /* failed: no answer, or a status other than 200 */
    double p50_ms, p99_ms, most_ms;
};

/* Ends the thread and frees the probe. */
struct probe_result probe_stop(struct probe *probe);

#endif
