/* SPDX-License-Identifier: MIT */
#include "study/internal/grid.h"

#include <stdlib.h>
#include <string.h>

static const json_t *settings_of(const json_t *row)
{
    return json_object_get(row, "settings");
}

static size_t count_columns(const struct pen_column *columns)
{
    size_t count = 0;
    while (columns[count].title)
        count++;
    return count;
}

static struct pen_buf *at(struct pen_grid *grid, size_t row, size_t column)
{
    return &grid->cell[row * grid->columns + column];
}

const char *pen_grid_text(const struct pen_grid *grid, size_t row, size_t column)
{
    const struct pen_buf *cell = &grid->cell[row * grid->columns + column];
    return cell->data ? (const char *)cell->data : "";
}

static void write_titles(const json_t *first, const struct pen_column *columns,
                         struct pen_grid *grid)
{
    const char *key;
    json_t *value;
    size_t column = 0;
    pen_buf_puts(at(grid, 0, column++), "row");
    json_object_foreach((json_t *)(uintptr_t)settings_of(first), key, value)
    {
        grid->words[column] = json_is_string(value);
        pen_buf_puts(at(grid, 0, column++), key);
    }
    for (; columns->title; columns++) {
        grid->words[column] = columns->write == pen_write_picture;
        pen_buf_puts(at(grid, 0, column++), columns->title);
    }
}

/* `keys` are the first row's settings: all rows have the same. */
static void write_row(const json_t *row, const json_t *keys, const struct pen_column *columns,
                      struct pen_grid *grid, size_t number)
{
    const char *key;
    json_t *value;
    size_t column = 0;
    pen_buf_printf(at(grid, number + 1, column++), "%zu", number);
    json_object_foreach((json_t *)(uintptr_t)keys, key, value)
    {
        struct pen_buf *cell = at(grid, number + 1, column++);
        if (strcmp(key, "threads") == 0)
            pen_write_threads(row, cell);
        else
            pen_write_value(json_object_get(settings_of(row), key), cell);
    }
    for (; columns->title; columns++)
        columns->write(row, at(grid, number + 1, column++));
}

bool pen_grid_make(const json_t *report, const struct pen_column *columns, struct pen_grid *grid)
{
    size_t rows = pen_study_row_count(report);
    const json_t *keys = settings_of(pen_study_row(report, 0));
    *grid = (struct pen_grid){.rows = rows + 1,
                              .columns = 1 + json_object_size(keys) + count_columns(columns)};
    grid->cell = calloc(grid->rows * grid->columns, sizeof *grid->cell);
    grid->words = calloc(grid->columns, sizeof *grid->words);
    if (!grid->cell || !grid->words)
        return false;
    write_titles(pen_study_row(report, 0), columns, grid);
    for (size_t i = 0; i < rows; i++)
        write_row(pen_study_row(report, i), keys, columns, grid, i);
    for (size_t i = 0; i < grid->rows * grid->columns; i++) {
        if (grid->cell[i].failed)
            return false;
    }
    return true;
}

void pen_grid_release(struct pen_grid *grid)
{
    for (size_t i = 0; grid->cell && i < grid->rows * grid->columns; i++)
        pen_buf_release(&grid->cell[i]);
    free(grid->cell);
    free(grid->words);
    *grid = (struct pen_grid){0};
}
