/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See link.h.
 *
 * A quick request that is not answered in LINK_RETRY_S is sent again over a fresh
 * socket. A slow one is kept company by pings; one that must not be started twice
 * (fetch builds a file) goes out again only when an answer comes from another
 * process id, a restarted daemon. */
#include "link.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/random.h>

#include "network.h"
#include "output.h"
#include "protocol/frame.h"
#include "signals.h"

enum { REPLY_BYTES_MAX = 16 << 20, STREAM_BYTES_MAX = 1 << 30 };

struct link {
    void *context, *socket;
    char endpoint[WIRE_ENDPOINT_MAX];
    char prefix[24]; // of request ids: random, for every client has its own
    unsigned long requests;
    double pid; // of the daemon, as its last ping said; 0: not known
    int abort_at;
};

enum outcome link_endpoint(const char *connect, char endpoint[WIRE_ENDPOINT_MAX], bool *chosen, struct scree_error *err)
{
    char runtime[WIRE_ENDPOINT_MAX];
    const char *environment = getenv("SCREE_CONNECT");
    if (!connect && environment && *environment)
        connect = environment;
    *chosen = connect != NULL;
    if (connect) {
        enum outcome outcome = wire_endpoint_check(connect, err);
        if (!outcome)
            snprintf(endpoint, WIRE_ENDPOINT_MAX, "%s", connect);
        return outcome;
    }
    if (protocol_runtime_dir(runtime, sizeof runtime, err) ||
        protocol_endpoint(runtime, "control", endpoint, WIRE_ENDPOINT_MAX, err))
        return OUTCOME_REFUSED;
    return OUTCOME_DONE;
}

enum outcome link_open(const char *endpoint, struct link **out, struct scree_error *err)
{
    unsigned char random[8];
    *out = NULL;
    enum outcome outcome = wire_endpoint_check(endpoint, err);
    if (outcome || (outcome = wire_probe(endpoint, err)))
        return outcome;
    struct link *link = calloc(1, sizeof *link);
    if (!link || getrandom(random, sizeof random, 0) != (ssize_t)sizeof random || !(link->context = zmq_ctx_new()) ||
        !(link->socket = wire_connect(link->context, endpoint, REPLY_BYTES_MAX))) {
        link_close(link);
        return outcome_fail(err, OUTCOME_FAILED, "no resources for a connection to %s", endpoint);
    }
    snprintf(link->endpoint, sizeof link->endpoint, "%s", endpoint);
    for (size_t k = 0; k < sizeof random; k++)
        snprintf(link->prefix + 2 * k, sizeof link->prefix - 2 * k, "%02x", random[k]);
    link->abort_at = 2;
    *out = link;
    return OUTCOME_DONE;
}

enum outcome link_open_for(const struct arguments *arguments, struct link **out, struct scree_error *err)
{
    char endpoint[WIRE_ENDPOINT_MAX];
    bool chosen;
    *out = NULL;
    enum outcome outcome = link_endpoint(arguments->connect, endpoint, &chosen, err);
    return outcome ? outcome : link_open(endpoint, out, err);
}

void link_close(struct link *link)
{
    if (!link)
        return;
    if (link->socket)
        zmq_close(link->socket);
    if (link->context)
        zmq_ctx_term(link->context);
    free(link);
}

void link_abort_at(struct link *link, int interrupts)
{
    link->abort_at = interrupts;
}

/* ---- one exchange ---- */

struct request {
    char id[PROTOCOL_ID_MAX + 1], ping_id[PROTOCOL_ID_MAX + 1];
    const char *op;
    const cJSON *body;
    bool slow, once;   // takes long; must not be started twice
    double patience_s; // silence of the daemon that is borne
};

static void send_op(struct link *link, const char *id, const char *op, const cJSON *body)
{
    /* A message that cannot be sent is a message without an answer: it is sent again later. */
    cJSON *header = envelope_make(id, op), *empty = body ? NULL : cJSON_CreateObject();
    if (header && (body || empty))
        wire_send(link->socket, header, body ? body : empty);
    cJSON_Delete(header);
    cJSON_Delete(empty);
}

static void reconnect(struct link *link)
{
    void *fresh = wire_connect(link->context, link->endpoint, REPLY_BYTES_MAX);
    if (!fresh)
        return; // the old one stays
    zmq_close(link->socket);
    link->socket = fresh;
}

/* Waits a slice for a reply to `request`; a ping's reply is noted in *alive. */
static cJSON *hear(struct link *link, const struct request *request, double *alive)
{
    struct wire_message message;
    cJSON *reply = NULL;
    if (!wire_receive(link->socket, WAIT_SLICE_MS, &message))
        return NULL;
    const char *id = json_text(message.header, "id");
    if (id && strcmp(id, request->id) == 0) {
        reply = message.header;
        message.header = NULL;
    } else if (id && strcmp(id, request->ping_id) == 0) {
        double pid = json_number(json_get(message.header, "result"), "pid", link->pid);
        *alive = now_s();
        if (pid != link->pid) {
            link->pid = pid;
            send_op(link, request->id, request->op, request->body);
        }
    }
    wire_release(&message);
    return reply;
}

