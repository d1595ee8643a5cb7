/* SPDX-License-Identifier: MIT */
/* The functions of libcheck that tests/support needs, for a program that is no test. A failed
 * assertion ends the process, which its parent counts. */
#include <check.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

void _mark_point(const char *file, int line)
{
    (void)file, (void)line;
}

void _ck_assert_failed(const char *file, int line, const char *expr, const char *msg, ...)
{
    va_list args;
    va_start(args, msg);
    fprintf(stderr, "%s:%d: %s: ", file, line, expr);
    if (msg)
        vfprintf(stderr, msg, args);
    fputc('\n', stderr);
    va_end(args);
    abort();
}
