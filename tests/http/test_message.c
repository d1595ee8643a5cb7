/* SPDX-License-Identifier: MIT */
/* Request targets, Host, media types, entity tags and ranges, without a connection. */
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "http/message.h"
#include "support/suite.h"

#define COUNT(rows) (sizeof(rows) / sizeof(rows)[0])

static struct pen_target parse(const char *raw)
{
    struct pen_target target;
    struct pen_status st;
    ck_assert_msg(pen_target_parse(raw, &target, &st), "%s was refused", raw);
    return target;
}

static enum pen_code refusal(const char *raw)
{
    struct pen_target target;
    struct pen_status st;
    ck_assert_msg(!pen_target_parse(raw, &target, &st), "%s was taken", raw);
    pen_target_release(&target);
    return st.code;
}

START_TEST(test_message__target_splits_path_and_query)
{
    struct pen_target target = parse("/v1/jobs?state=queued&limit=7");
    ck_assert_int_eq(target.segment_count, 2);
    ck_assert_str_eq(target.segment[0], "v1");
    ck_assert_str_eq(target.segment[1], "jobs");
    ck_assert_int_eq(target.param_count, 2);
    ck_assert_str_eq(pen_target_param(&target, "state"), "queued");
    ck_assert_str_eq(pen_target_param(&target, "limit"), "7");
    ck_assert_ptr_null(pen_target_param(&target, "lim"));
    pen_target_release(&target);
}
END_TEST

START_TEST(test_message__target_root_has_no_segments)
{
    struct pen_target target = parse("/");
    ck_assert_int_eq(target.segment_count, 0);
    pen_target_release(&target);
    target = parse("/?a");
    ck_assert_int_eq(target.segment_count, 0);
    ck_assert_str_eq(pen_target_param(&target, "a"), "");
    pen_target_release(&target);
}
END_TEST

START_TEST(test_message__target_keeps_empty_segments)
{
    struct pen_target target = parse("/v1/jobs/");
    ck_assert_int_eq(target.segment_count, 3);
    ck_assert_str_eq(target.segment[2], "");
    pen_target_release(&target);
    target = parse("//");
    ck_assert_int_eq(target.segment_count, 2);
    pen_target_release(&target);
}
END_TEST

START_TEST(test_message__target_decodes_after_splitting)
{
    struct pen_target target = parse("/a%2Fb/%c3%A4?x%3d=1%262&y=a+b%2B");
    ck_assert_int_eq(target.segment_count, 2);
    ck_assert_str_eq(target.segment[0], "a/b");
    ck_assert_str_eq(target.segment[1], "\xc3\xa4");
    ck_assert_str_eq(pen_target_param(&target, "x="), "1&2");
    ck_assert_str_eq(pen_target_param(&target, "y"), "a b+");
    pen_target_release(&target);
    target = parse("/a+b");
    ck_assert_str_eq(target.segment[0], "a+b");
    pen_target_release(&target);
}
END_TEST

START_TEST(test_message__target_refuses_bad_escapes)
{
    static const char *const bad[] = {"/%", "/%4", "/%zz", "/a%00b", "/?a=%", "/?%g1=2", "/?a=%00"};
    for (size_t i = 0; i < COUNT(bad); i++)
        ck_assert_int_eq(refusal(bad[i]), PEN_SYNTAX);
}
END_TEST

START_TEST(test_message__target_must_be_a_path)
{
    static const char *const bad[] = {"", "*", "v1/jobs", "localhost:80", "ftp://localhost/"};
    for (size_t i = 0; i < COUNT(bad); i++)
        ck_assert_int_eq(refusal(bad[i]), PEN_SYNTAX);
}
END_TEST

START_TEST(test_message__target_takes_the_absolute_form)
{
    struct pen_target target = parse("http://localhost:8080/v1/jobs?limit=1");
    ck_assert_str_eq(target.authority, "localhost:8080");
    ck_assert_int_eq(target.segment_count, 2);
    ck_assert_str_eq(target.segment[1], "jobs");
    ck_assert_str_eq(pen_target_param(&target, "limit"), "1");
    pen_target_release(&target);
    target = parse("HTTP://evil?x=y");
    ck_assert_str_eq(target.authority, "evil");
    ck_assert_int_eq(target.segment_count, 0);
    ck_assert_str_eq(pen_target_param(&target, "x"), "y");
    pen_target_release(&target);
    target = parse("/plain");
    ck_assert_ptr_null(target.authority);
    pen_target_release(&target);
}
END_TEST

