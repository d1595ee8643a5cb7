/* SPDX-License-Identifier: MIT */
/* Tables and lines of reports in every format. A table for readers begins with the row's number,
 * and its settings in words if rows have settings. CSV has a column for each setting. */
#include <stdlib.h>
#include <string.h>

#include "base/utf8.h"
#include "report/internal/kind.h"

enum { TERMINAL_COLUMNS = 80, GAP = 2 };

/* The cells of a table, neither escaped nor aligned; row 0 has the titles. */
struct cells {
    size_t rows, columns;
    struct pen_buf *cell; /* [row * columns + column] */
    bool *is_text;        /* by column: aligned left; numbers are aligned right */
};

static struct pen_buf *at(const struct cells *cells, size_t row, size_t column)
{
    return &cells->cell[row * cells->columns + column];
}

static const char *text_of(const struct cells *cells, size_t row, size_t column)
{
    const struct pen_buf *cell = at(cells, row, column);
    return cell->data ? (const char *)cell->data : "";
}

static void write_number(double value, enum pen_cell cell, struct pen_buf *out)
{
    static const char *const forms[] = {
        [PEN_CELL_SHORT] = "%.3g", [PEN_CELL_TENTH] = "%.1f", [PEN_CELL_FOURTH] = "%.4f"};
    if (cell == PEN_CELL_NUMBER)
        pen_write_number(value, out);
    else if (cell == PEN_CELL_COUNT)
        pen_write_count(value, out);
    else
        pen_buf_printf(out, forms[cell], value);
}

static void write_cell(const struct pen_column *column, const json_t *row, struct pen_buf *out)
{
    if (column->write) {
        column->write(row, out);
        return;
    }
    const json_t *value = pen_report_member(row, column->path);
    if (column->cell == PEN_CELL_TEXT)
        pen_buf_puts(out, json_is_string(value) ? json_string_value(value) : "");
    else if (json_is_number(value))
        write_number(json_number_value(value), column->cell, out);
    if (column->to && pen_report_has_number(row, column->to)) {
        pen_buf_puts(out, "\xE2\x80\x93");
        write_number(pen_report_number(row, column->to), column->cell, out);
    }
}

/* Whether a table for readers has the column. A column without any value is left out. */
static bool is_shown(const struct pen_column *column, bool aside, const json_t *rows)
{
    bool there = !column->path || json_array_size(rows) == 0;
    for (size_t i = 0; !there && i < json_array_size(rows); i++) {
        const json_t *value = pen_report_member(json_array_get(rows, i), column->path);
        there = value && !json_is_null(value);
    }
    return column->title && column->aside == aside && there;
}

static bool is_last(const struct pen_column *column)
{
    return !column->title && !column->name;
}

static bool have_settings(const json_t *rows)
{
    return json_object_size(json_object_get(json_array_get(rows, 0), "settings")) > 0;
}

/* Fills a column: its title, then a cell for each row. */
static void fill_column(const struct cells *cells, size_t number, const struct pen_column *column,
                        const json_t *rows)
{
    size_t i;
    json_t *row;
    cells->is_text[number] = column->cell == PEN_CELL_TEXT;
    pen_buf_puts(at(cells, 0, number), column->title);
    json_array_foreach(rows, i, row)
    {
        write_cell(column, row, at(cells, i + 1, number));
    }
}

static void cells_release(struct cells *cells)
{
    for (size_t i = 0; cells->cell && i < cells->rows * cells->columns; i++)
        pen_buf_release(&cells->cell[i]);
    free(cells->cell);
    free(cells->is_text);
}

/* Makes the cells of a table. Returns false when out of memory.
 * Owns: release the cells, after success and after failure. */
static bool cells_init(struct cells *cells, const json_t *rows, const struct pen_column *columns,
                       bool aside)
{
    static const struct pen_column settings = {NULL, "settings", NULL, .cell = PEN_CELL_TEXT,
                                               .write = pen_write_row_name};
    const bool named = have_settings(rows);
    size_t count = 1 + named, at_column = 1;
    for (const struct pen_column *c = columns; !is_last(c); c++)
        count += is_shown(c, aside, rows);
    *cells = (struct cells){.rows = json_array_size(rows) + 1, .columns = count};
    cells->cell = calloc(cells->rows * count, sizeof *cells->cell);
    cells->is_text = calloc(count, sizeof *cells->is_text);
    if (!cells->cell || !cells->is_text)
        return false;
    pen_buf_puts(at(cells, 0, 0), "row");
    for (size_t i = 1; i < cells->rows; i++)
        pen_buf_printf(at(cells, i, 0), "%zu", i - 1);
    if (named)
        fill_column(cells, at_column++, &settings, rows);
    for (const struct pen_column *c = columns; !is_last(c); c++)
        if (is_shown(c, aside, rows))
            fill_column(cells, at_column++, c, rows);
    bool ok = true;
    for (size_t i = 0; i < cells->rows * count; i++)
        ok &= !cells->cell[i].failed;
    return ok;
}

