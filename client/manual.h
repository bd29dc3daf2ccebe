/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The manual page scree(1) and the completion for bash, out of the verbs' own
 * descriptors: the tables that drive --help and refuse wrong options. */
#ifndef SCREE_CLIENT_MANUAL_H
#define SCREE_CLIENT_MANUAL_H

#include "cli.h"

/* `verbs` ends with NULL. `notes` is the part of --help that belongs to no verb. */
void manual_print(const struct verb *const *verbs, const char *notes);
void completion_print(const struct verb *const *verbs);

#endif
