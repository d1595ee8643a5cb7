/* SPDX-License-Identifier: MIT */
#include "cmd/daemon/fault_injection.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum kind { SEGV, ABORT, EXIT, KILL, ALLOC, HANG, KIND_COUNT };

static const char *const kinds[KIND_COUNT] = {
    [SEGV] = "segv", [ABORT] = "abort", [EXIT] = "exit",
    [KILL] = "kill", [ALLOC] = "alloc", [HANG] = "hang",
};

/* Allocates until a limit is reached, then frees everything. It touches no page, so the machine's
 * memory does not fill. */
static void take_all_memory(void)
{
    enum { PIECES = 1 << 14 };
    void **piece = malloc(PIECES * sizeof *piece);
    int count = 0;
    while (piece && count < PIECES && (piece[count] = malloc((size_t)64 << 20)))
        count++;
    while (count > 0)
        free(piece[--count]);
    free(piece);
}

static bool pixel(void *user, int x, int y)
{
    const struct pen_fault_hook *fault = user;
    volatile int *volatile null = NULL; /* volatile: hides the value from the compiler */
    if (x != fault->x || y != fault->y)
        return true;
    switch ((enum kind)fault->kind) {
    case SEGV:
        *null = 0;
        break;
    case ABORT:
        abort();
    case EXIT:
        _exit(1);
    case KILL:
        kill(getpid(), SIGKILL);
        break;
    case ALLOC:
        take_all_memory();
        return false;
    case HANG:
        for (;;)
            pause();
    case KIND_COUNT:
        break;
    }
    return true;
}

static bool wanted(void *user, const char *job_name)
{
    const struct pen_fault_hook *fault = user;
    return !fault->name || (job_name && strcmp(fault->name, job_name) == 0);
}

bool pen_fault_parse(const char *text, struct pen_fault_hook *hook, struct pen_status *st)
{
    char kind[8] = "";
    int end = 0;
    *hook = (struct pen_fault_hook){.calls = {.wanted = wanted, .pixel = pixel, .user = hook}};
    bool ok = sscanf(text, "%7[a-z]@%d,%d%n", kind, &hook->x, &hook->y, &end) == 3;
    hook->name = ok && text[end] == '@' ? text + end + 1 : NULL;
    for (hook->kind = 0; ok && hook->kind < KIND_COUNT; hook->kind++) {
        if (strcmp(kind, kinds[hook->kind]) == 0 && (hook->name || !text[end]))
            return true;
    }
    return pen_fail(st, PEN_USAGE, "the fault to test with is \"%s\", not KIND@X,Y[@NAME]", text);
}