/* Writes a text without control characters, which a terminal would obey. */
static void write_plain(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        const bool control = (unsigned char)*text < 0x20 || *text == 0x7F;
        pen_buf_add(out, control ? "?" : text, 1);
    }
}

/* Escapes the characters that Markdown, or HTML in it, reads as markup. */
static void write_markdown(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        if (*text == '<')
            pen_buf_puts(out, "&lt;");
        else if (*text == '&')
            pen_buf_puts(out, "&amp;");
        else if ((unsigned char)*text < 0x20)
            pen_buf_puts(out, " ");
        else
            pen_buf_printf(out, strchr("\\`*_[]|#!~>", *text) ? "\\%c" : "%c", *text);
    }
}

static void write_html(const char *text, struct pen_buf *out)
{
    for (; *text; text++) {
        const char *entity = *text == '<'    ? "&lt;"
                             : *text == '>'  ? "&gt;"
                             : *text == '&'  ? "&amp;"
                             : *text == '"'  ? "&quot;"
                             : *text == '\'' ? "&#39;"
                                             : NULL;
        pen_buf_add(out, entity ? entity : text, entity ? strlen(entity) : 1);
    }
}

void pen_layout_text(enum pen_layout layout, const char *text, struct pen_buf *out)
{
    static void (*const write[])(const char *,
                                 struct pen_buf *) = {[PEN_LAYOUT_TEXT] = write_plain,
                                                      [PEN_LAYOUT_MARKDOWN] = write_markdown,
                                                      [PEN_LAYOUT_HTML] = write_html};
    write[layout](text, out);
}

void pen_layout_lines(enum pen_layout layout, pen_words_fn *words, const json_t *report,
                      struct pen_buf *out)
{
    static const char *const begin[] = {"", "", "<p>"}, *const end[] = {"\n", "\n\n", "</p>\n"};
    struct pen_buf text = {0};
    if (!words)
        return;
    words(report, &text);
    for (char *line = (char *)text.data, *next; line && *line; line = next) {
        next = line + strcspn(line, "\n");
        next += *next ? (*next = '\0', 1) : 0;
        pen_buf_puts(out, begin[layout]);
        pen_layout_text(layout, line, out);
        pen_buf_puts(out, end[layout]);
    }
    out->failed |= text.failed;
    pen_buf_release(&text);
}

static size_t width_of(const char *text)
{
    return pen_utf8_columns(text, strlen(text));
}

static size_t column_width(const struct cells *cells, size_t column)
{
    size_t width = 0;
    for (size_t row = 0; row < cells->rows; row++) {
        const size_t here = width_of(text_of(cells, row, column));
        width = here > width ? here : width;
    }
    return width;
}

static void write_aligned(const struct cells *cells, size_t row, size_t column, bool last,
                          struct pen_buf *out)
{
    const char *text = text_of(cells, row, column);
    const int blank = (int)(column_width(cells, column) - width_of(text));
    const bool words = cells->is_text[column];
    pen_buf_printf(out, "%*s", words ? 0 : blank, "");
    write_plain(text, out);
    pen_buf_printf(out, "%*s", words && !last ? blank : 0, "");
}

/* The end of a part of a table: the column after the last one that fits beside the first column. A
 * part has at least one column from `begin` on. */
static size_t part_end(const struct cells *cells, size_t begin)
{
    size_t width = column_width(cells, 0), end = begin;
    while (end < cells->columns) {
        width += GAP + column_width(cells, end);
        if (width > TERMINAL_COLUMNS && end > begin)
            break;
        end++;
    }
    return end;
}

/* Writes a table for a terminal. A wider table is cut into parts below each other, each of which
 * begins with the first column. */
static void write_text_table(const struct cells *cells, struct pen_buf *out)
{
    for (size_t begin = 1, end; begin < cells->columns; begin = end) {
        end = part_end(cells, begin);
        pen_buf_puts(out, begin > 1 ? "\n" : "");
        for (size_t row = 0; row < cells->rows; row++) {
            write_aligned(cells, row, 0, false, out);
            for (size_t column = begin; column < end; column++) {
                pen_buf_printf(out, "%*s", GAP, "");
                write_aligned(cells, row, column, column + 1 == end, out);
            }
            pen_buf_puts(out, "\n");
        }
    }
}

static void write_markdown_table(const struct cells *cells, struct pen_buf *out)
{
    for (size_t row = 0; row < cells->rows; row++) {
        for (size_t column = 0; column < cells->columns; column++) {
            pen_buf_puts(out, "| ");
            write_markdown(text_of(cells, row, column), out);
            pen_buf_puts(out, " ");
        }
        pen_buf_puts(out, "|\n");
        for (size_t column = 0; row == 0 && column < cells->columns; column++)
            pen_buf_puts(out, cells->is_text[column] ? "|:---" : "|---:");
        pen_buf_puts(out, row == 0 ? "|\n" : "");
    }
}

