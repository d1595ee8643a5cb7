/* SPDX-License-Identifier: MIT */
/* The part that `penumbra render --audit` and `penumbra audit` share. */
#ifndef PEN_CMD_CLIENT_AUDIT_OPTIONS_H
#define PEN_CMD_CLIENT_AUDIT_OPTIONS_H

#include <stdio.h>

#include "cmd/options.h"
#include "render/audit.h"

/* The options of an audit: the threshold, whose option has the name of the member, and the number
 * of pixels in audit_pixels. */
#define PEN_AUDIT_OPTIONS(values, member)                                                          \
    {.name = #member,                                                                              \
     .kind = PEN_OPTION_NUMBER,                                                                    \
     .offset = offsetof(values, member),                                                           \
     .value = "D",                                                                                 \
     .max = 1,                                                                                     \
     .help = "audit: count the pixels that are wrong by more than D, in displayed values from 0 "  \
             "to 1"},                                                                              \
    {                                                                                              \
        .name = "audit-pixels", .kind = PEN_OPTION_INT, .offset = offsetof(values, audit_pixels),  \
        .value = "N", .min = 1, .max = PEN_AUDIT_PIXELS_MAX,                                       \
        .help = "how many pixels an audit renders again, 600 by default"                           \
    }

/* Prints the result of an audit: a line, and a line for each cluster of wrong pixels. */
void pen_audit_print(const struct pen_audit *audit, const char *label, FILE *out);

#endif
