/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One loop over three sockets, a wake-up from workers and recorder, and signals.
 * Nothing in it waits for a simulation, for HDF5 or for a peer. */
#include "control.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/signalfd.h>
#include <time.h>
#include <unistd.h>
#include <zmq.h>

#include "auth.h"
#include "gate.h"
#include "limits.h"
#include "log.h"
#include "notify.h"
#include "requests.h"
#include "streams.h"
#include "study_requests.h"

enum { PEER_MAX = 256, FRAMES_MAX = 8, PENDING_MAX = 256, PROGRESS_MS = 200, STUDY_TURNS = 8 };

/* A fetch or a steering command whose answer is still to come. */
struct pending {
    uint64_t ticket; // 0: free
    unsigned char peer[PEER_MAX];
    size_t peer_size;
    char id[PROTOCOL_ID_MAX + 1];
    char user[KEY_NAME_MAX]; // "" for the owner
};

struct control {
    struct daemon daemon;
    void *context, *control, *stream, *events;
    struct streams *streams;
    struct auth *auth;
    struct gate *gate; // NULL without a network
    struct notify *notify;
    int wake_fd, signal_fd, signals;
    int runtime_fd; // locked while this daemon listens there
    struct pending pending[PENDING_MAX];
    struct timespec last_progress;
};

/* ---- sockets ---- */

/* One socket for both ways in; what is set before each bind holds for that way. */
static bool bind_socket(struct control *c, void *socket, const char *endpoint, int index, struct scree_error *err)
{
    char inner[CONFIG_PATH_MAX];
    if (auth_guard_local(socket, err))
        return false;
    if (zmq_bind(socket, endpoint) != 0) {
        scree_fail(err, SCREE_IO, "listen", "cannot listen on %s: %s", endpoint, zmq_strerror(errno));
        return false;
    }
    if (!*c->daemon.config->network)
        return true;
    if (gate_inner(c->daemon.config, index, inner, err) || auth_guard_network(c->auth, socket, err))
        return false;
    if (zmq_bind(socket, inner) == 0)
        return true;
    scree_fail(err, SCREE_IO, "listen", "cannot listen on %s: %s", inner, zmq_strerror(errno));
    return false;
}

static void *open_socket(struct control *c, int type, const char *endpoint, int index, struct scree_error *err)
{
    void *socket = zmq_socket(c->context, type);
    int mandatory = 1, linger = 200, queue = 256;
    int64_t largest = 2 * PROTOCOL_FRAME_MAX; // up to here a frame is answered; beyond it the connection is closed
    if (!socket) {
        scree_fail(err, SCREE_IO, "", "no socket: %s", zmq_strerror(errno));
        return NULL;
    }
    zmq_setsockopt(socket, ZMQ_LINGER, &linger, sizeof linger);
    zmq_setsockopt(socket, ZMQ_MAXMSGSIZE, &largest, sizeof largest);
    zmq_setsockopt(socket, ZMQ_SNDHWM, &queue, sizeof queue);
    zmq_setsockopt(socket, ZMQ_RCVHWM, &queue, sizeof queue);
    if (type == ZMQ_ROUTER)
        zmq_setsockopt(socket, ZMQ_ROUTER_MANDATORY, &mandatory, sizeof mandatory);
    else
        zmq_setsockopt(socket, ZMQ_XPUB_VERBOSE, &mandatory, sizeof mandatory);
    if (!bind_socket(c, socket, endpoint, index, err)) {
        zmq_close(socket);
        return NULL;
    }
    return socket;
}

/* Another daemon in this runtime directory is not pushed aside, be it about to start or too busy to answer: a bind takes a socket's
 * path from whoever has it. The lock ends with the process, however that ends. */
