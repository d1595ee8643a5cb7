/* SPDX-License-Identifier: MIT */
#include "fault.h"

#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

enum kind { SEGV, ABORT, EXIT, KILL, ALLOC, HANG, KIND_COUNT };

static const char *const kinds[KIND_COUNT] = {"segv", "abort", "exit", "kill", "alloc", "hang"};

bool pen_fault_parse(const char *text, struct pen_fault *fault, struct pen_status *st)
{
    char kind[8] = "";
    int end = 0;
    bool ok = sscanf(text, "%7[a-z]@%d,%d%n", kind, &fault->x, &fault->y, &end) == 3;
    fault->name = ok && text[end] == '@' ? text + end + 1 : NULL;
    for (fault->kind = 0; ok && fault->kind < KIND_COUNT; fault->kind++) {
        if (strcmp(kind, kinds[fault->kind]) == 0 && (fault->name || !text[end]))
            return true;
    }
    return pen_fail(st, PEN_USAGE, "the fault to test with is \"%s\", not KIND@X,Y[@NAME]", text);
}

bool pen_fault_applies(const struct pen_fault *fault, const char *job_name)
{
    return !fault->name || (job_name && strcmp(fault->name, job_name) == 0);
}

static int *volatile null; /* volatile: the compiler must not know */

/* Address space is enough to reach a limit, so that a test does not fill the machine. */
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

bool pen_fault_at(const struct pen_fault *fault, int x, int y)
{
    if (x != fault->x || y != fault->y)
        return true;
    switch ((enum kind)fault->kind) {
    case SEGV:
        *(volatile int *)null = 0;
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
