/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See network.h. */
#include "network.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <netdb.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <unistd.h>

#include "output.h"
#include "protocol/keys.h"
#include "signals.h"

enum { CONNECT_MS = 5000, HANDSHAKE_MS = 5000, TRIES = 3 };

bool network_endpoint(const char *endpoint)
{
    return strncmp(endpoint, "tcp://", 6) == 0;
}

enum outcome network_check(const char *endpoint, struct scree_error *err)
{
    const char *host = endpoint + strlen("tcp://"), *colon = strrchr(host, ':');
    char *end = NULL;
    long port = colon ? strtol(colon + 1, &end, 10) : 0;
    if (!colon || colon == host || end == colon + 1 || *end || port < 1 || port > 65535)
        return outcome_fail(err, OUTCOME_REFUSED, "%s: an endpoint on the network has the form tcp://HOST:PORT", endpoint);
    if (strlen(endpoint) >= WIRE_ENDPOINT_MAX)
        return outcome_fail(err, OUTCOME_REFUSED, "the endpoint has more than %d characters", WIRE_ENDPOINT_MAX - 1);
    return OUTCOME_DONE;
}

/* ---- keys ---- */

static enum outcome missing(enum outcome outcome, const char *hint, struct scree_error *err)
{
    struct scree_error plain = *err;
    outcome_fail(err, outcome, "%s", plain.message);
    scree_hint(err, "%s", *plain.hint ? plain.hint : hint);
    return outcome;
}

static enum outcome own_keys(struct key_pair *out, struct scree_error *err)
{
    char folder[PATH_MAX], path[PATH_MAX + 16];
    const char *chosen = getenv("SCREE_KEY");
    if (chosen && *chosen)
        snprintf(path, sizeof path, "%s", chosen);
    else if (keys_folder(folder, sizeof folder, err))
        return OUTCOME_REFUSED;
    else
        snprintf(path, sizeof path, "%s/client.key", folder);
    enum scree_status status = keys_read_pair(path, out, err);
    if (!status)
        return OUTCOME_DONE;
    return missing(OUTCOME_DENIED, "`scree keygen` makes one; the daemon's owner then trusts its client.pub", err);
}

static enum outcome server_key(char out[KEY_TEXT_MAX], char source[PATH_MAX], struct scree_error *err)
{
    char folder[PATH_MAX];
    struct key_pair pair;
    const char *chosen = getenv("SCREE_SERVER_KEY");
    snprintf(source, PATH_MAX, "%s", "$SCREE_SERVER_KEY");
    if (chosen && key_valid(chosen)) {
        memcpy(out, chosen, KEY_TEXT_MAX);
        return OUTCOME_DONE;
    }
    if (chosen && *chosen)
        snprintf(source, PATH_MAX, "%s", chosen);
    else if (keys_folder(folder, sizeof folder, err))
        return OUTCOME_REFUSED;
    else if (snprintf(source, PATH_MAX, "%s/server.pub", folder) >= PATH_MAX)
        return outcome_fail(err, OUTCOME_REFUSED, "the path of the folder of keys is too long");
    if (keys_read_public(source, &pair, err))
        return missing(OUTCOME_DENIED, "it is the daemon's server.pub: get it from its owner", err);
    memcpy(out, pair.public_key, KEY_TEXT_MAX);
    return OUTCOME_DONE;
}

enum outcome network_keys(void *socket, struct scree_error *err)
{
    struct key_pair own = {0};
    char server[KEY_TEXT_MAX], source[PATH_MAX];
    enum outcome outcome = own_keys(&own, err);
    if (!outcome)
        outcome = server_key(server, source, err);
    if (!outcome && (zmq_setsockopt(socket, ZMQ_CURVE_SERVERKEY, server, KEY_TEXT_MAX) ||
                     zmq_setsockopt(socket, ZMQ_CURVE_PUBLICKEY, own.public_key, KEY_TEXT_MAX) ||
                     zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, own.secret_key, KEY_TEXT_MAX)))
        outcome = outcome_fail(err, OUTCOME_FAILED, "this libzmq takes no keys: %s", zmq_strerror(errno));
    explicit_bzero(&own, sizeof own);
    return outcome;
}

/* ---- the probe ---- */

/* Whether one address takes a connection; else errno. */
static int try_address(const struct addrinfo *address)
{
    int fd = socket(address->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), why = 0;
    socklen_t size = sizeof why;
    if (fd < 0)
        return errno;
    if (connect(fd, address->ai_addr, address->ai_addrlen) != 0 && (why = errno) == EINPROGRESS) {
        struct pollfd wait = {.fd = fd, .events = POLLOUT};
        if (poll(&wait, 1, CONNECT_MS) <= 0)
            why = ETIMEDOUT;
        else
            getsockopt(fd, SOL_SOCKET, SO_ERROR, &why, &size);
    }
    close(fd);
    return why;
}

static enum outcome reach(const char *endpoint, struct scree_error *err)
{
    char host[WIRE_ENDPOINT_MAX];
    const char *address = endpoint + strlen("tcp://"), *colon = strrchr(address, ':');
    size_t length = (size_t)(colon - address);
    bool brackets = *address == '[' && length > 1 && colon[-1] == ']';
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM}, *found = NULL;
    snprintf(host, sizeof host, "%.*s", (int)(brackets ? length - 2 : length), address + brackets);
    int wrong = getaddrinfo(host, colon + 1, &hints, &found), why = ECONNREFUSED;
    if (wrong)
        return outcome_fail(err, OUTCOME_UNREACHABLE, "no daemon at %s (%s)", endpoint, gai_strerror(wrong));
    for (const struct addrinfo *a = found; a && why; a = a->ai_next)
        why = try_address(a);
    freeaddrinfo(found);
    if (why == 0)
        return OUTCOME_DONE;
    outcome_fail(err, OUTCOME_UNREACHABLE, "no daemon at %s (%s)", endpoint, strerror(why));
    scree_hint(err, "it listens there if it was started with --listen tcp://ADDRESS:PORT");
    return OUTCOME_UNREACHABLE;
}

