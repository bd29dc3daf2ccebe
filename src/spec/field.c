/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Defaults, look-up and range checks, for any table. */
#include "spec/field.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

static void *at(void *object, const struct field *row)
{
    return (char *)object + row->offset;
}

static const void *at_const(const void *object, const struct field *row)
{
    return (const char *)object + row->offset;
}

void field_defaults(const struct field_table *table, void *object)
{
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        void *value = at(object, row);
        switch (row->type) {
        case FIELD_REAL:
            *(double *)value = row->preset;
            break;
        case FIELD_INT:
            *(int64_t *)value = (int64_t)row->preset;
            break;
        case FIELD_BOOL:
            *(bool *)value = row->preset != 0;
            break;
        case FIELD_TEXT:
            snprintf(value, row->size, "%s", row->preset_text ? row->preset_text : "");
            break;
        case FIELD_VEC3:
            for (int a = 0; a < 3; a++)
                ((double *)value)[a] = row->preset;
            break;
        case FIELD_ROWS:
            memset(value, 0, field_value_size(row));
            break;
        case FIELD_ENUM:
            *(int *)value = (int)row->preset;
            break;
        case FIELD_FLAGS:
            *(unsigned *)value = (unsigned)row->preset;
            break;
        case FIELD_GROUP:
            field_defaults(row->table, value);
            break;
        case FIELD_SWITCH:
            field_defaults(row->table, value);
            *(bool *)value = row->preset != 0;
            break;
        }
    }
}

const struct field *field_find(const struct field_table *table, const char *name)
{
    for (size_t k = 0; k < table->count; k++)
        if (strcmp(table->fields[k].name, name) == 0)
            return &table->fields[k];
    return NULL;
}

/* Levenshtein's distance; words longer than the buffer are far from everything. */
static size_t distance(const char *a, const char *b)
{
    enum { LONGEST = 63 };
    size_t n = strlen(a), m = strlen(b), row[LONGEST + 1];
    if (n > LONGEST || m > LONGEST)
        return SIZE_MAX;
    for (size_t j = 0; j <= m; j++)
        row[j] = j;
    for (size_t i = 1; i <= n; i++) {
        size_t diagonal = row[0];
        row[0] = i;
        for (size_t j = 1; j <= m; j++) {
            size_t best = diagonal + (a[i - 1] != b[j - 1]);
            diagonal = row[j];
            best = row[j] + 1 < best ? row[j] + 1 : best;
            row[j] = row[j - 1] + 1 < best ? row[j - 1] + 1 : best;
        }
    }
    return row[m];
}

/* How far a word may be from what was meant; something of it must be left. */
static size_t tolerance(const char *word)
{
    size_t length = strlen(word), third = length / 3;
    if (length <= 2)
        return length ? length - 1 : 0;
    return third < 2 ? 2 : third;
}

const char *field_nearest(const struct field_table *table, const char *name)
{
    const char *nearest = NULL;
    size_t best = tolerance(name) + 1;
    for (size_t k = 0; k < table->count; k++) {
        size_t d = distance(name, table->fields[k].name);
        /* "slope" for "slope_deg": a whole name without its unit is meant, too. */
        size_t length = strlen(name);
        if (length > 1 && strncmp(name, table->fields[k].name, length) == 0 && table->fields[k].name[length] == '_')
            d = 1;
        if (d < best) {
            best = d;
            nearest = table->fields[k].name;
        }
    }
    return nearest;
}

const char *word_nearest(const char *const *words, const char *word)
{
    const char *nearest = NULL;
    size_t best = tolerance(word) + 1;
    for (; *words; words++) {
        size_t d = distance(word, *words);
        if (d < best) {
            best = d;
            nearest = *words;
        }
    }
    return nearest;
}

static void join(char out[SCREE_PATH_MAX], const char *path, const char *name)
{
    snprintf(out, SCREE_PATH_MAX, "%s%s%s", path, *path ? "." : "", name);
}

static enum scree_status outside(const struct field *row, const char *path, double value, struct scree_error *err)
{
    char v[TEXT_REAL_MAX], low[TEXT_REAL_MAX], high[TEXT_REAL_MAX];
    scree_fail(err, SCREE_INVALID, path, "%s: %s is outside %s..%s%s%s", path, text_real(value, v), text_real(row->min, low),
               text_real(row->max, high), *row->unit ? " " : "", row->unit);
    scree_hint(err, "%s: %s", row->name, row->doc);
    return SCREE_INVALID;
}

static enum scree_status check_number(const struct field *row, const char *path, double value, struct scree_error *err)
{
    return value >= row->min && value <= row->max ? SCREE_OK : outside(row, path, value, err);
}

static size_t count_words(const char *const *words)
{
    size_t count = 0;
    while (words[count])
        count++;
    return count;
}

