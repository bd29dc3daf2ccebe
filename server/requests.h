/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What each operation of the control socket does. */
#ifndef SCREE_SERVER_REQUESTS_H
#define SCREE_SERVER_REQUESTS_H

#include "auth.h"
#include "config.h"
#include "protocol/frame.h"
#include "studies.h"

struct daemon {
    const struct config *config;
    struct scheduler *scheduler;
    struct studies *studies;
    double started; // monotonic seconds
    bool ending;    // a shutdown was asked for
    uint64_t tickets;
    struct user user; // who sent the request that is being carried out
};

enum answer { ANSWER_NOW, ANSWER_LATER };

/* Carries out one request. Now: *reply is the reply, to be sent. Later: the reply
 * of ticket daemon->tickets comes through requests_fetched. */
enum answer requests_handle(struct daemon *daemon, const struct envelope *envelope, const cJSON *body, cJSON **reply);

/* Operations whose answer may come later. */
bool requests_may_wait(const char *op);

/* The result object of a steering command. */
cJSON *requests_steered(const struct job *job, const struct command *command);

/* The result object of a fetch. */
cJSON *requests_fetched(const struct job *job, const char *path);

/* A job's summary, as in lists and events. */
cJSON *requests_summary(const struct job *job);

/* A piece of the file of a job or a study, as `fetch_part` answers. */
enum scree_status requests_file_part(const char *id, const char *path, double offset, double bytes, cJSON **result,
                                     struct scree_error *err);

/* Bytes of memory that a new world may take. */
double requests_memory(void);

#endif
