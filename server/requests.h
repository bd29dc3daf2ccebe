/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What each operation of the control socket does. */
#ifndef SCREE_SERVER_REQUESTS_H
#define SCREE_SERVER_REQUESTS_H

#include "config.h"
#include "protocol/frame.h"
#include "scheduler.h"

struct daemon {
    const struct config *config;
    struct scheduler *scheduler;
    double started; // monotonic seconds
    bool ending;    // a shutdown was asked for
    uint64_t tickets;
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

/* Bytes of memory that a new world may take. */
double requests_memory(void);

#endif
