/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Field tables: every parameter is said once.
 *
 * One row (name with unit, type, range, default, doc, offset) drives JSON
 * decoding and encoding, the messages of refusals, the help of
 * `scree scenarios`, checkpoints and HDF5 attributes. A table describes a plain
 * struct; tables nest through FIELD_GROUP. Nothing here knows JSON. */
#ifndef SCREE_SPEC_FIELD_H
#define SCREE_SPEC_FIELD_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#include "base/status.h"

enum field_type {
    FIELD_REAL,  // double; finite, within [min, max]
    FIELD_INT,   // int64_t; a JSON number without fraction, within [min, max]; |value| <= 2^53
    FIELD_BOOL,  // bool
    FIELD_TEXT,  // char[size]; UTF-8 without control characters, at most size - 1 bytes
    FIELD_VEC3,  // double[3]; a JSON array of three numbers, each within [min, max]
    FIELD_ROWS,  // struct of an int64_t count and double[size][columns]; a JSON array of at most `size` arrays of numbers
    FIELD_ENUM,  // int; a JSON string out of `choices`, stored as its index
    FIELD_FLAGS, // unsigned; a JSON array of distinct strings out of `choices`, stored as bits 1 << index
    FIELD_GROUP, // a nested struct described by `table`
    FIELD_SWITCH // a nested struct whose first member is `bool on`: JSON null is off, {} is on with defaults
};

struct field_table;

struct field {
    const char *name; // the JSON key, with its unit: "slope_deg"
    enum field_type type;
    size_t offset;           // in the struct that the table describes
    size_t size;             // FIELD_TEXT: bytes, with the terminating zero; FIELD_ROWS: rows there is room for
    size_t columns;          // FIELD_ROWS: numbers in a row
    double min, max;         // FIELD_REAL, _INT, _VEC3, _ROWS: the allowed closed range
    double preset;           // FIELD_REAL, _INT, _BOOL, _VEC3 (each component), _ENUM (index), _FLAGS (bits), _SWITCH (on): default
    const char *preset_text; // FIELD_TEXT: default, NULL is ""
    const char *unit;        // as printed behind a value: "deg", "m", "Pa", "grain diameters", "" if none
    const char *doc;         // one line for help
    const char *source;      // paper and equation or table, "" if ours
    const char *const *choices;      // FIELD_ENUM, FIELD_FLAGS: NULL-terminated words
    const struct field_table *table; // FIELD_GROUP, FIELD_SWITCH
    bool steerable;                  // may be changed while the job runs
    bool aside;                      // changes no bit of what the job computes: titles, threads, priority
};

/* Of a FIELD_ROWS: how many rows there are, and their numbers, row by row. */
static inline int64_t field_rows_count(const void *value)
{
    return *(const int64_t *)value;
}
static inline double *field_rows_numbers(void *value)
{
    return (double *)(void *)((int64_t *)value + 1);
}
static inline const double *field_rows_numbers_const(const void *value)
{
    return (const double *)(const void *)((const int64_t *)value + 1);
}

struct field_table {
    const char *name; // of the struct, for messages: "material"
    const char *doc;
    const struct field *fields;
    size_t count;
    size_t size; // sizeof the struct
};

/* Writes every default of the table, nested ones too, into *object. */
void field_defaults(const struct field_table *table, void *object);

/* The row of that exact name, or NULL. */
const struct field *field_find(const struct field_table *table, const char *name);

/* The known name nearest to `name` by edit distance, or NULL when none is near
 * enough to be meant (distance above a third of its length, at least 2, and
 * below the length: "ab" is no "nx"). */
const char *field_nearest(const struct field_table *table, const char *name);

/* The same over a NULL-terminated list of words. */
const char *word_nearest(const char *const *words, const char *word);

/* Bytes of a plain value; 0 of texts, and of groups, whose parts are values of their own. */
size_t field_value_size(const struct field *row);

/* Checks every value of *object against its row's range and type.
 * `path` prefixes the names in the message ("params"). The message has the form
 * `params.slope_deg: 123 is outside 0..60 deg`. */
enum scree_status field_check(const struct field_table *table, const void *object, const char *path, struct scree_error *err);

/* True when the objects differ at most in what is aside. */
bool field_same(const struct field_table *table, const void *a, const void *b);

/* SCREE_INVALID names the first value in which the two objects differ that is
 * neither steerable nor aside. `table` describes both. */
enum scree_status field_steer_check(const struct field_table *table, const void *from, const void *to, const char *path,
                                    struct scree_error *err);

/* One value by its dotted path below the table ("basal_force.every_s"): finds
 * row and address. SCREE_INVALID names the unknown part and the nearest known. */
enum scree_status field_resolve(const struct field_table *table, void *object, const char *dotted, const struct field **row,
                                void **address, struct scree_error *err);

#endif