START_TEST(test_message__target_bounds_segments_and_parameters)
{
    struct pen_target target = parse("/1/2/3/4/5/6/7/8/9/10");
    const char *arg;
    ck_assert_int_gt(target.segment_count, PEN_SEGMENTS_MAX);
    ck_assert(!pen_target_matches(&target, "/1/2/3/4/5/6/7/8", &arg));
    pen_target_release(&target);

    char raw[200] = "/?";
    for (int i = 0; i <= PEN_PARAMS_MAX; i++)
        strcat(raw, "a=1&");
    ck_assert_int_eq(refusal(raw), PEN_USAGE);
    raw[strlen(raw) - 4] = '\0';
    target = parse(raw);
    ck_assert_int_eq(target.param_count, PEN_PARAMS_MAX);
    pen_target_release(&target);
}
END_TEST

/* Random bytes are parsed or refused, and decoding never makes a text longer. */
START_TEST(test_message__target_survives_random_bytes)
{
    static const char common[] = "/?&=%+0aF:htp.";
    unsigned seed = (unsigned)time(NULL);
    srand(seed);
    for (int round = 0; round < 20000; round++) {
        char raw[64] = "";
        int length = rand() % 60;
        for (int i = 0; i < length; i++)
            raw[i] = (char)(rand() % 4 ? common[rand() % 14] : 1 + rand() % 255);
        struct pen_target target;
        struct pen_status st;
        bool taken = pen_target_parse(raw, &target, &st);
        ck_assert_msg(taken || st.code == PEN_SYNTAX || st.code == PEN_USAGE, "seed %u: %s", seed,
                      raw);
        size_t decoded = 0;
        for (int i = 0; i < target.segment_count && i < PEN_SEGMENTS_MAX; i++)
            decoded += strlen(target.segment[i]);
        ck_assert_msg(decoded <= strlen(raw), "seed %u: %s", seed, raw);
        pen_target_release(&target);
    }
}
END_TEST

START_TEST(test_message__template_gives_its_argument)
{
    struct pen_target target = parse("/v1/jobs/abc/image");
    const char *arg;
    ck_assert(pen_target_matches(&target, "/v1/jobs/{id}/image", &arg));
    ck_assert_str_eq(arg, "abc");
    ck_assert(!pen_target_matches(&target, "/v1/jobs/{id}", &arg));
    ck_assert(!pen_target_matches(&target, "/v1/jobs/{id}/scene", &arg));
    ck_assert(!pen_target_matches(&target, "/v1/jobs/{id}/image/x", &arg));
    ck_assert(!pen_target_matches(&target, "/", &arg));
    pen_target_release(&target);
    target = parse("/");
    ck_assert(pen_target_matches(&target, "/", &arg));
    ck_assert_ptr_null(arg);
    ck_assert(!pen_target_matches(&target, "/v1", &arg));
    pen_target_release(&target);
    target = parse("/v1x");
    ck_assert(!pen_target_matches(&target, "/v1", &arg));
    pen_target_release(&target);
}
END_TEST

START_TEST(test_message__number_takes_plain_digits_in_range)
{
    static const char *const bad[] = {"",   "61",  "-1",  "+1",  " 1",
                                      "1 ", "1.0", "1e1", "0x1", "9999999999999999999"};
    long n = -1;
    ck_assert(pen_number_parse("0", 0, 60, &n) && n == 0);
    ck_assert(pen_number_parse("60", 0, 60, &n) && n == 60);
    ck_assert(pen_number_parse("007", 0, 60, &n) && n == 7);
    for (size_t i = 0; i < COUNT(bad); i++)
        ck_assert_msg(!pen_number_parse(bad[i], 0, 60, &n), "\"%s\"", bad[i]);
    ck_assert(!pen_number_parse("0", 1, 500, &n));
}
END_TEST

START_TEST(test_message__host_is_loopback_by_name_only)
{
    static const char *const good[] = {"localhost", "LocalHost:8080", "127.0.0.1", "127.0.0.1:1",
                                       "[::1]",     "[::1]:65535",    "localhost:"};
    static const char *const bad[] = {
        "",    "evil.com", "localhost.evil.com", "localhost:80x", "127.0.0.2",  "127.0.0.1.nip.io",
        "::1", "[::1]x",   "localhost:65536",    "localhost:-1",  " localhost", "localhost,evil"};
    for (size_t i = 0; i < COUNT(good); i++)
        ck_assert_msg(pen_host_is_loopback(good[i]), "%s", good[i]);
    for (size_t i = 0; i < COUNT(bad); i++)
        ck_assert_msg(!pen_host_is_loopback(bad[i]), "%s", bad[i]);
    ck_assert(!pen_host_is_loopback(NULL));
}
END_TEST

