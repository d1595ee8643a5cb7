/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/oom.h"

#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* Reads the number after "oom_kill " at the beginning of a line; -1 if there is none. */
static int64_t read_counter(const char *path)
{
    char line[256];
    int64_t count = -1;
    FILE *file = fopen(path, "re");
    while (file && count < 0 && fgets(line, sizeof line, file)) {
        if (sscanf(line, "oom_kill %" SCNd64, &count) != 1)
            count = -1;
    }
    if (file)
        fclose(file);
    return count;
}

/* Reads the counter of the control group. In /proc/self/cgroup the line "0::/PATH" names a group of
 * version 2, and "…:memory:/PATH" a group of version 1. */
static int64_t read_group(void)
{
    char line[1024], path[1200];
    int64_t count = -1;
    FILE *file = fopen("/proc/self/cgroup", "re");
    while (file && count < 0 && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = '\0';
        const char *memory = strstr(line, ":memory:");
        if (strncmp(line, "0::", 3) == 0)
            snprintf(path, sizeof path, "/sys/fs/cgroup%s/memory.events", line + 3);
        else if (memory)
            snprintf(path, sizeof path, "/sys/fs/cgroup/memory%s/memory.oom_control", memory + 8);
        else
            continue;
        count = read_counter(path);
    }
    if (file)
        fclose(file);
    return count;
}

int64_t pen_oom_kills(void)
{
    const char *test = getenv("PENUMBRA_TEST_OOM");
    if (test && *test)
        return read_counter(test);
    int64_t count = read_group();
    return count >= 0 ? count : read_counter("/proc/vmstat");
}