static enum scree_status check_row(const struct field *row, const void *value, const char *path, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    switch (row->type) {
    case FIELD_REAL:
        return check_number(row, path, *(const double *)value, err);
    case FIELD_INT:
        return check_number(row, path, (double)*(const int64_t *)value, err);
    case FIELD_VEC3:
        for (int a = 0; a < 3 && !status; a++) {
            char part[SCREE_PATH_MAX];
            snprintf(part, sizeof part, "%s[%d]", path, a);
            status = check_number(row, part, ((const double *)value)[a], err);
        }
        return status;
    case FIELD_ROWS:
        if (field_rows_count(value) < 0 || (size_t)field_rows_count(value) > row->size)
            return scree_fail(err, SCREE_INVALID, path, "%s: %lld rows, of at most %zu", path, (long long)field_rows_count(value),
                              row->size);
        for (size_t k = 0; k < (size_t)field_rows_count(value) * row->columns && !status; k++) {
            char part[SCREE_PATH_MAX];
            snprintf(part, sizeof part, "%.200s[%zu][%zu]", path, k / row->columns, k % row->columns);
            status = check_number(row, part, field_rows_numbers_const(value)[k], err);
        }
        return status;
    case FIELD_GROUP:
    case FIELD_SWITCH:
        return field_check(row->table, value, path, err);
    case FIELD_ENUM:
        if (*(const int *)value < 0 || (size_t) * (const int *)value >= count_words(row->choices))
            return scree_fail(err, SCREE_INVALID, path, "%s: there is no choice number %d", path, *(const int *)value);
        break;
    case FIELD_FLAGS:
        if (*(const unsigned *)value >> count_words(row->choices))
            return scree_fail(err, SCREE_INVALID, path, "%s: there is no choice for the bits %#x", path, *(const unsigned *)value);
        break;
    case FIELD_BOOL:
    case FIELD_TEXT:
        break;
    }
    return SCREE_OK;
}

enum scree_status field_check(const struct field_table *table, const void *object, const char *path, struct scree_error *err)
{
    for (size_t k = 0; k < table->count; k++) {
        char full[SCREE_PATH_MAX];
        join(full, path, table->fields[k].name);
        enum scree_status status = check_row(&table->fields[k], at_const(object, &table->fields[k]), full, err);
        if (status)
            return status;
    }
    return SCREE_OK;
}

size_t field_value_size(const struct field *row)
{
    switch (row->type) {
    case FIELD_REAL:
        return sizeof(double);
    case FIELD_INT:
        return sizeof(int64_t);
    case FIELD_VEC3:
        return 3 * sizeof(double);
    case FIELD_ROWS:
        return sizeof(int64_t) + row->size * row->columns * sizeof(double);
    case FIELD_ENUM:
        return sizeof(int);
    case FIELD_FLAGS:
        return sizeof(unsigned);
    case FIELD_BOOL:
    case FIELD_SWITCH: // its first member says whether it is on
        return sizeof(bool);
    case FIELD_TEXT:
    case FIELD_GROUP:
        break;
    }
    return 0;
}

/* Of a group and a switch only what they are, not their parts. */
static bool row_same(const struct field *row, const void *a, const void *b)
{
    return row->type == FIELD_TEXT ? strcmp(a, b) == 0 : memcmp(a, b, field_value_size(row)) == 0;
}

bool field_same(const struct field_table *table, const void *a, const void *b)
{
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        const void *x = at_const(a, row), *y = at_const(b, row);
        bool off = row->type == FIELD_SWITCH && !*(const bool *)x;
        if (!row->aside && (!row_same(row, x, y) || (row->table && !off && !field_same(row->table, x, y))))
            return false;
    }
    return true;
}

enum scree_status field_steer_check(const struct field_table *table, const void *from, const void *to, const char *path,
                                    struct scree_error *err)
{
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        const void *old = at_const(from, row), *new = at_const(to, row);
        char full[SCREE_PATH_MAX];
        join(full, path, row->name);
        if (!row_same(row, old, new) && !row->steerable && !row->aside)
            return scree_fail(err, SCREE_INVALID, full, "%s: cannot be changed once a job has begun", full);
        bool off = row->type == FIELD_SWITCH && !*(const bool *)old;
        enum scree_status status = row->table && !off ? field_steer_check(row->table, old, new, full, err) : SCREE_OK;
        if (status)
            return status;
    }
    return SCREE_OK;
}

enum scree_status field_resolve(const struct field_table *table, void *object, const char *dotted, const struct field **row,
                                void **address, struct scree_error *err)
{
    for (const char *rest = dotted;;) {
        char name[64];
        size_t length = strcspn(rest, ".");
        snprintf(name, sizeof name, "%.*s", (int)length, rest);
        *row = length < sizeof name ? field_find(table, name) : NULL;
        if (!*row) {
            const char *near = field_nearest(table, name);
            return scree_fail(err, SCREE_INVALID, dotted, "%s: unknown key%s%s%s", dotted, near ? "; did you mean \"" : "",
                              near ? near : "", near ? "\"?" : "");
        }
        *address = at(object, *row);
        if (!rest[length])
            return SCREE_OK;
        if (!(*row)->table)
            return scree_fail(err, SCREE_INVALID, dotted, "%s: \"%s\" has no parts", dotted, name);
        table = (*row)->table;
        object = *address;
        rest += length + 1;
    }
}
