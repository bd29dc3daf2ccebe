/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Sockets and multipart messages of protocol/PROTOCOL.md, without their meaning. */
#ifndef SCREE_CLIENT_WIRE_H
#define SCREE_CLIENT_WIRE_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stdint.h>
#include <zmq.h>

#include "cli.h"

enum { WIRE_FRAMES_MAX = 3, WIRE_ENDPOINT_MAX = 256 };

/* Refuses what is neither ipc://PATH nor tcp://HOST:PORT. */
enum outcome wire_endpoint_check(const char *endpoint, struct scree_error *err);

/* Tries the socket behind an endpoint: nobody there, or nobody who lets us in, is
 * known at once, while ZeroMQ itself would go on trying for ever. */
enum outcome wire_probe(const char *endpoint, struct scree_error *err);

/* A DEALER connected to `endpoint`, NULL on lack of resources (or of keys, which
 * wire_probe tells of). Messages above `message_max` bytes are not accepted. */
void *wire_connect(void *context, const char *endpoint, int64_t message_max);

/* Sends version, header and, when not NULL, body. Never waits: false when it cannot be sent. */
bool wire_send(void *socket, const cJSON *header, const cJSON *body);

struct wire_message {
    zmq_msg_t frames[WIRE_FRAMES_MAX];
    int count;
    cJSON *header; // of the second frame
};

/* Waits up to `milliseconds` for a well-formed message of this protocol's
 * version; what is not one is thrown away. Release it with wire_release. */
bool wire_receive(void *socket, int milliseconds, struct wire_message *message);
void wire_release(struct wire_message *message);

#endif
