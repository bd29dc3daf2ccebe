/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See limits.h. Counted where they are kept, every time: there is no tally that
 * could go wrong over a restart. */
#include "limits.h"

#include <stdio.h>
#include <string.h>

void limits_request(const struct user *user, const char *id, char out[LIMITS_REQUEST_MAX])
{
    snprintf(out, LIMITS_REQUEST_MAX, "%s%s%s", user->name, user->network ? "/" : "", id);
}

enum scree_status limits_check(const struct user *user, size_t count, int most, const char *what, struct scree_error *err)
{
    if (!user->network || count < (size_t)most)
        return SCREE_OK;
    return scree_fail(err, SCREE_BUSY, "", "%s has %zu %s, and %d are allowed; try again later", user->name, count, what, most);
}

enum scree_status limits_check_jobs(const struct config *config, struct scheduler *scheduler, const struct user *user,
                                    const char *request, struct scree_error *err)
{
    size_t length = strlen(user->name), own = 0;
    if (!user->network)
        return SCREE_OK;
    for (size_t k = 0; k < scheduler_count(scheduler); k++) {
        const struct job *job = scheduler_at(scheduler, k);
        if (strcmp(job->request, request) == 0)
            return SCREE_OK; // asked again: the answer is that job
        own += !job_state_ended(job->state) && strncmp(job->request, user->name, length) == 0 && job->request[length] == '/';
    }
    return limits_check(user, own, config->max_jobs, "jobs waiting or running", err);
}