static enum scree_status hold_runtime_dir(struct control *c, struct scree_error *err)
{
    const struct config *config = c->daemon.config;
    c->runtime_fd = open(config->runtime, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (c->runtime_fd < 0)
        return scree_fail(err, SCREE_IO, "runtime", "cannot open the directory %s: %s", config->runtime, strerror(errno));
    if (flock(c->runtime_fd, LOCK_EX | LOCK_NB) == 0)
        return SCREE_OK;
    if (errno == EWOULDBLOCK)
        return scree_fail(err, SCREE_BUSY, "listen", "another screed listens on %s", config->listen);
    return scree_fail(err, SCREE_IO, "runtime", "cannot lock the directory %s: %s", config->runtime, strerror(errno));
}

static enum scree_status open_sockets(struct control *c, struct scree_error *err)
{
    const struct config *config = c->daemon.config;
    enum scree_status status = auth_runtime_dir(config->runtime, err);
    if (status || (status = hold_runtime_dir(c, err)))
        return status;
    c->context = zmq_ctx_new();
    if (!c->context)
        return scree_fail(err, SCREE_IO, "", "no messaging context: %s", zmq_strerror(errno));
    if ((status = auth_open(&c->auth, c->context, config, err)))
        return status;
    if (!(c->control = open_socket(c, ZMQ_ROUTER, config->listen, 0, err)) ||
        !(c->stream = open_socket(c, ZMQ_ROUTER, config->stream, 1, err)) ||
        !(c->events = open_socket(c, ZMQ_XPUB, config->events, 2, err)))
        return SCREE_IO;
    return *config->network ? gate_open(&c->gate, config, err) : SCREE_OK;
}

/* ---- replies and events ---- */

static void send_reply(struct control *c, const void *peer, size_t peer_size, cJSON *reply)
{
    char *text = reply ? json_print(reply, false) : NULL;
    bool whole = !json_starved();
    cJSON_Delete(reply);
    /* A peer that is gone, or does not read, asks again if it cares; and so does one whose answer found no memory. */
    if (text && whole && zmq_send(c->control, peer, peer_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0) {
        zmq_send(c->control, PROTOCOL_VERSION, strlen(PROTOCOL_VERSION), ZMQ_SNDMORE | ZMQ_DONTWAIT);
        zmq_send(c->control, text, strlen(text), ZMQ_DONTWAIT);
    }
    free(text);
}

static void publish_text(struct control *c, const char *topic, cJSON *json)
{
    char *text = json ? json_print(json, false) : NULL;
    bool whole = !json_starved();
    cJSON_Delete(json);
    if (text && whole && zmq_send(c->events, topic, strlen(topic), ZMQ_SNDMORE | ZMQ_DONTWAIT) >= 0)
        zmq_send(c->events, text, strlen(text), ZMQ_DONTWAIT);
    free(text);
}

static void publish(struct control *c, const struct job *job, const char *kind, cJSON *json)
{
    char topic[64];
    snprintf(topic, sizeof topic, "job/%s/%s", job->id, kind);
    publish_text(c, topic, json);
}

static void publish_heads(struct control *c, const struct job *job)
{
    for (size_t k = 0; k < job->report.head_count; k++) {
        cJSON *json = cJSON_CreateObject();
        json_put_text(json, "job", job->id);
        json_put_text(json, "stream", job->report.heads[k].name);
        json_put_int(json, "chunks", (long long)job->report.heads[k].chunks);
        publish(c, job, "head", json);
    }
}

static bool progress_is_due(struct control *c)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    long passed = (long)(now.tv_sec - c->last_progress.tv_sec) * 1000 + (now.tv_nsec - c->last_progress.tv_nsec) / 1000000;
    if (passed < PROGRESS_MS)
        return false;
    c->last_progress = now;
    return true;
}

static void job_changed(void *context, const struct job *job, enum job_event what)
{
    struct control *c = context;
    if (c->streams)
        streams_changed(c->streams, job);
    if (what == EVENT_STATE) {
        cJSON *json = cJSON_CreateObject();
        json_put_text(json, "job", job->id);
        json_put_text(json, "state", job_state_word(job->state));
        json_put_text(json, "verdict", scree_verdict_word(job->report.verdict));
        publish(c, job, "state", json);
    } else if (what == EVENT_PROGRESS && progress_is_due(c)) {
        publish(c, job, "progress", requests_summary(job));
        publish_heads(c, job);
    }
}

/* Who waits for an answer under that ticket, and waits no more; NULL if nobody does. */
static struct pending *take_pending(struct control *c, uint64_t ticket)
{
    json_starved(); // of what was made before the answer
    for (int k = 0; ticket && k < PENDING_MAX; k++)
        if (c->pending[k].ticket == ticket) {
            c->pending[k].ticket = 0;
            return &c->pending[k];
        }
    return NULL;
}

static void job_fetched(void *context, uint64_t ticket, const struct job *job, const char *path, const struct scree_error *error)
{
    struct control *c = context;
    const struct pending *p = take_pending(c, ticket);
    if (p)
        send_reply(c, p->peer, p->peer_size,
                   error ? reply_error(p->id, scree_status_word(error->status), error)
                         : reply_ok(p->id, requests_fetched(job, path)));
}

static void job_steered(void *context, uint64_t ticket, const struct job *job, const struct command *command,
                        const struct scree_error *error)
{
    struct control *c = context;
    const struct pending *p = take_pending(c, ticket);
    if (p)
        send_reply(c, p->peer, p->peer_size,
                   error ? reply_error(p->id, scree_status_word(error->status), error)
                         : reply_ok(p->id, requests_steered(job, command)));
}

static void study_recorded(void *context, const struct record_order *order)
{
    struct control *c = context;
    const struct pending *p = take_pending(c, order->ticket);
    if (p)
        send_reply(c, p->peer, p->peer_size, study_recorded_reply(p->id, order));
}

static void study_changed(void *context, const struct study *study)
{
    struct control *c = context;
    char topic[64];
    cJSON *json = cJSON_CreateObject();
    json_put_text(json, "study", study->id);
    json_put_text(json, "state", job_state_word(study->state));
    snprintf(topic, sizeof topic, "job/%s/state", study->id);
    publish_text(c, topic, json);
}

/* ---- requests ---- */

/* The same request again: only one answer is owed. */
static void drop_pending(struct control *c, const void *peer, size_t peer_size, const char *id)
{
    for (int k = 0; k < PENDING_MAX; k++) {
        struct pending *p = &c->pending[k];
        if (p->ticket && p->peer_size == peer_size && memcmp(p->peer, peer, peer_size) == 0 && strcmp(p->id, id) == 0)
            p->ticket = 0;
    }
}

static struct pending *keep_pending(struct control *c, const void *peer, size_t peer_size, const char *id)
{
    for (int k = 0; k < PENDING_MAX; k++) {
        struct pending *p = &c->pending[k];
        if (p->ticket)
            continue;
        p->ticket = c->daemon.tickets + 1; // the one that the request will take
        memcpy(p->peer, peer, peer_size);
        p->peer_size = peer_size;
        snprintf(p->id, sizeof p->id, "%s", id);
        snprintf(p->user, sizeof p->user, "%s", c->daemon.user.name);
        return p;
    }
    return NULL;
}

static size_t count_pending(const struct control *c, const struct user *user)
{
    size_t count = 0;
    for (int k = 0; k < PENDING_MAX; k++)
        count += c->pending[k].ticket && strcmp(c->pending[k].user, user->name) == 0;
    return count;
}

/* Whether the sender of this message may have it carried out. */
static enum scree_status permit(struct control *c, const struct envelope *envelope, zmq_msg_t *header, struct scree_error *err)
{
    c->daemon.user = auth_user(c->auth, header);
    const struct user *user = &c->daemon.user;
    enum scree_status status = auth_permit(user, envelope->op, err);
    if (!status && strcmp(envelope->op, "fetch") == 0)
        status = limits_check(user, count_pending(c, user), c->daemon.config->max_fetches, "results in the making", err);
    return status;
}

static void bad_request(struct control *c, const void *peer, size_t peer_size, const char *id, const struct scree_error *error)
{
    /* What memory did not suffice to read may be a good one. */
    const char *code = error->status == SCREE_NO_MEMORY ? scree_status_word(error->status) : "bad_request";
    send_reply(c, peer, peer_size, reply_error(id, code, error));
}

static void handle(struct control *c, const void *peer, size_t peer_size, zmq_msg_t *header, zmq_msg_t *body)
{
    struct envelope envelope;
    struct scree_error error = {0};
    cJSON *json = NULL, *reply = NULL;
    struct pending *pending = NULL;
    json_starved();
    if (envelope_read(zmq_msg_data(header), zmq_msg_size(header), &envelope, &error)) {
        bad_request(c, peer, peer_size, envelope.id, &error);
        return;
    }
    enum scree_status denied = permit(c, &envelope, header, &error);
    if (denied) {
        send_reply(c, peer, peer_size, reply_error(envelope.id, scree_status_word(denied), &error));
        return;
    }
    if (json_read(zmq_msg_data(body), zmq_msg_size(body), "body", &json, &error)) {
        bad_request(c, peer, peer_size, envelope.id, &error);
        return;
    }
    if (!cJSON_IsObject(json)) {
        scree_fail(&error, SCREE_INVALID, "", "the body must be a JSON object");
        bad_request(c, peer, peer_size, envelope.id, &error);
        goto out;
    }
    bool waits = requests_may_wait(envelope.op);
    if (waits)
        drop_pending(c, peer, peer_size, envelope.id);
    if (waits && !(pending = keep_pending(c, peer, peer_size, envelope.id))) {
        scree_fail(&error, SCREE_BUSY, "", "too many requests wait for their answers; try again later");
        send_reply(c, peer, peer_size, reply_error(envelope.id, "busy", &error));
        goto out;
    }
    if (requests_handle(&c->daemon, &envelope, json, &reply) == ANSWER_NOW) {
        if (pending)
            pending->ticket = 0;
        send_reply(c, peer, peer_size, reply);
    }
out:
    cJSON_Delete(json);
}

static bool is_version(zmq_msg_t *frame)
{
    return zmq_msg_size(frame) == strlen(PROTOCOL_VERSION) &&
           memcmp(zmq_msg_data(frame), PROTOCOL_VERSION, zmq_msg_size(frame)) == 0;
}

/* Reads requests, at most so many a turn. */
static void receive(struct control *c)
{
    for (int taken = 0; taken < 64; taken++) {
        zmq_msg_t frames[FRAMES_MAX];
        int count = 0, total = 0, more = 1;
        while (more) {
            zmq_msg_t frame;
            zmq_msg_init(&frame);
            if (zmq_msg_recv(&frame, c->control, ZMQ_DONTWAIT) < 0) {
                zmq_msg_close(&frame);
                break;
            }
            more = zmq_msg_more(&frame);
            total++;
            if (count < FRAMES_MAX)
                frames[count++] = frame;
            else
                zmq_msg_close(&frame);
        }
        if (count == 0)
            return;
        const void *peer = zmq_msg_data(&frames[0]);
        size_t peer_size = zmq_msg_size(&frames[0]);
        if (peer_size > PEER_MAX) {
            // no peer of ours names itself so
        } else if (total == 4 && is_version(&frames[1])) {
            handle(c, peer, peer_size, &frames[2], &frames[3]);
        } else {
            struct scree_error error;
            scree_fail(&error, SCREE_INVALID, "", "three frames are expected: \"%s\", a header and a body", PROTOCOL_VERSION);
            bad_request(c, peer, peer_size, "", &error);
        }
        for (int k = 0; k < count; k++)
            zmq_msg_close(&frames[k]);
    }
}

/* ---- the loop ---- */

/* Whoever rotates logs moves the file away and sends SIGHUP. */
static void open_log(const struct control *c)
{
    struct scree_error error;
    if (*c->daemon.config->log && log_open(c->daemon.config->log, &error))
        log_line(LOG_ERROR, "%s", error.message);
}

static void read_signals(struct control *c)
{
    struct signalfd_siginfo info;
    while (read(c->signal_fd, &info, sizeof info) == sizeof info) {
        if ((int)info.ssi_signo == SIGHUP) {
            open_log(c);
            continue;
        }
        if (++c->signals > 1 || (int)info.ssi_signo == SIGQUIT) {
            log_line(LOG_WARNING, "signal=%u ending at once", info.ssi_signo);
            _exit(1);
        }
        log_line(LOG_INFO, "signal=%u ending", info.ssi_signo);
        c->daemon.ending = true;
    }
}

static bool parent_is_gone(const struct control *c)
{
    return c->daemon.config->parent && kill(c->daemon.config->parent, 0) != 0 && errno == ESRCH;
}

/* Subscriptions to events say nothing that we need; they are read so that they do not pile up. */
static void drain_events(struct control *c)
{
    char buffer[256];
    while (zmq_recv(c->events, buffer, sizeof buffer, ZMQ_DONTWAIT) >= 0)
        ;
}

static void loop(struct control *c)
{
    bool more = false;
    while (!c->daemon.ending && !scheduler_is_lost(c->daemon.scheduler)) {
        zmq_pollitem_t items[] = {
            {.socket = c->control, .events = ZMQ_POLLIN}, {.socket = c->stream, .events = ZMQ_POLLIN},
            {.socket = c->events, .events = ZMQ_POLLIN},  {.fd = c->wake_fd, .events = ZMQ_POLLIN},
            {.fd = c->signal_fd, .events = ZMQ_POLLIN},   {.socket = auth_socket(c->auth), .events = ZMQ_POLLIN}};
        eventfd_t wakes;
        zmq_poll(items, sizeof items / sizeof *items, more ? 5 : 1000);
        if (items[3].revents)
            eventfd_read(c->wake_fd, &wakes);
        if (items[4].revents)
            read_signals(c);
        if (items[2].revents)
            drain_events(c);
        auth_turn(c->auth);
        receive(c);
        scheduler_turn(c->daemon.scheduler);
        for (int turns = 0; turns < STUDY_TURNS && studies_turn(c->daemon.studies); turns++)
            scheduler_turn(c->daemon.scheduler); // trials that were submitted start at once
        streams_receive(c->streams);
        more = streams_send(c->streams);
        notify_turn(c->notify, c->daemon.scheduler);
        if (parent_is_gone(c)) {
            log_line(LOG_INFO, "parent=%d is gone, ending", c->daemon.config->parent);
            c->daemon.ending = true;
        }
    }
}

#define END_MS 9500

/* While workers finish their slices and checkpoints are written: a second SIGTERM
 * or SIGINT ends the daemon at once, and so does a disk that takes too long. What
 * is lost then is computed again at the next start. */
static void *second_signal(void *argument)
{
    struct pollfd wait = {.fd = (int)(intptr_t)argument, .events = POLLIN};
    struct signalfd_siginfo info;
    for (;;) {
        int ready = poll(&wait, 1, END_MS);
        if (ready < 0 || (ready > 0 && (read(wait.fd, &info, sizeof info) != sizeof info || info.ssi_signo == SIGHUP)))
            continue;
        log_line(LOG_WARNING, ready > 0 ? "ending at once" : "ending without the last checkpoints: they take too long");
        _exit(1);
    }
}

static void say_ready(const struct config *config)
{
    if (config->ready_fd < 0)
        return;
    if (write(config->ready_fd, "ready\n", 6) != 6)
        log_line(LOG_WARNING, "ready-fd=%d could not be written", config->ready_fd);
    close(config->ready_fd);
}

enum scree_status control_run(const struct config *config, struct scree_error *err)
{
    struct control *c = calloc(1, sizeof *c);
    struct timespec now;
    sigset_t signals;
    pthread_t watcher;
    enum scree_status status;
    if (!c)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory");
    clock_gettime(CLOCK_MONOTONIC, &now);
    c->daemon = (struct daemon){.config = config, .started = (double)now.tv_sec + 1e-9 * (double)now.tv_nsec};
    c->runtime_fd = -1;
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGHUP);
    c->wake_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    c->signal_fd = signalfd(-1, &signals, SFD_CLOEXEC | SFD_NONBLOCK);
    const struct scheduler_watch watch = {
        .changed = job_changed, .fetched = job_fetched, .recorded = study_recorded, .steered = job_steered, .context = c};
    const struct studies_watch study_watch = {.changed = study_changed, .context = c};
    if (*config->log && (status = log_open(config->log, err)))
        goto out;
    if ((status = scree_prepare(err)) || (status = notify_open(&c->notify, config->stall_s, err)) ||
        (status = open_sockets(c, err)) || (status = scheduler_open(&c->daemon.scheduler, config, c->wake_fd, &watch, err)) ||
        (status = studies_open(&c->daemon.studies, c->daemon.scheduler, config, &study_watch, err)) ||
        (status = streams_open(&c->streams, c->stream, c->daemon.scheduler, c->auth, config->max_streams, err)))
        goto out;
    log_line(LOG_INFO, "listen=%s network=%s data=%s workers=%d version=%s", config->listen,
             *config->network ? config->network : "none", config->data, config->workers, scree_build());
    say_ready(config);
    notify_ready(c->notify);
    loop(c);
    if (!c->daemon.ending) {
        status = scree_fail(err, SCREE_NO_MEMORY, "", "libhdf5 was refused memory and has been unable to write anything since");
        scree_hint(err, "start screed again: every job goes on from its last checkpoint");
    }
    notify_stopping(c->notify);
    if (pthread_create(&watcher, NULL, second_signal, (void *)(intptr_t)c->signal_fd) == 0)
        pthread_detach(watcher);
out:
    streams_close(c->streams);
    c->streams = NULL;
    if (c->events)
        zmq_close(c->events);
    c->events = NULL;
    studies_close(c->daemon.studies); // trials that end from here on are looked at when the daemon starts again
    scheduler_close(c->daemon.scheduler);
    if (c->control)
        zmq_close(c->control);
    if (c->stream)
        zmq_close(c->stream);
    auth_close(c->auth);
    notify_close(c->notify);
    if (c->context)
        zmq_ctx_term(c->context);
    gate_close(c->gate);
    if (!status)
        log_line(LOG_INFO, "ended");
    close(c->wake_fd);
    if (c->runtime_fd >= 0)
        close(c->runtime_fd);
    free(c); // the signal descriptor stays for the watcher: the process ends now
    return status;
}
