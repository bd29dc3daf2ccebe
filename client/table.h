/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables of text on stdout, columns as wide as their widest cell. */
#ifndef SCREE_CLIENT_TABLE_H
#define SCREE_CLIENT_TABLE_H

#include <stdbool.h>
#include <stddef.h>

#include "output.h"

enum { TABLE_COLUMNS_MAX = 12 };

struct table {
    int columns;
    bool right[TABLE_COLUMNS_MAX]; // columns of numbers stand to the right
    size_t rows, room;
    char **cells; // rows * columns; row 0 is the header
    enum colour *colours;
};

/* `headers` is NULL-terminated; one that starts with '>' makes its column stand to the right. */
void table_start(struct table *table, const char *const *headers);
/* `cells`: one text a column, copied; NULL is "-". `colour` is that of the row's second cell. */
void table_row(struct table *table, const char *const *cells, enum colour colour);
/* Prints it, every line indented by `indent`, and frees it. */
void table_end(struct table *table, int indent);

#endif
