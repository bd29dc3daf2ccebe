/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See describe.h. */
#include "describe.h"

#include <math.h>
#include <string.h>

#include "base/text.h"
#include "table.h"

enum { CELL_MAX = 256 };

static void value_text(const struct field *row, const void *value, char out[CELL_MAX])
{
    char number[TEXT_REAL_MAX];
    *out = 0;
    switch (row->type) {
    case FIELD_REAL:
        snprintf(out, CELL_MAX, "%s", text_real(*(const double *)value, number));
        break;
    case FIELD_INT:
        snprintf(out, CELL_MAX, "%lld", (long long)*(const int64_t *)value);
        break;
    case FIELD_BOOL:
        snprintf(out, CELL_MAX, "%s", *(const bool *)value ? "true" : "false");
        break;
    case FIELD_TEXT:
        snprintf(out, CELL_MAX, "\"%s\"", (const char *)value);
        break;
    case FIELD_VEC3:
        for (int a = 0; a < 3; a++)
            snprintf(out + strlen(out), CELL_MAX - strlen(out), "%s%s%s", a ? ", " : "[",
                     text_real(((const double *)value)[a], number), a == 2 ? "]" : "");
        break;
    case FIELD_ROWS:
        snprintf(out, CELL_MAX, field_rows_count(value) ? "%lld rows" : "[]", (long long)field_rows_count(value));
        break;
    case FIELD_ENUM:
        snprintf(out, CELL_MAX, "\"%s\"", row->choices[*(const int *)value]);
        break;
    case FIELD_FLAGS:
        snprintf(out, CELL_MAX, "[");
        for (int k = 0; row->choices[k]; k++)
            if (*(const unsigned *)value >> k & 1)
                snprintf(out + strlen(out), CELL_MAX - strlen(out), "%s\"%s\"", out[1] ? ", " : "", row->choices[k]);
        snprintf(out + strlen(out), CELL_MAX - strlen(out), "]");
        break;
    case FIELD_SWITCH:
        snprintf(out, CELL_MAX, "%s", *(const bool *)value ? "on" : "off");
        break;
    case FIELD_GROUP:
        break;
    }
}

static void range_text(const struct field *row, char out[CELL_MAX])
{
    char low[TEXT_REAL_MAX], high[TEXT_REAL_MAX];
    *out = 0;
    if (row->type == FIELD_REAL || row->type == FIELD_INT || row->type == FIELD_VEC3 || row->type == FIELD_ROWS)
        snprintf(out, CELL_MAX, "%s..%s", text_real(row->min, low), text_real(row->max, high));
    else if (row->type == FIELD_SWITCH)
        snprintf(out, CELL_MAX, "{} or null");
    else if (row->type == FIELD_BOOL)
        snprintf(out, CELL_MAX, "true, false");
    else if (row->type == FIELD_TEXT)
        snprintf(out, CELL_MAX, "%zu bytes", row->size - 1);
    for (int k = 0; row->choices && row->choices[k]; k++)
        snprintf(out + strlen(out), CELL_MAX - strlen(out), "%s%s", k ? ", " : "", row->choices[k]);
}

static void add_rows(struct table *out, const struct field_table *table, const void *object, const char *prefix)
{
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        const void *value = (const char *)object + row->offset;
        char name[CELL_MAX], preset[CELL_MAX], range[CELL_MAX], marked[CELL_MAX];
        snprintf(name, sizeof name, "%s%s%s", prefix, *prefix ? "." : "", row->name);
        if (row->type != FIELD_GROUP) {
            value_text(row, value, preset);
            range_text(row, range);
            snprintf(marked, sizeof marked, "%.200s%s", name, row->steerable ? " *" : "");
            const char *const cells[] = {marked, preset, range, row->unit, row->doc, row->source};
            table_row(out, cells, COLOUR_NONE);
        }
        if (row->table)
            add_rows(out, row->table, value, name);
    }
}

void describe_fields(const struct field_table *table, const void *object, const char *prefix)
{
    static const char *const headers[] = {"field", "default", "range", "unit", "meaning", "source", NULL};
    struct table out;
    table_start(&out, headers);
    add_rows(&out, table, object, prefix);
    table_end(&out, 2);
}

void describe_paragraph(const char *text, int indent, int width)
{
    int column = 0;
    while (*text) {
        char word[CELL_MAX];
        size_t length = strcspn(text, " ");
        snprintf(word, sizeof word, "%.*s", (int)length, text);
        if (column > indent && column + 1 + text_width(word) > width) {
            putchar('\n');
            column = 0;
        }
        if (column == 0)
            column = printf("%*s", indent, "");
        else if (column > indent)
            column += printf(" ");
        put_clean(stdout, word);
        column += text_width(word);
        text += length + strspn(text + length, " ");
    }
    putchar('\n');
}
