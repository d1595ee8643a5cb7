/* SPDX-License-Identifier: MIT */
/* OBJ files and their MTL: corners, polygons, materials, paths, and what is refused. */
#include "support/models.h"

#define FOUR "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"

START_TEST(test_model_obj__reads_all_forms_of_corners)
{
    struct model r = {.mtl = NULL};
    ck_assert(model_text(&r, PEN_MODEL_OBJ,
                         "\xEF\xBB\xBF# f 1 2 3 \\\n" FOUR "vt 0 0\nvt 1 1\nvn 0 0 1\nvn 0 2 0\r\n"
                         "g side\nf 1 2 3\nf 1/1 2/2 4/1 # a comment \\\nf -4//-1 -2//1 -1//2\n"
                         "s off\no thing\nfo 2/1/2 3/2/1\\\n 4/-1/-2\r\n"
                         "\tf 1//1 \\\r\n 2 4//1"));
    model_check_corners(
        &r, (const uint32_t[][3]){{0, 1, 2}, {0, 1, 3}, {0, 2, 3}, {1, 2, 3}, {0, 1, 3}}, 5);
    const uint32_t no = PEN_NO_NORMAL;
    const uint32_t normal[][3] = {{no, no, no}, {no, no, no}, {1, 0, 1}, {1, 0, 0}, {no, no, no}};
    ck_assert_mem_eq(r.m.corner_normal, normal, sizeof normal);
    ck_assert(r.m.normal_count == 2 && r.m.normal[1][1] == 2 && r.m.normal[0][2] == 1);
    ck_assert(!r.m.material_of && r.m.crowded_edges == 3 && r.m.open_edges == 0);
    ck_assert(model_noted(&r, "3 edges belong to three"));
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_obj__faces_may_come_before_their_vertices)
{
    struct model r = {.mtl = NULL};
    ck_assert(model_text(&r, PEN_MODEL_OBJ, "f 1 2 3\n" FOUR "v 2 2 2 # more\nf -1 -2 -3\n"));
    model_check_corners(&r, (const uint32_t[][3]){{0, 1, 2}, {4, 3, 2}}, 2);
    pen_model_release(&r.m);
}
END_TEST

/* A name goes on to the next line after a backslash, for counting and for reading alike. */
START_TEST(test_model_obj__names_may_be_continued)
{
    static const char *const texts[] = {FOUR "usemtl red\\\r\nf 1 2 3\nf 1 2 4\n",
                                        FOUR "usemtl red\\\nf 1 2 3\nf 1 2 4\n"};
    for (int i = 0; i < 2; i++) {
        struct model r = {.mtl = NULL};
        ck_assert(model_text(&r, PEN_MODEL_OBJ, texts[i]));
        model_check_corners(&r, (const uint32_t[][3]){{0, 1, 3}}, 1);
        pen_model_release(&r.m);
    }
}
END_TEST

START_TEST(test_model_obj__reads_materials)
{
    struct model r = {
        .mtl =
            "# materials\nnewmtl red one\nKd 1 0.25 0\nKs .5\nKa 1 1 1\nillum 2\nNs 20\n"
            "d 0.75\nNi 1.5\nKe 0 0 3\nmap_Kd -s 1 1 red.png\nmap_Kd twice\nbump b.png\n"
            "newmtl unused\nKd 0 0 0\r\nnewmtl glass\nTr 0.75\nKd spectral x.rfl\nd -halo 0.5\n"};
    ck_assert(model_text(&r, PEN_MODEL_OBJ,
                         "mtllib .\\m.mtl\nmtllib .\\m.mtl\n" FOUR
                         "f 1 2 3\nusemtl glass\nf 1 2 4\nusemtl red one\t\r\nf 1 3 4\n"
                         "usemtl none\nf 2 3 4\n"));
    ck_assert_str_eq(r.asked, "m.mtl");
    ck_assert_uint_eq(r.m.material_count, 3);
    const uint16_t of[] = {0, 1, 2, 0};
    ck_assert_mem_eq(r.m.material_of, of, sizeof of);
    const struct pen_model_material *grey = &r.m.material[0], *glass = grey + 1, *red = grey + 2;
    ck_assert(grey->shininess == 1 && grey->ior == 0 && grey->diffuse[1] == 0.8f &&
              grey->opacity == 1);
    ck_assert(glass->ior == 0 && glass->opacity == 0.25f);
    ck_assert(red->diffuse[0] == 1 && red->diffuse[1] == 0.25f && red->diffuse[2] == 0);
    ck_assert(red->specular[0] == 0.5f && red->specular[2] == 0.5f && red->shininess == 20);
    ck_assert(red->opacity == 0.75f && red->ior == 1.5f && red->emission[2] == 3);
    ck_assert(model_noted(
        &r, "the material \"red one\" loses \"map_Kd\", \"bump\"; its colour stays Kd"));
    ck_assert(model_noted(&r, "the material \"glass\" loses \"Kd\", \"d\""));
    ck_assert(model_noted(&r, "1 statements usemtl, first \"none\""));
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_obj__numbers_of_materials_have_a_range)
{
    struct model r = {.mtl = "newmtl red one\nKd -3 0.5 1.5\nKs 2\nKe -1 7 0\nNs -5\nNi -1\nd 3\n"
                             "newmtl b\nd -0.5\nNs 3e38\nnewmtl c\nTr 1.5\nnewmtl d\nTr -1\n"};
    ck_assert(model_text(&r, PEN_MODEL_OBJ,
                         "mtllib m.mtl\n" FOUR "usemtl red one\nf 1 2 3\nusemtl b\nf 1 2 4\n"
                         "usemtl c\nf 1 3 4\nusemtl d\nf 2 3 4\n"));
    const struct pen_model_material *m = r.m.material;
    ck_assert(m->diffuse[0] == 0 && m->diffuse[1] == 0.5f && m->diffuse[2] == 1);
    ck_assert(m->specular[0] == 1 && m->specular[2] == 1 && m->shininess == 0 && m->ior == 0);
    ck_assert(m->emission[0] == 0 && m->emission[1] == 7 && m->opacity == 1);
    ck_assert(m[1].opacity == 0 && m[1].shininess == 3e38f && m[2].opacity == 0 &&
              m[3].opacity == 1);
    ck_assert(model_noted(&r, "the material \"red one\" has Kd -3; it is taken as 0"));
    ck_assert_uint_eq(r.notes.count, 9); /* one a statement */
    ck_assert(model_noted(&r, "the material \"red one\" has d 3; it is taken as 1"));
    ck_assert(model_noted(&r, "the material \"c\" has Tr 1.5; it is taken as 1"));
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_obj__counts_statements_that_are_not_read)
{
    struct model r = {.mtl = NULL};
    ck_assert(model_text(&r, PEN_MODEL_OBJ, FOUR "l 1 2\nf 1 2 3\np 1\nl 2 3\n"));
    ck_assert(model_noted(&r, "3 statements are not read, first \"l\""));
    ck_assert_int_eq(r.notes.item[0].line, 5);
    pen_model_release(&r.m);
}
END_TEST

