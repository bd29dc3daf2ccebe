/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Who is it, and what may they do.
 *
 * Two ways lead in. Sockets in the runtime directory (mode 0700): whoever can open
 * them is the daemon's owner and may do everything. The network, behind the gate
 * (gate.h): CURVE, and only keys on the trusted list. Both sorts of connection
 * pass the same handler (ZeroMQ RFC 27) with an enforced domain, and it gives each
 * a user id which comes back with every message: a message without one, whatever
 * way it found in, is nobody's and is refused. */
#ifndef SCREE_SERVER_AUTH_H
#define SCREE_SERVER_AUTH_H

#include <zmq.h>

#include "config.h"
#include "protocol/keys.h"

/* Refuses what is not ipc:///absolute/path. */
enum scree_status auth_check_endpoint(const char *endpoint, struct scree_error *err);
/* Refuses what is not tcp://ADDRESS:PORT with a port that leaves room for two more. */
enum scree_status auth_check_network(const char *endpoint, struct scree_error *err);

/* Makes the runtime directory with mode 0700, or accepts one that is ours and has it. */
enum scree_status auth_runtime_dir(const char *path, struct scree_error *err);

struct auth;

struct user {
    enum role role;
    bool network;            // else the owner of the runtime directory
    char name[KEY_NAME_MAX]; // as on the list of trusted keys; "" for the owner
};

/* Binds the handler; before any other socket of the context. Reads the daemon's key
 * and the list of trusted ones if config->network is set. */
enum scree_status auth_open(struct auth **out, void *context, const struct config *config, struct scree_error *err);
void auth_close(struct auth *auth);

/* The handler's socket, to be polled, and its turn: answers the handshakes that wait. */
void *auth_socket(struct auth *auth);
void auth_turn(struct auth *auth);

/* Makes connections to what `socket` binds next be the owner's, or prove a trusted key. */
enum scree_status auth_guard_local(void *socket, struct scree_error *err);
enum scree_status auth_guard_network(const struct auth *auth, void *socket, struct scree_error *err);

/* Whose message this frame came with, by the list as it stands now. ROLE_NONE: nobody's, or no longer trusted. */
struct user auth_user(struct auth *auth, zmq_msg_t *frame);

/* SCREE_DENIED, with the role that is missing, unless the user may carry out the operation. */
enum scree_status auth_permit(const struct user *user, const char *op, struct scree_error *err);

#endif
