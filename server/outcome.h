/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a run has come to, between struct and JSON. */
#ifndef SCREE_SERVER_OUTCOME_H
#define SCREE_SERVER_OUTCOME_H

#include "job.h"
#include "protocol/json.h"

enum { OUTCOME_PAPER_MAX = 2 * SPEC_PAPER_MAX };

cJSON *outcome_json(const struct run_report *report);
/* Text that cannot be read gives an empty report. */
void outcome_read(const char *text, struct run_report *report);

/* A text of the spec's `paper`: what stands there for "{name}" is that number's value, "-" while there is none. */
void outcome_fill(const char *text, const struct scree_number *numbers, size_t count, char out[OUTCOME_PAPER_MAX]);

/* The hash of the last state as 16 hexadecimal digits. */
enum { OUTCOME_HASH_MAX = 24 };
char *outcome_hash(const struct run_report *report, char out[OUTCOME_HASH_MAX]);

#endif
