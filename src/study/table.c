/* SPDX-License-Identifier: MIT */
/* Makes the cells of a table. Columns of words are recognised by their type: settings that are
 * strings, and the columns that say so. */
#include "study/internal/table.h"

#include <stdlib.h>
#include <string.h>

static const json_t *settings_of(const json_t *row)
{
    return json_object_get(row, "settings");
}

static size_t count_columns(const struct pen_bench_column *columns)
{
    size_t count = 0;
    while (columns[count].title)
        count++;
    return count;
}

static struct pen_buf *at(struct pen_bench_table *table, size_t row, size_t column)
{
    return &table->cell[row * table->columns + column];
}

const char *pen_bench_table_cell(const struct pen_bench_table *table, size_t row, size_t column)
{
    const struct pen_buf *cell = &table->cell[row * table->columns + column];
    return cell->data ? (const char *)cell->data : "";
}

static void write_titles(const json_t *first, const struct pen_bench_column *columns,
                         struct pen_bench_table *table)
{
    const char *key;
    json_t *value;
    size_t column = 0;
    pen_buf_puts(at(table, 0, column++), "row");
    json_object_foreach((json_t *)(uintptr_t)settings_of(first), key, value)
    {
        table->is_text[column] = json_is_string(value);
        pen_buf_puts(at(table, 0, column++), key);
    }
    for (; columns->title; columns++) {
        table->is_text[column] = columns->words;
        pen_buf_puts(at(table, 0, column++), columns->title);
    }
}

/* `keys` are the settings of the first row; all rows have the same keys. */
static void write_row(const json_t *row, const json_t *keys, const struct pen_bench_column *columns,
                      struct pen_bench_table *table, size_t number)
{
    const char *key;
    json_t *value;
    size_t column = 0;
    pen_buf_printf(at(table, number + 1, column++), "%zu", number);
    json_object_foreach((json_t *)(uintptr_t)keys, key, value)
    {
        struct pen_buf *cell = at(table, number + 1, column++);
        if (strcmp(key, "threads") == 0)
            pen_bench_write_threads(row, cell);
        else
            pen_bench_write_value(json_object_get(settings_of(row), key), cell);
    }
    for (; columns->title; columns++)
        pen_bench_column_write(columns, row, at(table, number + 1, column++));
}

bool pen_bench_table_init(const json_t *report, const struct pen_bench_column *columns,
                          struct pen_bench_table *table)
{
    size_t rows = pen_bench_report_row_count(report);
    const json_t *keys = settings_of(pen_bench_report_row(report, 0));
    *table = (struct pen_bench_table){
        .rows = rows + 1, .columns = 1 + json_object_size(keys) + count_columns(columns)};
    table->cell = calloc(table->rows * table->columns, sizeof *table->cell);
    table->is_text = calloc(table->columns, sizeof *table->is_text);
    if (!table->cell || !table->is_text)
        return false;
    write_titles(pen_bench_report_row(report, 0), columns, table);
    for (size_t i = 0; i < rows; i++)
        write_row(pen_bench_report_row(report, i), keys, columns, table, i);
    for (size_t i = 0; i < table->rows * table->columns; i++) {
        if (table->cell[i].failed)
            return false;
    }
    return true;
}

void pen_bench_table_release(struct pen_bench_table *table)
{
    for (size_t i = 0; table->cell && i < table->rows * table->columns; i++)
        pen_buf_release(&table->cell[i]);
    free(table->cell);
    free(table->is_text);
    *table = (struct pen_bench_table){0};
}
