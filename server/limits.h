/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What one user from the network may take of the daemon at a time. The owner has
 * no limits but those of the queue.
 *
 * Whose a job is stands in its request id, "NAME/ID", so that it is journalled
 * with the job and the ids of two users never meet: nobody gets the job of
 * another by guessing the id of its submit. */
#ifndef SCREE_SERVER_LIMITS_H
#define SCREE_SERVER_LIMITS_H

#include "auth.h"
#include "scheduler.h"

enum { LIMITS_REQUEST_MAX = JOB_REQUEST_MAX };

/* The id under which a submit of this user is journalled. */
void limits_request(const struct user *user, const char *id, char out[LIMITS_REQUEST_MAX]);

/* SCREE_BUSY if the user has config->max_jobs jobs that have not ended and `request` is not one of them. */
enum scree_status limits_check_jobs(const struct config *config, struct scheduler *scheduler, const struct user *user,
                                    const char *request, struct scree_error *err);

/* SCREE_BUSY if the user has `count` of `what`, and no more than `most` are allowed. */
enum scree_status limits_check(const struct user *user, size_t count, int most, const char *what, struct scree_error *err);

#endif
