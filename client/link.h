/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A connection to a daemon's control socket: request and reply.
 *
 * No call waits for ever. A daemon that has gone is known within two seconds, one
 * that is there but silent is given up after LINK_SILENCE_S; a request without
 * an answer is sent again under the same id, which the daemon takes for the
 * same request. */
#ifndef SCREE_CLIENT_LINK_H
#define SCREE_CLIENT_LINK_H

#include "protocol/json.h"
#include "wire.h"

struct link;

enum { LINK_RETRY_S = 2, LINK_SILENCE_S = 10, LINK_SLOW_S = 1800 };

/* The endpoint to use: --connect, $SCREE_CONNECT, else the default one. *chosen
 * says whether somebody chose it. */
enum outcome link_endpoint(const char *connect, char endpoint[WIRE_ENDPOINT_MAX], bool *chosen, struct scree_error *err);

/* Connects. OUTCOME_UNREACHABLE when nobody listens there. */
enum outcome link_open(const char *endpoint, struct link **out, struct scree_error *err);
/* link_endpoint and link_open together, for verbs that only need a daemon. */
enum outcome link_open_for(const struct arguments *arguments, struct link **out, struct scree_error *err);
void link_close(struct link *link);

/* Asks and waits for the answer. `body` is taken over (NULL: {}), *result is the caller's. */
enum outcome link_request(struct link *link, const char *op, cJSON *body, cJSON **result, struct scree_error *err);

/* The same for an operation that may take minutes, during which the daemon answers pings. `once`: it must not be
 * started twice; others go out again when their answer may have been lost. */
enum outcome link_request_slow(struct link *link, const char *op, bool once, cJSON *body, cJSON **result, struct scree_error *err);

/* One request about one job: the body is {"job": job}. */
enum outcome link_job(struct link *link, const char *op, const char *job, cJSON **result, struct scree_error *err);

/* One ping that waits at most `seconds`. */
enum outcome link_ping(struct link *link, double seconds, cJSON **result, struct scree_error *err);

/* A DEALER on the daemon's stream socket; the caller closes it with zmq_close. */
enum outcome link_stream_socket(struct link *link, void **socket, struct scree_error *err);

/* Requests are given up once this many interrupts have been caught (2 at first). */
void link_abort_at(struct link *link, int interrupts);

#endif
