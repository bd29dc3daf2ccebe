/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See streams.h. A dead peer is found when the ROUTER, told to be mandatory, has
 * no route to it: a subscription on which nothing was sent for a while is told
 * "alive", or one whose reader went away unpaid would stay, with its open log, for
 * ever. A full queue of a slow peer makes its subscription wait. */
#include "streams.h"

#include <errno.h>
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <zmq.h>

#include "base/memory.h"
#include "limits.h"
#include "protocol/frame.h"

enum { PEER_MAX = 256, PER_PEER_MAX = 64, TOTAL_MAX = 4096, CHUNKS_A_TURN = 16, FRAMES_MAX = 8 };

struct subscription {
    unsigned char peer[PEER_MAX];
    size_t peer_size;
    char user[KEY_NAME_MAX]; // "" for the owner
    char key[PROTOCOL_ID_MAX + 1];
    int64_t job;
    char stream[CHUNK_NAME_MAX];
    uint64_t next;
    int64_t credit;
    bool fresh;                    // nothing was sent since the last grant: a chunk larger than it may go
    bool ready;                    // worth a look: credit came, or the log has grown
    double sent_s;                 // when something was sent last, by the monotonic clock
    struct chunk_log *log;         // closed while nothing happens
    char columns[512], units[512]; // as the log describes the stream; "" before it does
};

#define ALIVE_SECONDS 10.0
enum { LOGS_KEPT = 64 }; // with more subscriptions than that, each opens its log for its turn alone

struct streams {
    void *socket;
    double now_s; // monotonic, as of this turn
    struct scheduler *scheduler;
    struct auth *auth;
    int per_user;
    struct user user; // who sent the message that is being handled
    struct subscription **all;
    size_t count, room;
};

enum scree_status streams_open(struct streams **out, void *socket, struct scheduler *scheduler, struct auth *auth, int per_user,
                               struct scree_error *err)
{
    *out = calloc(1, sizeof **out);
    if (!*out)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for streams");
    (*out)->socket = socket;
    (*out)->scheduler = scheduler;
    (*out)->auth = auth;
    (*out)->per_user = per_user;
    return SCREE_OK;
}

static void drop(struct streams *s, size_t index)
{
    chunk_log_close(s->all[index]->log);
    free(s->all[index]);
    s->all[index] = s->all[--s->count];
}

void streams_close(struct streams *s)
{
    if (!s)
        return;
    while (s->count > 0)
        drop(s, s->count - 1);
    free(s->all);
    free(s);
}

size_t streams_count(const struct streams *s)
{
    return s->count;
}

/* ---- sending ---- */

enum sent { SENT, SENT_LATER, SENT_GONE };

/* One message: peer, version, header and, if given, payload. `header` is taken over. */
static enum sent send_message(struct streams *s, const void *peer, size_t peer_size, cJSON *header, const void *payload,
                              size_t size)
{
    char *text = header ? json_print(header, false) : NULL;
    enum sent sent = SENT_GONE;
    bool whole = !json_starved();
    cJSON_Delete(header);
    if (!text || !whole) {
        free(text);
        return SENT_LATER;
    }
    /* The first frame decides: once it is taken, the rest of the message is. */
    if (zmq_send(s->socket, peer, peer_size, ZMQ_SNDMORE | ZMQ_DONTWAIT) < 0) {
        sent = errno == EAGAIN ? SENT_LATER : SENT_GONE;
    } else {
        zmq_send(s->socket, PROTOCOL_VERSION, strlen(PROTOCOL_VERSION), ZMQ_SNDMORE | ZMQ_DONTWAIT);
        zmq_send(s->socket, text, strlen(text), (payload ? ZMQ_SNDMORE : 0) | ZMQ_DONTWAIT);
        if (payload)
            zmq_send(s->socket, payload, size, ZMQ_DONTWAIT);
        sent = SENT;
    }
    free(text);
    return sent;
}

static cJSON *header_for(const char *op, const char *key)
{
    json_starved();
    cJSON *json = cJSON_CreateObject();
    json_put_text(json, "op", op);
    json_put_text(json, "key", key);
    return json;
}

static void send_error(struct streams *s, const void *peer, size_t peer_size, const char *key, const char *code,
                       const struct scree_error *error)
{
    cJSON *header = header_for("error", key);
    json_put(header, "error", error_json(code, error));
    send_message(s, peer, peer_size, header, NULL, 0);
}

