/* SPDX-License-Identifier: MIT */
/* The calling thread's floating-point environment and locale, while the library works in it. */
#include "embed/internal/embed.h"

void pen_embed_enter(struct pen_embed_caller *caller)
{
    fegetenv(&caller->environment);
    fesetenv(FE_DFL_ENV);
    caller->plain = newlocale(LC_ALL_MASK, "C", (locale_t)0);
    caller->locale = uselocale(caller->plain);
}

void pen_embed_leave(const struct pen_embed_caller *caller)
{
    uselocale(caller->locale);
    if (caller->plain)
        freelocale(caller->plain);
    fesetenv(&caller->environment);
}