START_TEST(test_model_obj__asks_only_for_files_in_its_folder)
{
    static const char *const names[][2] = {{"m.mtl", "m.mtl"},
                                           {"./m.mtl", "m.mtl"},
                                           {".\\m.mtl", "m.mtl"},
                                           {"a\\b/c.mtl", "a/b/c.mtl"},
                                           {"two words", "two words"},
                                           {"a..b/..c.mtl", "a..b/..c.mtl"},
                                           {"../m.mtl", NULL},
                                           {"a/../m.mtl", NULL},
                                           {"..", NULL},
                                           {"/m.mtl", NULL},
                                           {"\\m.mtl", NULL},
                                           {"C:\\m.mtl", NULL},
                                           {"a\\..\\..\\m.mtl", NULL},
                                           {"", NULL},
                                           {"a\1.mtl", NULL},
                                           {"a/..", NULL},
                                           {".//etc/x.mtl", NULL}};
    for (size_t i = 0; i < sizeof names / sizeof names[0]; i++) {
        struct model r = {.mtl = NULL};
        char text[200];
        snprintf(text, sizeof text, "\n  mtllib %s\n" FOUR "f 1 2 3\n", names[i][0]);
        ck_assert(!model_text(&r, PEN_MODEL_OBJ, text));
        ck_assert_str_eq(r.asked, names[i][1] ? names[i][1] : "");
        ck_assert_int_eq(r.st.code, names[i][1] ? PEN_NOT_FOUND : PEN_INVALID);
        ck_assert(strstr(r.st.msg, names[i][1] ? "No such file; put it beside" : "folder"));
        ck_assert_int_eq(r.st.line, 2);
    }
}
END_TEST

START_TEST(test_model_obj__reads_several_files_of_one_statement)
{
    struct model r = {.mtl = "newmtl a\n"};
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, "mtllib m.mtl  big name.MTL\n" FOUR "f 1 2 3"));
    ck_assert_str_eq(r.asked, "big name.MTL");
}
END_TEST

START_TEST(test_model_obj__an_error_in_an_mtl_names_both_lines)
{
    struct model r = {.mtl = "newmtl a\nKd 1 0\n"};
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, "\nmtllib m.mtl\n" FOUR "f 1 2 3"));
    ck_assert_msg(r.st.line == 2 && strstr(r.st.msg, "\"m.mtl\", line 2: Kd needs 3 numbers"), "%s",
                  r.st.msg);
    r.mtl = "Kd 1 0 0\n";
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, "mtllib m.mtl\n" FOUR "f 1 2 3"));
    ck_assert(strstr(r.st.msg, "before the first newmtl"));
    r.mtl = "newmtl a\nKd nan 0 0\n";
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, "mtllib m.mtl\n" FOUR "f 1 2 3"));
    ck_assert(strstr(r.st.msg, "found \"nan\""));
}
END_TEST

