/* SPDX-License-Identifier: MIT */
/* api/scene.schema.json accepts the same documents as the reader. tests/io/check_schema.py compares
 * both with an independent JSON Schema library. The documents are the corpus, and good scenes
 * changed at random places. */
#include <glob.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/scene_json.h"
#include "support/mutate.h"
#include "support/random.h"
#include "support/suite.h"

/* The python3 that Debian's package python3-jsonschema belongs to, which need not be the first in
 * PATH. */
#define CHECKER "/usr/bin/python3 tests/io/check_schema.py "

START_TEST(test_schema__agrees_with_the_reader_on_the_corpus)
{
    ck_assert_int_eq(system(CHECKER "corpus"), 0);
}
END_TEST

/* Writes one line with the document and the reader's errors. */
static void write_verdict(FILE *file, json_t *document)
{
    struct pen_limits limits = pen_limits_default();
    struct pen_arena *arena = pen_arena_new(0);
    struct pen_scene_desc desc;
    struct pen_errors errors = {0};
    bool ok = pen_scene_read(document, "", &limits, arena, &desc, &errors);
    ck_assert(ok == (errors.count == 0));
    json_t *messages = json_array();
    for (size_t i = 0; i < errors.count; i++) {
        char text[PEN_AT_BYTES + PEN_MSG_BYTES + 8];
        pen_status_describe(&errors.item[i], "", text, sizeof text);
        json_array_append_new(messages, json_string(text));
    }
    json_t *line = json_pack("{s:o, s:O}", "errors", messages, "document", document);
    ck_assert_int_eq(json_dumpf(line, file, JSON_COMPACT), 0);
    fputc('\n', file);
    json_decref(line);
    pen_arena_free(arena);
}

START_TEST(test_schema__agrees_with_the_reader_on_changed_scenes)
{
    enum { CHANGED = 2500 };
    struct random random = random_begin(20260729);
    char path[] = "/tmp/penumbra-verdicts-XXXXXX", command[128];
    int descriptor = mkstemp(path);
    ck_assert_int_ge(descriptor, 0);
    FILE *file = fdopen(descriptor, "w");
    glob_t files;
    ck_assert_int_eq(glob("tests/io/corpus/good/*.json", 0, NULL, &files), 0);
    ck_assert_int_eq(glob("scenes/spheres.json", GLOB_APPEND, NULL, &files), 0);
    for (int i = 0; i < CHANGED; i++) {
        const char *name = files.gl_pathv[random_below(&random, (uint32_t)files.gl_pathc)];
        json_t *document = json_load_file(name, 0, NULL);
        if (!document) /* integers of more than 64 bits */
            document = json_load_file(name, JSON_DECODE_INT_AS_REAL, NULL);
        ck_assert_ptr_nonnull(document);
        for (uint32_t changes = 1 + random_below(&random, 2); changes > 0; changes--)
            mutate_document(&random, document);
        write_verdict(file, document);
        json_decref(document);
    }
    globfree(&files);
    ck_assert_int_eq(fclose(file), 0);
    snprintf(command, sizeof command, CHECKER "verdicts %s", path);
    int result = system(command);
    unlink(path);
    ck_assert_msg(result == 0, "PEN_SEED=%llu", (unsigned long long)random.seed);
}
END_TEST

PEN_SUITE("io/schema", test_schema__agrees_with_the_reader_on_the_corpus,
          test_schema__agrees_with_the_reader_on_changed_scenes)