/* Sends, and sends again, until there is a reply or a reason to give up. */
static enum outcome converse(struct link *link, const struct request *request, cJSON **reply, struct scree_error *err)
{
    double start = now_s(), asked = start, alive = start;
    enum outcome outcome;
    send_op(link, request->id, request->op, request->body);
    for (;;) {
        if ((*reply = hear(link, request, &alive)))
            return OUTCOME_DONE;
        if (signals_count() >= link->abort_at)
            return outcome_fail(err, OUTCOME_CANCELLED, "interrupted");
        double now = now_s();
        if (now - alive > request->patience_s)
            return outcome_fail(err, OUTCOME_UNREACHABLE, "the daemon at %s has not answered for %.3g s", link->endpoint,
                                now - alive);
        if (now - start > LINK_SLOW_S)
            return outcome_fail(err, OUTCOME_UNREACHABLE, "the daemon at %s is not done with %s after %d s", link->endpoint,
                                request->op, LINK_SLOW_S);
        if (now - asked < LINK_RETRY_S)
            continue;
        asked = now;
        if ((outcome = wire_probe(link->endpoint, err)))
            return outcome;
        if (request->slow) {
            send_op(link, request->ping_id, "ping", NULL);
        } else {
            reconnect(link);
        }
        if (!request->once)
            send_op(link, request->id, request->op, request->body);
    }
}

/* Turns a reply into result or error. */
static enum outcome unwrap(cJSON *reply, cJSON **result, struct scree_error *err)
{
    enum outcome outcome = OUTCOME_DONE;
    if (json_bool(reply, "ok", false)) {
        *result = cJSON_DetachItemFromObjectCaseSensitive(reply, "result");
        if (!cJSON_IsObject(*result)) {
            cJSON_Delete(*result);
            *result = NULL;
            outcome = outcome_fail(err, OUTCOME_FAILED, "the daemon's reply holds no result");
        }
    } else {
        outcome = outcome_of_status(error_read(json_get(reply, "error"), err));
    }
    cJSON_Delete(reply);
    return outcome;
}

/* What is asked for in `request`; its body is taken over. */
static enum outcome ask(struct link *link, struct request request, cJSON *body, cJSON **result, struct scree_error *err)
{
    cJSON *reply = NULL;
    request.body = body;
    snprintf(request.id, sizeof request.id, "%s-%lu", link->prefix, ++link->requests);
    snprintf(request.ping_id, sizeof request.ping_id, "%s-%lu-ping", link->prefix, link->requests);
    *result = NULL;
    enum outcome outcome = converse(link, &request, &reply, err);
    if (!outcome)
        outcome = unwrap(reply, result, err);
    cJSON_Delete(body);
    return outcome;
}

enum outcome link_request(struct link *link, const char *op, cJSON *body, cJSON **result, struct scree_error *err)
{
    return ask(link, (struct request){.op = op, .patience_s = LINK_SILENCE_S}, body, result, err);
}

enum outcome link_request_slow(struct link *link, const char *op, bool once, cJSON *body, cJSON **result, struct scree_error *err)
{
    cJSON *pong = NULL; // for the process id that later pings are compared with
    enum outcome outcome = link_ping(link, LINK_SILENCE_S, &pong, err);
    cJSON_Delete(pong);
    if (!outcome)
        return ask(link, (struct request){.op = op, .slow = true, .once = once, .patience_s = LINK_SILENCE_S}, body, result, err);
    cJSON_Delete(body);
    return outcome;
}

enum outcome link_job(struct link *link, const char *op, const char *job, cJSON **result, struct scree_error *err)
{
    cJSON *body = cJSON_CreateObject();
    if (body)
        json_put_text(body, "job", job);
    return link_request(link, op, body, result, err);
}

enum outcome link_ping(struct link *link, double seconds, cJSON **result, struct scree_error *err)
{
    enum outcome outcome = ask(link, (struct request){.op = "ping", .patience_s = seconds}, NULL, result, err);
    if (!outcome)
        link->pid = json_number(*result, "pid", 0);
    return outcome;
}

enum outcome link_stream_socket(struct link *link, void **socket, struct scree_error *err)
{
    cJSON *pong = NULL;
    *socket = NULL;
    enum outcome outcome = link_ping(link, LINK_SILENCE_S, &pong, err);
    const char *endpoint = outcome ? NULL : json_text(pong, "stream_endpoint");
    if (!outcome && !endpoint)
        outcome = outcome_fail(err, OUTCOME_FAILED, "the daemon does not say where its streams are");
    char beside[WIRE_ENDPOINT_MAX];
    if (!outcome && network_endpoint(link->endpoint)) {
        outcome = network_beside(link->endpoint, endpoint, beside, err);
        endpoint = beside;
    }
    if (!outcome && !(outcome = wire_endpoint_check(endpoint, err))) {
        *socket = wire_connect(link->context, endpoint, STREAM_BYTES_MAX);
        if (!*socket)
            outcome = outcome_fail(err, OUTCOME_FAILED, "no resources for a connection to %s", endpoint);
    }
    cJSON_Delete(pong);
    return outcome;
}