START_TEST(test_model_obj__searches_for_too_many_materials_are_refused)
{
    enum { MATERIALS = 4000, USES = 20000, LINE = 16 };
    static char mtl[LINE * MATERIALS + 1], obj[LINE * USES + 100] = FOUR "mtllib m.mtl\n";
    struct model r = {.mtl = mtl};
    const size_t head = strlen(obj);
    for (size_t i = 0; i < MATERIALS; i++)
        snprintf(mtl + LINE * i, LINE + 1, "newmtl %08zu\n", i);
    for (size_t i = 0; i < USES; i++)
        snprintf(obj + head + LINE * i, LINE + 1, "usemtl %08d\n", MATERIALS - 1);
    strcat(obj, "f 1 2 3\n");
    ck_assert(!model_text(&r, PEN_MODEL_OBJ, obj));
    ck_assert_msg(r.st.code == PEN_TOO_LARGE && r.st.line > 1000 &&
                      strstr(r.st.msg, "this one of 4000 materials"),
                  "%d: %s", r.st.line, r.st.msg);
}
END_TEST

START_TEST(test_model_obj__refuses_with_a_line_and_advice)
{
    static const struct model_refusal refusals[] = {
        {"", PEN_INVALID, 0, "point clouds"},
        {FOUR, PEN_INVALID, 0, "point clouds"},
        {FOUR "f 1 2\n", PEN_INVALID, 5, "a face of 2 corners"},
        {FOUR "f\n", PEN_INVALID, 5, "a face of 0 corners"},
        {FOUR "f 1 2 5\n", PEN_INVALID, 5, "\"5\" does not exist: the file has 4"},
        {FOUR "f 1 2 -5\n", PEN_INVALID, 5, "4 before this line"},
        {FOUR "f 0 1 2\n", PEN_INVALID, 5, "numbered from 1"},
        {FOUR "f 1 2 99999999999999999999\n", PEN_INVALID, 5, "does not exist"},
        {FOUR "vn 0 0 1\nf 1//1 2//1 3//2\n", PEN_INVALID, 6, "the file has 1"},
        {FOUR "f 1 2 3.5\n", PEN_SYNTAX, 5, "v/vt/vn"},
        {FOUR "f 1 2 x\n", PEN_SYNTAX, 5, "found \"x\""},
        {FOUR "f 1 2 3/1/\n", PEN_SYNTAX, 5, "v/vt/vn"},
        {FOUR "f 1 2 3 - 4\n", PEN_SYNTAX, 5, "found \"-\""},
        {FOUR "f 1/1/1/1 2 3\n", PEN_INVALID, 5, "does not exist"},
        {FOUR "v 0 0\nf 1 2 3\n", PEN_SYNTAX, 5, "needs three numbers"},
        {FOUR "v 0 0 nan\nf 1 2 3\n", PEN_SYNTAX, 5, "found \"nan\""},
        {FOUR "v 0 0 1e39\nf 1 2 3\n", PEN_INVALID, 5, "too large"},
        {FOUR "v 0 0 -inf\nf 1 2 3\n", PEN_SYNTAX, 5, "found \"-inf\""},
        {FOUR "vn 0 0 inf\nf 1 2 3\n", PEN_SYNTAX, 5, "found \"inf\""},
        {FOUR "v 0 0 1,5\nf 1 2 3\n", PEN_SYNTAX, 5, "found \"1,5\""},
        {FOUR "f 1 2 3\ncstype bezier\n", PEN_UNSUPPORTED, 6, "\"cstype\" belongs to a curve"},
        {FOUR "f 1 2 3\ncurv 0 1 1 2\n", PEN_UNSUPPORTED, 6, "\"curv\""},
        {FOUR "f 1 2 3\nsurf 0 1 0 1 1 2 3 4\n", PEN_UNSUPPORTED, 6, "\"surf\""},
        {"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\nf 1 1 2\n", PEN_INVALID, 0, "has an area"},
    };
    model_check_refusals(PEN_MODEL_OBJ, refusals, sizeof refusals / sizeof refusals[0]);
}
END_TEST

START_TEST(test_model_obj__without_other_files_a_named_mtl_is_refused)
{
    static const char text[] = "mtllib m.mtl\n" FOUR "f 1 2 3\n";
    const struct pen_model_file file = {text, sizeof text - 1, PEN_MODEL_OBJ, 0, NULL, NULL};
    struct pen_errors notes = {0};
    struct pen_status st = {0};
    struct pen_model m;
    ck_assert(!pen_model_read(&file, &m, &notes, &st));
    ck_assert(st.code == PEN_UNSUPPORTED && st.line == 1);
}
END_TEST

PEN_SUITE("io/model_obj", test_model_obj__reads_all_forms_of_corners,
          test_model_obj__faces_may_come_before_their_vertices,
          test_model_obj__names_may_be_continued, test_model_obj__reads_materials,
          test_model_obj__numbers_of_materials_have_a_range,
          test_model_obj__counts_statements_that_are_not_read,
          test_model_obj__asks_only_for_files_in_its_folder,
          test_model_obj__reads_several_files_of_one_statement,
          test_model_obj__an_error_in_an_mtl_names_both_lines,
          test_model_obj__searches_for_too_many_materials_are_refused,
          test_model_obj__refuses_with_a_line_and_advice,
          test_model_obj__without_other_files_a_named_mtl_is_refused)