static enum sent send_chunk(struct streams *s, const struct subscription *sub, const struct job *job, const struct chunk_row *row)
{
    char hash[24];
    cJSON *header = header_for("chunk", sub->key);
    json_put_text(header, "job", job->id);
    json_put_text(header, "stream", sub->stream);
    json_put_int(header, "seq", (long long)row->seq);
    json_put_real(header, "t0_s", row->t0_s);
    json_put_real(header, "dt_s", row->dt_s);
    json_put_int(header, "n", (long long)row->rows);
    json_put(header, "columns", cJSON_CreateRaw(sub->columns));
    json_put(header, "units", cJSON_CreateRaw(sub->units));
    json_put_text(header, "dtype", "<f8");
    json_put_int(header, "crc32c", row->crc);
    snprintf(hash, sizeof hash, "%016" PRIx64, row->hash);
    json_put_text(header, "hash", hash);
    return send_message(s, sub->peer, sub->peer_size, header, row->payload, row->bytes);
}

/* Opens the log and learns the stream's columns; false while there is nothing to
 * read. *unknown is set once it is sure that there is no such stream. */
static bool find_stream(struct streams *s, struct subscription *sub, const struct job *job, bool *unknown)
{
    char path[CONFIG_PATH_MAX + 64];
    struct chunk_stream known[JOB_STREAMS_MAX];
    *unknown = false;
    if (sub->log && *sub->columns)
        return true;
    scheduler_log_path(s->scheduler, job, path, sizeof path);
    if (!sub->log && chunk_log_open(&sub->log, path, false, NULL) != SCREE_OK) {
        sub->log = NULL;
        *unknown = job_state_ended(job->state);
        return false;
    }
    size_t count = chunk_log_streams(sub->log, known, JOB_STREAMS_MAX);
    for (size_t k = 0; k < count; k++)
        if (strcmp(known[k].name, sub->stream) == 0) {
            snprintf(sub->columns, sizeof sub->columns, "%s", known[k].columns);
            snprintf(sub->units, sizeof sub->units, "%s", known[k].units);
            return true;
        }
    *unknown = count > 0 || job_state_ended(job->state); // all streams of a job are declared at once
    return false;
}

static bool send_end(struct streams *s, const struct subscription *sub, const struct job *job)
{
    cJSON *header = header_for("end", sub->key);
    json_put_text(header, "job", job->id);
    json_put_text(header, "stream", sub->stream);
    json_put_int(header, "chunks", (long long)sub->next);
    json_put_text(header, "state", job_state_word(job->state));
    return send_message(s, sub->peer, sub->peer_size, header, NULL, 0) != SENT_LATER;
}

/* What became of one turn of a subscription. */
enum turn { TURN_IDLE, TURN_MORE, TURN_OVER };

static enum turn refuse(struct streams *s, const struct subscription *sub, const char *format, const char *what, uint64_t number)
{
    struct scree_error error;
    scree_fail(&error, SCREE_NOT_FOUND, "", format, what, (unsigned long long)number);
    send_error(s, sub->peer, sub->peer_size, sub->key, "not_found", &error);
    return TURN_OVER;
}

static uint64_t chunks_of(const struct subscription *sub)
{
    struct chunk_stream known[JOB_STREAMS_MAX];
    size_t count = chunk_log_streams(sub->log, known, JOB_STREAMS_MAX);
    for (size_t k = 0; k < count; k++)
        if (strcmp(known[k].name, sub->stream) == 0)
            return known[k].chunks;
    return 0;
}

/* The log has no chunk `next`: either it comes, or the stream is at its end. */
static enum turn at_end(struct streams *s, struct subscription *sub, const struct job *job, bool first)
{
    if (!job_state_ended(job->state)) {
        sub->ready = false;
        return TURN_IDLE;
    }
    bool before = sub->next == 0;
    if (first && !before) { // opened beyond the end, or just at it?
        struct chunk_row row;
        chunk_log_get(sub->log, sub->stream, sub->next - 1, &row, &before, NULL);
        if (!before)
            return refuse(s, sub, "stream %s ends before chunk %llu", sub->stream, sub->next);
    }
    if (sub->next < chunks_of(sub)) // a row of the log is lost: the stream has no end here
        return refuse(s, sub, "chunk %2$llu of %1$s is missing from the stream log", sub->stream, sub->next);
    return send_end(s, sub, job) ? TURN_OVER : TURN_MORE;
}

