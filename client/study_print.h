/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a person wants to know of a study. */
#ifndef SCREE_CLIENT_STUDY_PRINT_H
#define SCREE_CLIENT_STUDY_PRINT_H

#include "protocol/json.h"

/* Prints the record of `show`: what it came to, its answers and their spread, the bracket round by round,
 * every trial; `file` and `text_file`: where its table lies (NULL: nowhere). */
void study_print(const cJSON *record, const char *file, const char *text_file);

#endif