static void write_html_cell(const struct cells *cells, size_t row, size_t column,
                            struct pen_buf *out)
{
    const char *tag = row == 0 || column == 0 ? "th" : "td", *scope = row == 0 ? " scope=\"col\""
                                                                      : column == 0
                                                                          ? " scope=\"row\""
                                                                          : "";
    pen_buf_printf(out, "<%s%s%s>", tag, cells->is_text[column] ? " class=\"text\"" : "", scope);
    write_html(text_of(cells, row, column), out);
    pen_buf_printf(out, "</%s>", tag);
}

static void write_html_table(const struct cells *cells, const char *caption, struct pen_buf *out)
{
    pen_buf_printf(out,
                   "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"%s\"><table>"
                   "<caption>%s</caption>\n<thead>",
                   caption, caption);
    for (size_t row = 0; row < cells->rows; row++) {
        pen_buf_puts(out, "<tr>");
        for (size_t column = 0; column < cells->columns; column++)
            write_html_cell(cells, row, column, out);
        pen_buf_puts(out, row == 0 ? "</tr></thead>\n<tbody>\n" : "</tr>\n");
    }
    pen_buf_puts(out, "</tbody></table></div>\n");
}

static void write_table(enum pen_layout layout, const struct pen_report_kind *kind,
                        const json_t *rows, bool aside, struct pen_buf *out)
{
    struct cells cells;
    if (!cells_init(&cells, rows, kind->columns, aside))
        out->failed = true;
    else if (layout == PEN_LAYOUT_TEXT)
        write_text_table(&cells, out);
    else if (layout == PEN_LAYOUT_MARKDOWN)
        write_markdown_table(&cells, out);
    else
        write_html_table(&cells, aside ? kind->aside : kind->caption, out);
    pen_buf_puts(out, "\n");
    cells_release(&cells);
}

/* The rows of a report. Returns a new reference. */
static json_t *rows_of(const struct pen_report_kind *kind, const json_t *report)
{
    return kind->rows ? kind->rows(report) : json_incref(json_object_get(report, "rows"));
}

void pen_layout_tables(enum pen_layout layout, const struct pen_report_kind *kind,
                       const json_t *report, struct pen_buf *out)
{
    json_t *rows = rows_of(kind, report);
    write_table(layout, kind, rows, false, out);
    if (kind->aside)
        write_table(layout, kind, rows, true, out);
    json_decref(rows);
}

/* One cell of CSV, in quotes where RFC 4180 requires them. */
static void write_csv_text(const char *text, struct pen_buf *out)
{
    if (!strpbrk(text, ",\"\r\n")) {
        pen_buf_puts(out, text);
        return;
    }
    pen_buf_puts(out, "\"");
    for (; *text; text++)
        pen_buf_printf(out, *text == '"' ? "\"\"" : "%c", *text);
    pen_buf_puts(out, "\"");
}

static void write_csv_value(const json_t *value, struct pen_buf *out)
{
    struct pen_buf text = {0};
    if (value && !json_is_null(value))
        pen_write_value(value, &text);
    pen_buf_puts(out, ",");
    write_csv_text(text.data ? (const char *)text.data : "", out);
    out->failed |= text.failed;
    pen_buf_release(&text);
}

/* Writes a line of CSV. row NULL: the titles. `keys` are the settings of the first row; all rows
 * have the same keys. */
static void write_csv_line(const json_t *row, json_t *keys, const struct pen_column *columns,
                           struct pen_buf *out)
{
    const char *key;
    json_t *value;
    json_object_foreach(keys, key, value)
    {
        json_t *name = row ? NULL : json_string(key);
        write_csv_value(row ? json_object_get(json_object_get(row, "settings"), key) : name, out);
        json_decref(name);
    }
    for (; !is_last(columns); columns++) {
        if (columns->name && row)
            write_csv_value(pen_report_member(row, columns->path), out);
        else if (columns->name)
            pen_buf_printf(out, ",%s", columns->name);
    }
    pen_buf_puts(out, "\n");
}

void pen_csv_write(const struct pen_report_kind *kind, const json_t *report, struct pen_buf *out)
{
    json_t *rows = rows_of(kind, report), *row,
           *keys = json_object_get(json_array_get(rows, 0), "settings");
    size_t i;
    pen_buf_puts(out, "row");
    write_csv_line(NULL, keys, kind->columns, out);
    json_array_foreach(rows, i, row)
    {
        pen_buf_printf(out, "%zu", i);
        write_csv_line(row, keys, kind->columns, out);
    }
    json_decref(rows);
}