static enum turn serve(struct streams *s, struct subscription *sub)
{
    char id[JOB_ID_MAX];
    snprintf(id, sizeof id, "j%lld", (long long)sub->job);
    const struct job *job = scheduler_find(s->scheduler, id);
    bool unknown;
    if (!find_stream(s, sub, job, &unknown)) {
        sub->ready = false;
        return unknown ? refuse(s, sub, "there is no stream \"%s\"", sub->stream, 0) : TURN_IDLE;
    }
    for (int k = 0; k < CHUNKS_A_TURN; k++) {
        struct chunk_row row;
        bool found;
        struct scree_error error;
        if (chunk_log_get(sub->log, sub->stream, sub->next, &row, &found, &error)) {
            send_error(s, sub->peer, sub->peer_size, sub->key, scree_status_word(error.status), &error);
            return TURN_OVER;
        }
        if (!found)
            return at_end(s, sub, job, k == 0);
        if (sub->credit <= 0) {
            sub->ready = false;
            return TURN_IDLE;
        }
        /* A chunk larger than what is left waits for the next grant; one larger than any grant must still move. */
        if ((int64_t)row.bytes > sub->credit && !sub->fresh) {
            sub->ready = false;
            return TURN_IDLE;
        }
        enum sent sent = send_chunk(s, sub, job, &row);
        if (sent != SENT)
            return sent == SENT_LATER ? TURN_MORE : TURN_OVER;
        sub->sent_s = s->now_s;
        sub->credit -= (int64_t)row.bytes;
        sub->fresh = false;
        sub->next++;
    }
    return TURN_MORE;
}

static void put_log_away(struct subscription *sub)
{
    chunk_log_close(sub->log);
    sub->log = NULL;
}

/* After a silence, says that the daemon lives and puts the log away until it is
 * needed; false when the reader is gone. */
static bool still_there(struct streams *s, struct subscription *sub)
{
    if (s->now_s - sub->sent_s < ALIVE_SECONDS)
        return true;
    sub->sent_s = s->now_s;
    put_log_away(sub);
    return send_message(s, sub->peer, sub->peer_size, header_for("alive", sub->key), NULL, 0) != SENT_GONE;
}

