/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Field tables and values for people to read. */
#ifndef SCREE_CLIENT_DESCRIBE_H
#define SCREE_CLIENT_DESCRIBE_H

#include "output.h"
#include "spec/spec.h"

/* Prints a table of fields with the values of *object as defaults: name, default,
 * range, unit, meaning, source; nested tables by dotted names. Rows that a running
 * job lets one change carry a '*'. */
void describe_fields(const struct field_table *table, const void *object, const char *prefix);

/* Prints a paragraph broken at `width` columns, every line indented. */
void describe_paragraph(const char *text, int indent, int width);

#endif
