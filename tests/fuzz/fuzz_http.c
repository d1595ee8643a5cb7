/* SPDX-License-Identifier: MIT */
/* Any bytes as the head of a request. Lines are, in this order: the target, Host, Origin,
 * Content-Type, If-None-Match, Accept, Range, a number. */
#include "fuzz/fuzz.h"
#include "http/message.h"

enum { TARGET, HOST, ORIGIN, TYPE, MATCH, ACCEPT, RANGE, NUMBER, LINES };

static void split(char *text, char *lines[LINES])
{
    for (int i = 0; i < LINES; i++) {
        lines[i] = text;
        text += strcspn(text, "\n");
        if (*text)
            *text++ = '\0';
    }
}

static void check_target(const char *raw)
{
    static const char *const templates[] = {"/", "/v1/jobs", "/v1/jobs/{id}", "/v1/jobs/{id}/image",
                                            "/v1/scenes/{name}"};
    struct pen_target target;
    struct pen_status st = {0};
    const char *arg;
    if (pen_target_parse(raw, &target, &st)) {
        must(target.segment_count >= 0 && target.param_count <= PEN_PARAMS_MAX);
        for (int i = 0; i < target.param_count; i++)
            must(pen_target_param(&target, target.param[i].name) != NULL);
        for (size_t i = 0; i < sizeof templates / sizeof templates[0]; i++) {
            if (pen_target_matches(&target, templates[i], &arg))
                must((arg != NULL) == (strchr(templates[i], '{') != NULL));
        }
    } else {
        must(st.code != PEN_OK && st.msg[0]);
    }
    pen_target_release(&target);
}

static void check_range(const char *range)
{
    static const uint64_t sizes[] = {0, 1, 1000, UINT64_MAX};
    for (size_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
        uint64_t first = 0, count = 0;
        if (pen_range_parse(range, sizes[i], &first, &count) == PEN_RANGE_PART)
            must(count > 0 && first < sizes[i] && count <= sizes[i] - first);
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    static const char *const types[] = {"text/html", "application/json", "text/csv"};
    char *text = fuzz_text(data, size), *line[LINES];
    long number = 0;
    split(text, line);
    check_target(line[TARGET]);
    if (pen_host_is_loopback(line[HOST]))
        must(strpbrk(line[HOST], "l1[") != NULL);
    pen_origin_is_host(line[ORIGIN], "http", line[HOST]);
    pen_origin_listed(line[HOST], line[ORIGIN]);
    must(pen_media_parse(line[TYPE]) <= PEN_MEDIA_OTHER);
    must(pen_etag_listed("*", "\"a\""));
    pen_etag_listed(line[MATCH], "\"a\"");
    int chosen = pen_accept_choose(line[ACCEPT], types, 3);
    must(chosen >= -1 && chosen < 3);
    check_range(line[RANGE]);
    if (pen_number_parse(line[NUMBER], 1, 500, &number))
        must(number >= 1 && number <= 500);
    free(text);
    return 0;
}
