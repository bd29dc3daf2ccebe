/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a person wants to know of a job that has ended. */
#ifndef SCREE_CLIENT_SUMMARY_H
#define SCREE_CLIENT_SUMMARY_H

#include "protocol/json.h"

/* Prints the record of `show`: verdict and evidence, size and rate, the
 * scenario's numbers, and `file`, where the result lies (NULL: nowhere). */
void summary_print(const cJSON *record, const char *file);

/* "grain 17 went through the base" of a record's error, "" if there is none. */
const char *summary_error(const cJSON *record);

#endif
