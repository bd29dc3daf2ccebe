/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See wire.h. */
#include "wire.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include "network.h"
#include "protocol/frame.h"

enum outcome wire_endpoint_check(const char *endpoint, struct scree_error *err)
{
    struct sockaddr_un address;
    if (network_endpoint(endpoint))
        return network_check(endpoint, err);
    if (strncmp(endpoint, "ipc://", 6) != 0 || !endpoint[6])
        return outcome_fail(err, OUTCOME_REFUSED, "%s: an endpoint has the form ipc://PATH or tcp://HOST:PORT", endpoint);
    if (strlen(endpoint + 6) >= sizeof address.sun_path)
        return outcome_fail(err, OUTCOME_REFUSED, "%s: the path of a socket has at most %zu bytes", endpoint,
                            sizeof address.sun_path - 1);
    return OUTCOME_DONE;
}

enum outcome wire_probe(const char *endpoint, struct scree_error *err)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    const char *path = endpoint + 6;
    if (network_endpoint(endpoint))
        return network_probe(endpoint, err);
    size_t length = strlen(path);
    memcpy(address.sun_path, path, length);
    if (*path == '@') // the abstract namespace, as ZeroMQ writes it
        address.sun_path[0] = 0;
    socklen_t size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + length + (*path != '@'));
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    int why = fd < 0 || connect(fd, (const struct sockaddr *)&address, size) ? errno : 0;
    if (fd >= 0)
        close(fd);
    if (why == 0 || why == EAGAIN) // EAGAIN: its queue of connections is full, but it is there
        return OUTCOME_DONE;
    if (why == EACCES || why == EPERM)
        return outcome_fail(err, OUTCOME_DENIED, "the daemon at %s belongs to somebody else: %s", endpoint, strerror(why));
    outcome_fail(err, OUTCOME_UNREACHABLE, "no daemon at %s (%s)", endpoint, strerror(why));
    scree_hint(err, "start one with `screed`, or name another with --connect or SCREE_CONNECT");
    return OUTCOME_UNREACHABLE;
}

void *wire_connect(void *context, const char *endpoint, int64_t message_max)
{
    const int no_linger = 0, retry_ms = 50, retry_max_ms = 1000;
    void *socket = zmq_socket(context, ZMQ_DEALER);
    if (socket && (zmq_setsockopt(socket, ZMQ_LINGER, &no_linger, sizeof no_linger) ||
                   zmq_setsockopt(socket, ZMQ_RECONNECT_IVL, &retry_ms, sizeof retry_ms) ||
                   zmq_setsockopt(socket, ZMQ_RECONNECT_IVL_MAX, &retry_max_ms, sizeof retry_max_ms) ||
                   zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &message_max, sizeof message_max) ||
                   (network_endpoint(endpoint) && network_keys(socket, NULL)) || zmq_connect(socket, endpoint))) {
        zmq_close(socket);
        return NULL;
    }
    return socket;
}

static bool send_tree(void *socket, const cJSON *tree, int more)
{
    char *text = json_print(tree, false);
    bool sent = text && zmq_send(socket, text, strlen(text), ZMQ_DONTWAIT | more) >= 0;
    free(text);
    return sent;
}

bool wire_send(void *socket, const cJSON *header, const cJSON *body)
{
    return zmq_send(socket, PROTOCOL_VERSION, strlen(PROTOCOL_VERSION), ZMQ_DONTWAIT | ZMQ_SNDMORE) >= 0 &&
           send_tree(socket, header, body ? ZMQ_SNDMORE : 0) && (!body || send_tree(socket, body, 0));
}

/* All frames of the next message; those beyond WIRE_FRAMES_MAX are counted and dropped. */
static bool take_frames(void *socket, struct wire_message *message)
{
    int count = 0, more = 1;
    while (more) {
        zmq_msg_t frame;
        zmq_msg_init(&frame);
        if (zmq_msg_recv(&frame, socket, ZMQ_DONTWAIT) < 0) {
            zmq_msg_close(&frame);
            return false;
        }
        more = zmq_msg_more(&frame);
        if (count < WIRE_FRAMES_MAX) {
            zmq_msg_init(&message->frames[count]);
            zmq_msg_move(&message->frames[count], &frame);
            message->count = count + 1;
        }
        zmq_msg_close(&frame);
        count++;
    }
    return count <= WIRE_FRAMES_MAX;
}

bool wire_receive(void *socket, int milliseconds, struct wire_message *message)
{
    *message = (struct wire_message){.count = 0};
    zmq_pollitem_t item = {.socket = socket, .events = ZMQ_POLLIN};
    if (zmq_poll(&item, 1, milliseconds) <= 0)
        return false;
    if (take_frames(socket, message) && message->count >= 2 && zmq_msg_size(&message->frames[0]) == strlen(PROTOCOL_VERSION) &&
        memcmp(zmq_msg_data(&message->frames[0]), PROTOCOL_VERSION, strlen(PROTOCOL_VERSION)) == 0 &&
        json_read(zmq_msg_data(&message->frames[1]), zmq_msg_size(&message->frames[1]), "reply", &message->header, NULL) ==
            SCREE_OK)
        return true;
    wire_release(message);
    return false;
}

void wire_release(struct wire_message *message)
{
    for (int k = 0; k < message->count; k++)
        zmq_msg_close(&message->frames[k]);
    cJSON_Delete(message->header);
    *message = (struct wire_message){.count = 0};
}
