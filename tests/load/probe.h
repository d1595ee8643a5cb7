/* SPDX-License-Identifier: MIT */
/* Good requests beside a load, each on a connection of its own, and the times of their answers. */
#ifndef TESTS_LOAD_PROBE_H
#define TESTS_LOAD_PROBE_H

struct probe;

/* Starts a thread that asks for a path every `every_ms`. Ends the program if it cannot. */
struct probe *probe_start(int port, const char *path, int every_ms);

struct probe_result {
    int count, failed; /* failed: no answer, or none of status 200 */
    double p50_ms, p99_ms, most_ms;
};

/* Ends the thread and frees the probe. */
struct probe_result probe_stop(struct probe *probe);

#endif
