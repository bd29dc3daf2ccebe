/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The stream socket: subscriptions with credit, served out of the jobs' logs.
 * Past and present are one path: a subscription sends what the log has, as far
 * as its credit goes, and is looked at again when the log has grown. */
#ifndef SCREE_SERVER_STREAMS_H
#define SCREE_SERVER_STREAMS_H

#include "auth.h"
#include "scheduler.h"

struct streams;

/* `socket` is a bound ROUTER, owned by the caller. A user from the network has at most `per_user` subscriptions. */
enum scree_status streams_open(struct streams **out, void *socket, struct scheduler *scheduler, struct auth *auth, int per_user,
                               struct scree_error *err);
void streams_close(struct streams *streams);

/* Reads everything that has come in. */
void streams_receive(struct streams *streams);

/* Sends what can be sent; true when some subscription could go on at once (the
 * turn was cut short so that others are served, or a peer's queue was full). */
bool streams_send(struct streams *streams);

/* The job's log has grown, or its state has changed. */
void streams_changed(struct streams *streams, const struct job *job);

size_t streams_count(const struct streams *streams);

#endif