static double monotonic(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

bool streams_send(struct streams *s)
{
    bool more = false;
    s->now_s = monotonic();
    for (size_t k = 0; k < s->count;) {
        enum turn turn = s->all[k]->ready ? serve(s, s->all[k]) : TURN_IDLE;
        if (turn == TURN_OVER || (turn == TURN_IDLE && !still_there(s, s->all[k]))) {
            drop(s, k);
            continue;
        }
        if (s->count > LOGS_KEPT)
            put_log_away(s->all[k]);
        more |= turn == TURN_MORE;
        k++;
    }
    return more;
}

void streams_changed(struct streams *s, const struct job *job)
{
    for (size_t k = 0; k < s->count; k++)
        if (s->all[k]->job == job->number)
            s->all[k]->ready = true;
}

/* ---- receiving ---- */

static struct subscription *find(struct streams *s, const void *peer, size_t peer_size, const char *key, size_t *index,
                                 size_t *of_peer)
{
    struct subscription *found = NULL;
    *of_peer = 0;
    for (size_t k = 0; k < s->count; k++) {
        struct subscription *sub = s->all[k];
        if (sub->peer_size != peer_size || memcmp(sub->peer, peer, peer_size) != 0)
            continue;
        ++*of_peer;
        if (strcmp(sub->key, key) == 0) {
            found = sub;
            *index = k;
        }
    }
    return found;
}

static size_t count_of_user(const struct streams *s)
{
    size_t count = 0;
    for (size_t k = 0; k < s->count; k++)
        count += strcmp(s->all[k]->user, s->user.name) == 0;
    return count;
}

static enum scree_status open_subscription(struct streams *s, const void *peer, size_t peer_size, const char *key,
                                           const cJSON *json, size_t of_peer, struct scree_error *err)
{
    const char *id = json_text(json, "job"), *stream = json_text(json, "stream");
    double from = json_number(json, "from", json_get(json, "from") ? -1 : 0);
    struct job *job = scheduler_find(s->scheduler, id);
    if (!job)
        return scree_fail(err, SCREE_NOT_FOUND, "job", "there is no job \"%.32s\"", id ? id : "");
    if (!stream || strlen(stream) >= CHUNK_NAME_MAX || !*stream)
        return scree_fail(err, SCREE_NOT_FOUND, "stream", "there is no stream \"%.32s\"", stream ? stream : "");
    if (!(from >= 0 && from <= 9e15 && from == floor(from)))
        return scree_fail(err, SCREE_INVALID, "from", "from: a whole number from 0 on is expected");
    if (of_peer >= PER_PEER_MAX || s->count >= TOTAL_MAX)
        return scree_fail(err, SCREE_BUSY, "", "too many open streams");
    enum scree_status status = limits_check(&s->user, count_of_user(s), s->per_user, "open streams", err);
    if (status)
        return status;
    status = memory_grow((void **)&s->all, &s->room, s->count + 1, sizeof *s->all, err);
    struct subscription *sub = status ? NULL : calloc(1, sizeof *sub);
    if (!sub)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a stream");
    memcpy(sub->peer, peer, peer_size);
    sub->peer_size = peer_size;
    snprintf(sub->user, sizeof sub->user, "%s", s->user.name);
    snprintf(sub->key, sizeof sub->key, "%s", key);
    snprintf(sub->stream, sizeof sub->stream, "%s", stream);
    sub->job = job->number;
    sub->next = (uint64_t)from;
    sub->ready = true;
    sub->sent_s = monotonic();
    s->all[s->count++] = sub;
    return SCREE_OK;
}

static void handle(struct streams *s, const void *peer, size_t peer_size, zmq_msg_t *frame)
{
    const char *text = zmq_msg_data(frame);
    size_t size = zmq_msg_size(frame);
    struct scree_error error = {0};
    cJSON *json = NULL;
    size_t index = 0, of_peer;
    if (json_read(text, size, "header", &json, &error)) {
        send_error(s, peer, peer_size, "", "bad_request", &error);
        return;
    }
    const char *op = json_text(json, "op"), *key = json_text(json, "key");
    enum scree_status status = SCREE_OK;
    if (!op || !protocol_id_valid(key)) {
        scree_fail(&error, SCREE_INVALID, op ? "key" : "op", "op and key (1 to %d of [A-Za-z0-9._-]) are expected",
                   PROTOCOL_ID_MAX);
        send_error(s, peer, peer_size, "", "bad_request", &error);
        goto out;
    }
    struct subscription *sub = find(s, peer, peer_size, key, &index, &of_peer);
    s->user = auth_user(s->auth, frame);
    if (auth_permit(&s->user, "open", &error)) {
        status = SCREE_DENIED; // its subscription ends too: trust that was withdrawn is
        if (sub)
            drop(s, index);
    } else if (strcmp(op, "open") == 0) {
        if (sub)
            status = scree_fail(&error, SCREE_INVALID, "key", "key \"%s\" is in use", key);
        else
            status = open_subscription(s, peer, peer_size, key, json, of_peer, &error);
    } else if (strcmp(op, "credit") == 0) {
        double bytes = json_number(json, "bytes", -1);
        if (!(bytes >= 0))
            status = scree_fail(&error, SCREE_INVALID, "bytes", "bytes: a number from 0 on is expected");
        else if (sub) { // a subscription that has ended needs no credit, and that is no error
            double total = (double)sub->credit + bytes;
            sub->credit = total > PROTOCOL_CREDIT_MAX ? PROTOCOL_CREDIT_MAX : (int64_t)total;
            sub->fresh = true;
            sub->ready = true;
        }
    } else if (strcmp(op, "close") == 0) {
        if (sub)
            drop(s, index);
    } else {
        scree_fail(&error, SCREE_INVALID, "op", "unknown operation \"%.32s\"", op);
        send_error(s, peer, peer_size, key, "bad_request", &error);
    }
    if (status)
        send_error(s, peer, peer_size, key, scree_status_word(status), &error);
out:
    cJSON_Delete(json);
}

void streams_receive(struct streams *s)
{
    for (int taken = 0; taken < 256; taken++) {
        zmq_msg_t frames[FRAMES_MAX];
        int count = 0, more = 1;
        while (more) { // a message of many frames is read to its end, and only its first frames kept
            zmq_msg_t frame;
            zmq_msg_init(&frame);
            if (zmq_msg_recv(&frame, s->socket, ZMQ_DONTWAIT) < 0) {
                zmq_msg_close(&frame);
                break;
            }
            more = zmq_msg_more(&frame);
            if (count < FRAMES_MAX)
                frames[count++] = frame;
            else
                zmq_msg_close(&frame);
        }
        if (count == 0)
            return;
        const void *peer = zmq_msg_data(&frames[0]);
        size_t peer_size = zmq_msg_size(&frames[0]);
        bool fits = peer_size <= PEER_MAX && count == 3 && zmq_msg_size(&frames[1]) == strlen(PROTOCOL_VERSION) &&
                    memcmp(zmq_msg_data(&frames[1]), PROTOCOL_VERSION, strlen(PROTOCOL_VERSION)) == 0;
        if (fits) {
            handle(s, peer, peer_size, &frames[2]);
        } else if (peer_size <= PEER_MAX) {
            struct scree_error error;
            scree_fail(&error, SCREE_INVALID, "", "two frames are expected: \"%s\" and a header", PROTOCOL_VERSION);
            send_error(s, peer, peer_size, "", "bad_request", &error);
        }
        for (int k = 0; k < count; k++)
            zmq_msg_close(&frames[k]);
    }
}