START_TEST(test_message__origin_must_be_the_host)
{
    ck_assert(pen_origin_is_host("http://localhost:8080", "http", "localhost:8080"));
    ck_assert(pen_origin_is_host("https://a.example", NULL, "A.example"));
    ck_assert(!pen_origin_is_host("https://localhost:8080", "http", "localhost:8080"));
    ck_assert(!pen_origin_is_host("http://evil.com", "http", "localhost:8080"));
    ck_assert(!pen_origin_is_host("http://localhost:9090", "http", "localhost:8080"));
    ck_assert(!pen_origin_is_host("null", NULL, "localhost:8080"));
    ck_assert(!pen_origin_is_host("http://localhost", NULL, NULL));
    ck_assert(pen_origin_listed("https://a.example http://b:1", "http://b:1"));
    ck_assert(!pen_origin_listed("https://a.example http://b:1", "http://b"));
    ck_assert(!pen_origin_listed("https://a.example", "null"));
    ck_assert(!pen_origin_listed("", "http://b"));
}
END_TEST

START_TEST(test_message__media_types)
{
    static const struct {
        const char *type;
        enum pen_media media;
    } rows[] = {{NULL, PEN_MEDIA_NONE},
                {"application/x-www-form-urlencoded", PEN_MEDIA_NONE},
                {"application/json", PEN_MEDIA_JSON},
                {"Application/JSON; charset=UTF-8", PEN_MEDIA_JSON},
                {"application/json;charset=\"utf-8\"", PEN_MEDIA_JSON},
                {"application/json; charset=us-ascii", PEN_MEDIA_JSON},
                {"application/json; charset=latin1", PEN_MEDIA_OTHER},
                {"application/xml", PEN_MEDIA_XML},
                {"text/xml ; charset=utf-8", PEN_MEDIA_XML},
                {"application/xml; charset=utf-16", PEN_MEDIA_XML},
                {"text/xml;charset=\"UTF-16LE\"", PEN_MEDIA_XML},
                {"text/xml;charset=utf-32", PEN_MEDIA_OTHER},
                {"application/json; charset=utf-16", PEN_MEDIA_OTHER},
                {"application/x-www-form-urlencoded; charset=utf-16", PEN_MEDIA_OTHER},
                {"text/plain", PEN_MEDIA_OTHER},
                {"multipart/form-data; boundary=x", PEN_MEDIA_OTHER},
                {"application/jsonx", PEN_MEDIA_OTHER},
                {"application/jso", PEN_MEDIA_OTHER},
                {"", PEN_MEDIA_OTHER}};
    for (size_t i = 0; i < COUNT(rows); i++)
        ck_assert_msg(pen_media_parse(rows[i].type) == rows[i].media, "row %zu", i);
}
END_TEST

START_TEST(test_message__etag_lists)
{
    ck_assert(pen_etag_listed("\"7\"", "\"7\""));
    ck_assert(pen_etag_listed("W/\"7\"", "\"7\""));
    ck_assert(pen_etag_listed("\"5\", \"6\" ,W/\"7\"", "\"7\""));
    ck_assert(pen_etag_listed("W/\"7\"", "W/\"7\""));
    ck_assert(pen_etag_listed("\"7\"", "W/\"7\""));
    ck_assert(!pen_etag_listed("\"77\"", "W/\"7\""));
    ck_assert(pen_etag_listed(" * ", "\"7\""));
    ck_assert(!pen_etag_listed("\"77\"", "\"7\""));
    ck_assert(!pen_etag_listed("7", "\"7\""));
    ck_assert(!pen_etag_listed("\"7", "\"7\""));
    ck_assert(!pen_etag_listed("", "\"7\""));
    ck_assert(!pen_etag_listed(",,,", "\"7\""));
    ck_assert(!pen_etag_listed("x \"7\"", "\"7\""));
}
END_TEST

START_TEST(test_message__uuid_has_its_form)
{
    static const char *const wrong[] = {"",
                                        "x",
                                        "01890a5d-ac96-774b-bcce-b302099a805",
                                        "01890a5d-ac96-774b-bcce-b302099a80577",
                                        "01890a5d-ac96-774b-bcce-b302099a805g",
                                        "01890a5dfac96-774b-bcce-b302099a8057"};
    char uuid[PEN_UUID_BYTES];
    ck_assert(pen_uuid_parse("01890A5d-aC96-774b-bcce-b302099a8057", uuid));
    ck_assert_str_eq(uuid, "01890a5d-ac96-774b-bcce-b302099a8057");
    for (size_t i = 0; i < sizeof wrong / sizeof wrong[0]; i++)
        ck_assert_msg(!pen_uuid_parse(wrong[i], uuid), "%s", wrong[i]);
}
END_TEST

