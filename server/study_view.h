/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A study as JSON: summary, record, table of trials; and as files. */
#ifndef SCREE_SERVER_STUDY_VIEW_H
#define SCREE_SERVER_STUDY_VIEW_H

#include "study.h"

/* As in lists. */
cJSON *study_summary(const struct study *study);
/* As `show` has it: summary, spec, answers, bracket history, every trial, or only those on their way. */
cJSON *study_record(const struct study *study, bool open_only);

/* {"columns": [{"name", "unit"}], "rows": [[...]]}: a row a trial; what trials differ in, how each ended, its
 * summary numbers, and in a search the bracket after its round. A value that there is not is null. */
cJSON *study_table(const struct study *study);

/* The table as text: comma-separated, names with units in the first line. NULL on lack of memory. */
char *study_csv(const cJSON *table);

#endif
