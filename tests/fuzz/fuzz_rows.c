/* SPDX-License-Identifier: MIT */
/* Any bytes as texts of the store. The first byte selects a job's request, or the statistics of its
 * batches, one a line. */
#include "fuzz/fuzz.h"
#include "jobs/internal/stats.h"
#include "jobs/internal/stored_request.h"

static void check_request(const char *text)
{
    struct pen_stored_request request;
    struct pen_status st = {0};
    if (!pen_stored_request_read(text, &request, &st)) {
        must(st.code == PEN_STORAGE);
        return;
    }
    for (int i = 0; i < request.view_count && i < 100; i++)
        pen_stored_request_view(&request, i);
    must(request.layers & 1U << PEN_LAYER_BEAUTY);
    must(!request.audit || (request.audit_pixels > 0 && request.audit_threshold > 0));
    must(!(request.budget_s < 0));
    pen_stored_request_find_view(&request, "main");
    pen_stored_request_release(&request);
}

static void check_stats(char *text)
{
    enum { BATCHES = 8 };
    struct pen_batch_stats batch[BATCHES];
    const struct pen_job_record job = {
        .id = "x", .started_ms = 2, .queue_us = 1000, .elapsed_us = 8000};
    struct pen_status st = {0};
    size_t count = 0;
    for (char *next = text; next && count < BATCHES; count++) {
        batch[count] = (struct pen_batch_stats){.stats = next, .commit_us = 5000};
        next = strchr(next, '\n');
        if (next)
            *next++ = '\0';
    }
    json_t *stats = pen_stats_of_batches(batch, count, &job, &st);
    must(stats ? json_is_object(json_object_get(stats, "rays")) : st.code == PEN_STORAGE);
    json_decref(stats);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    if (size < 1)
        return 0;
    char *text = fuzz_text(data + 1, size - 1);
    if (data[0] == 'r')
        check_request(text);
    else
        check_stats(text);
    free(text);
    return 0;
}
