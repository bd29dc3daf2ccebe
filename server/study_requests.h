/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the operations of the control socket do when they are about a study. */
#ifndef SCREE_SERVER_STUDY_REQUESTS_H
#define SCREE_SERVER_STUDY_REQUESTS_H

#include "recorder.h"
#include "requests.h"

/* Whether a request is about a study: its spec is one, or its id is a study's ("s3"). */
bool study_request_is(const char *op, const cJSON *body);

/* Carries it out, as requests_handle does. */
enum answer study_request(struct daemon *daemon, const struct envelope *envelope, const cJSON *body, cJSON **reply);

/* The reply of a fetch whose file the recorder has written, or could not write. */
cJSON *study_recorded_reply(const char *request, const struct record_order *order);

/* Summaries, newest first; `wanted`: bits of states, 0 for all. */
cJSON *study_list(struct daemon *daemon, unsigned wanted, size_t limit);

#endif
