/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One steering command to the daemon, for `cancel`, `pause`, `resume`, `checkpoint`, `set` and `fork`. */
#ifndef SCREE_CLIENT_STEER_H
#define SCREE_CLIENT_STEER_H

#include "link.h"

/* Sends `op` about a job and waits until it has taken effect, or waits in the
 * journal for a job that is not running. `set`: the assignments, NULL for none; taken over. */
enum outcome steer(struct link *link, const char *op, const char *job, cJSON *set, cJSON **result, struct scree_error *err);

/* A verb that takes job ids and nothing else: prints `ID STATE`, and the step on a second look with --json. */
enum outcome steer_each(const struct arguments *arguments, const char *op);

/* "step 12345", or "when the job goes on" for a command that waits. */
const char *steer_when(const cJSON *result, char *out, size_t size);

#endif