enum handshake { HANDSHAKE_GOOD, HANDSHAKE_CLOSED, HANDSHAKE_REFUSED, HANDSHAKE_FOREIGN, HANDSHAKE_SILENT };

/* What a socket's monitor tells of its handshake. */
static enum handshake watch(void *monitor)
{
    for (double end = now_s() + 1e-3 * HANDSHAKE_MS; now_s() < end;) {
        zmq_pollitem_t item = {.socket = monitor, .events = ZMQ_POLLIN};
        unsigned char event[6];
        char address[256];
        if (zmq_poll(&item, 1, WAIT_SLICE_MS) <= 0)
            continue;
        if (zmq_recv(monitor, event, sizeof event, ZMQ_DONTWAIT) != (int)sizeof event ||
            zmq_recv(monitor, address, sizeof address, ZMQ_DONTWAIT) < 0)
            continue;
        switch (event[0] | event[1] << 8) {
        case ZMQ_EVENT_HANDSHAKE_SUCCEEDED:
            return HANDSHAKE_GOOD;
        case ZMQ_EVENT_HANDSHAKE_FAILED_AUTH:
            return HANDSHAKE_REFUSED;
        case ZMQ_EVENT_HANDSHAKE_FAILED_PROTOCOL:
            return HANDSHAKE_FOREIGN;
        case ZMQ_EVENT_HANDSHAKE_FAILED_NO_DETAIL:
        case ZMQ_EVENT_DISCONNECTED:
            return HANDSHAKE_CLOSED;
        default:
            break;
        }
    }
    return HANDSHAKE_SILENT;
}

static enum outcome shake_hands(const char *endpoint, enum handshake *how, struct scree_error *err)
{
    const int no_linger = 0;
    static const char inner[] = "inproc://handshake";
    void *context = zmq_ctx_new(), *socket = context ? zmq_socket(context, ZMQ_DEALER) : NULL;
    void *monitor = context ? zmq_socket(context, ZMQ_PAIR) : NULL;
    enum outcome outcome = OUTCOME_DONE;
    if (!socket || !monitor || zmq_setsockopt(socket, ZMQ_LINGER, &no_linger, sizeof no_linger) ||
        zmq_setsockopt(monitor, ZMQ_LINGER, &no_linger, sizeof no_linger) || zmq_socket_monitor(socket, inner, ZMQ_EVENT_ALL) ||
        zmq_connect(monitor, inner))
        outcome = outcome_fail(err, OUTCOME_FAILED, "no resources for a connection to %s", endpoint);
    if (!outcome && !(outcome = network_keys(socket, err)) && zmq_connect(socket, endpoint) != 0)
        outcome = outcome_fail(err, OUTCOME_REFUSED, "%s: %s", endpoint, zmq_strerror(errno));
    if (!outcome)
        *how = watch(monitor);
    if (socket)
        zmq_close(socket);
    if (monitor)
        zmq_close(monitor);
    if (context)
        zmq_ctx_term(context);
    return outcome;
}

static enum outcome explain(const char *endpoint, enum handshake how, struct scree_error *err)
{
    char key[KEY_TEXT_MAX], source[PATH_MAX];
    switch (how) {
    case HANDSHAKE_GOOD:
        return OUTCOME_DONE;
    case HANDSHAKE_REFUSED:
        outcome_fail(err, OUTCOME_DENIED, "the daemon at %s does not trust this key", endpoint);
        scree_hint(err, "its owner lets you in: scree trust client.pub --role view|submit|steer|admin");
        return OUTCOME_DENIED;
    case HANDSHAKE_CLOSED:
        if (server_key(key, source, err))
            return OUTCOME_DENIED;
        outcome_fail(err, OUTCOME_DENIED, "the daemon at %s is not the one whose key is in %s: it cannot read what we say",
                     endpoint, source);
        scree_hint(err, "get its server.pub from its owner; if it should be the same daemon, somebody may stand between");
        return OUTCOME_DENIED;
    case HANDSHAKE_FOREIGN:
        return outcome_fail(err, OUTCOME_UNREACHABLE, "what listens at %s is no scree daemon, or does not encrypt", endpoint);
    case HANDSHAKE_SILENT:
        break;
    }
    return outcome_fail(err, OUTCOME_UNREACHABLE, "what listens at %s does not answer as a scree daemon does", endpoint);
}

enum outcome network_probe(const char *endpoint, struct scree_error *err)
{
    enum handshake how = HANDSHAKE_SILENT;
    enum outcome outcome = reach(endpoint, err);
    /* A daemon that is being flooded may drop a newcomer: only what happens again is told. */
    for (int k = 0; k < TRIES && !outcome && how != HANDSHAKE_GOOD && how != HANDSHAKE_REFUSED; k++)
        outcome = shake_hands(endpoint, &how, err);
    return outcome ? outcome : explain(endpoint, how, err);
}

enum outcome network_beside(const char *control, const char *named, char out[WIRE_ENDPOINT_MAX], struct scree_error *err)
{
    const char *port = strrchr(named, ':');
    int host = (int)(strrchr(control, ':') - control);
    if (!network_endpoint(named) || network_check(named, err))
        return outcome_fail(err, OUTCOME_FAILED, "the daemon at %s names no endpoint on the network", control);
    snprintf(out, WIRE_ENDPOINT_MAX, "%.*s%s", host, control, port);
    return network_check(out, err);
}
