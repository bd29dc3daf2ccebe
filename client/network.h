/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Connections to a daemon over the network: which keys, and why one fails. */
#ifndef SCREE_CLIENT_NETWORK_H
#define SCREE_CLIENT_NETWORK_H

#include "cli.h"
#include "wire.h"

bool network_endpoint(const char *endpoint); // tcp://

/* Refuses what is not tcp://HOST:PORT. */
enum outcome network_check(const char *endpoint, struct scree_error *err);

/* Gives an unconnected socket this user's keys ($SCREE_KEY, else client.key in the
 * folder of keys) and the daemon's public one ($SCREE_SERVER_KEY, a file or the
 * 40 characters, else server.pub there). */
enum outcome network_keys(void *socket, struct scree_error *err);

/* Tries a connection to its end, the proof of keys, since ZeroMQ itself goes on
 * trying in silence for ever. OUTCOME_UNREACHABLE: nobody there, or no scree;
 * OUTCOME_DENIED: one of the two keys is not the right one, and the message says which. */
enum outcome network_probe(const char *endpoint, struct scree_error *err);

/* A daemon names its stream endpoint as it listens, tcp://0.0.0.0:7002 perhaps: the
 * host is the one that was reached at `control`. */
enum outcome network_beside(const char *control, const char *named, char out[WIRE_ENDPOINT_MAX], struct scree_error *err);

#endif
