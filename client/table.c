/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See table.h. Rows are kept until the end because widths are known only then. */
#include "table.h"

#include <stdlib.h>
#include <string.h>

static void add_cells(struct table *table, const char *const *cells, enum colour colour)
{
    if (table->rows == table->room) {
        size_t room = table->room ? 2 * table->room : 16;
        char **grown = realloc(table->cells, room * (size_t)table->columns * sizeof *grown);
        if (grown)
            table->cells = grown;
        enum colour *colours = realloc(table->colours, room * sizeof *colours);
        if (colours)
            table->colours = colours;
        if (!grown || !colours)
            return; // without memory a table stays shorter
        table->room = room;
    }
    for (int c = 0; c < table->columns; c++)
        table->cells[table->rows * (size_t)table->columns + (size_t)c] = strdup(cells[c] && *cells[c] ? cells[c] : "-");
    table->colours[table->rows++] = colour;
}

void table_start(struct table *table, const char *const *headers)
{
    const char *names[TABLE_COLUMNS_MAX];
    *table = (struct table){0};
    for (; headers[table->columns] && table->columns < TABLE_COLUMNS_MAX; table->columns++) {
        const char *name = headers[table->columns];
        table->right[table->columns] = *name == '>';
        names[table->columns] = name + (*name == '>');
    }
    add_cells(table, names, COLOUR_BOLD);
}

void table_row(struct table *table, const char *const *cells, enum colour colour)
{
    add_cells(table, cells, colour);
}

static const char *cell_at(const struct table *table, size_t row, int column)
{
    const char *text = table->cells[row * (size_t)table->columns + (size_t)column];
    return text ? text : "-";
}

static void print_cell(const struct table *table, size_t row, int column, int width)
{
    const char *text = cell_at(table, row, column);
    bool last = column + 1 == table->columns;
    enum colour colour = row == 0 ? COLOUR_BOLD : column == 1 ? table->colours[row] : COLOUR_NONE;
    int padding = width - text_width(text);
    if (table->right[column])
        printf("%*s", padding, "");
    fputs(colour_on(stdout, colour), stdout);
    put_clean(stdout, text);
    fputs(colour_off(stdout, colour), stdout);
    if (!last)
        printf("%*s", (table->right[column] ? 0 : padding) + 2, "");
}

void table_end(struct table *table, int indent)
{
    int widths[TABLE_COLUMNS_MAX] = {0};
    for (size_t r = 0; r < table->rows; r++)
        for (int c = 0; c < table->columns; c++) {
            int width = text_width(cell_at(table, r, c));
            widths[c] = width > widths[c] ? width : widths[c];
        }
    for (size_t r = 0; r < table->rows; r++) {
        printf("%*s", indent, "");
        for (int c = 0; c < table->columns; c++)
            print_cell(table, r, c, widths[c]);
        putchar('\n');
    }
    for (size_t k = 0; k < table->rows * (size_t)table->columns; k++)
        free(table->cells[k]);
    free(table->cells);
    free(table->colours);
    *table = (struct table){0};
}