START_TEST(test_message__ranges)
{
    static const struct {
        const char *range;
        enum pen_range_kind kind;
        uint64_t first, count;
    } rows[] = {{"bytes=0-0", PEN_RANGE_PART, 0, 1},
                {"bytes=0-99", PEN_RANGE_PART, 0, 100},
                {"bytes=10-19", PEN_RANGE_PART, 10, 10},
                {"bytes=99-", PEN_RANGE_PART, 99, 1},
                {"Bytes=90-1000", PEN_RANGE_PART, 90, 10},
                {"bytes=5-18446744073709551615", PEN_RANGE_PART, 5, 95},
                {"bytes=5-99999999999999999999999", PEN_RANGE_PART, 5, 95},
                {"bytes=-1", PEN_RANGE_PART, 99, 1},
                {"bytes=-1000", PEN_RANGE_PART, 0, 100},
                {"bytes=100-", PEN_RANGE_OUTSIDE, 0, 0},
                {"bytes=99999999999999999999999-", PEN_RANGE_OUTSIDE, 0, 0},
                {"bytes=-0", PEN_RANGE_OUTSIDE, 0, 0},
                {"bytes=9-5", PEN_RANGE_WHOLE, 0, 0},
                {"bytes=-", PEN_RANGE_WHOLE, 0, 0},
                {"bytes=", PEN_RANGE_WHOLE, 0, 0},
                {"bytes=a-b", PEN_RANGE_WHOLE, 0, 0},
                {"bytes=0-1,5-6", PEN_RANGE_WHOLE, 0, 0},
                {"lines=0-1", PEN_RANGE_WHOLE, 0, 0},
                {"", PEN_RANGE_WHOLE, 0, 0}};
    for (size_t i = 0; i < COUNT(rows); i++) {
        uint64_t first = 0, count = 0;
        ck_assert_msg(pen_range_parse(rows[i].range, 100, &first, &count) == rows[i].kind, "%s",
                      rows[i].range);
        ck_assert_msg(first == rows[i].first && count == rows[i].count, "%s", rows[i].range);
    }
}
END_TEST

START_TEST(test_message__empty_body_has_no_ranges)
{
    uint64_t first, count;
    ck_assert_int_eq(pen_range_parse("bytes=0-", 0, &first, &count), PEN_RANGE_OUTSIDE);
    ck_assert_int_eq(pen_range_parse("bytes=-5", 0, &first, &count), PEN_RANGE_OUTSIDE);
}
END_TEST

static int choose(const char *accept)
{
    static const char *const types[] = {"text/html", "application/json", "text/csv",
                                        "text/markdown"};
    return pen_accept_choose(accept, types, 4);
}

START_TEST(test_message__accept_chooses_the_most_preferred_type)
{
    static const struct {
        const char *accept;
        int chosen;
    } rows[] = {
        {NULL, 0},
        {"", 0},
        {"*/*", 0},
        {"application/json", 1},
        {"APPLICATION/Json; charset=utf-8", 1},
        {"text/*", 0},
        {"application/*", 1},
        {"image/png, text/csv", 2},
        {"text/html;q=0.5, text/markdown", 3},
        {"text/html ; q=0.5 , text/markdown ;q=0.4", 0},
        {"text/*;q=0.5, text/csv;q=0.6", 2},
        {"*/*, text/html;q=0", 1},
        {"text/html;q=0", -1},
        {"image/png", -1},
        {"image/*", -1},
        {"text", -1},
        {"text/htmlx", -1},
        {"text/html;q=2", -1},
        {"text/html;q=x", -1},
        {";;,,;q=", -1},
        {"text/html,application/xhtml+xml,application/xml;q=0.9,image/avif,*/*;q=0.8", 0},
    };
    for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++)
        ck_assert_msg(choose(rows[i].accept) == rows[i].chosen, "%s: %d", rows[i].accept,
                      choose(rows[i].accept));
}
END_TEST

PEN_SUITE("message", test_message__target_splits_path_and_query,
          test_message__target_root_has_no_segments, test_message__target_keeps_empty_segments,
          test_message__target_decodes_after_splitting, test_message__target_refuses_bad_escapes,
          test_message__target_must_be_a_path, test_message__target_takes_the_absolute_form,
          test_message__target_bounds_segments_and_parameters,
          test_message__target_survives_random_bytes, test_message__template_gives_its_argument,
          test_message__number_takes_plain_digits_in_range,
          test_message__host_is_loopback_by_name_only, test_message__origin_must_be_the_host,
          test_message__media_types, test_message__etag_lists, test_message__uuid_has_its_form,
          test_message__ranges, test_message__empty_body_has_no_ranges,
          test_message__accept_chooses_the_most_preferred_type)
