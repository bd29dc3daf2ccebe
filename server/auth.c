/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See auth.h. The list of trusted keys is looked at (one stat) with every message
 * from the network: `scree trust` takes effect at once, in both directions, and
 * needs no signal. A list that cannot be read lets nobody in. */
#include "auth.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

#include "log.h"

#define DOMAIN_LOCAL   "local"
#define DOMAIN_NETWORK "network"
#define OWNER_ID       "owner" // no Z85 key has five characters

/* zmq.h shows it with the drafts alone; the library takes it always. Without it a
 * connection is let in where no handler answers. */
#ifndef ZMQ_ZAP_ENFORCE_DOMAIN
#define ZMQ_ZAP_ENFORCE_DOMAIN 93
#endif

struct auth {
    void *socket;
    const struct config *config;
    struct key_pair key;
    struct trusted *list;
    size_t count;
    struct stat seen;     // of the list, when it was read; st_ino 0: there was none
    time_t refused_since; // the second of the log's last line about refusals
    unsigned long refused;
};

enum scree_status auth_check_endpoint(const char *endpoint, struct scree_error *err)
{
    if (strncmp(endpoint, "ipc:///", 7) != 0)
        return scree_fail(err, SCREE_INVALID, "listen", "listen: %s is neither ipc:///absolute/path nor tcp://ADDRESS:PORT",
                          endpoint);
    return SCREE_OK;
}

enum scree_status auth_check_network(const char *endpoint, struct scree_error *err)
{
    const char *address = endpoint + strlen("tcp://"), *colon = strrchr(address, ':');
    char *end = NULL;
    long port = colon ? strtol(colon + 1, &end, 10) : 0;
    if (!colon || colon == address || end == colon + 1 || *end || port < 1 || port > 65533)
        return scree_fail(
            err, SCREE_INVALID, "listen",
            "listen: %s is not of the form tcp://ADDRESS:PORT with a port in 1..65533 (the two after it are taken too)", endpoint);
    return SCREE_OK;
}

enum scree_status auth_runtime_dir(const char *path, struct scree_error *err)
{
    struct stat info;
    if (mkdir(path, 0700) == 0)
        return SCREE_OK;
    if (errno != EEXIST)
        return scree_fail(err, SCREE_IO, "runtime", "cannot make the runtime directory %s: %s", path, strerror(errno));
    if (lstat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return scree_fail(err, SCREE_IO, "runtime", "%s is not a directory", path);
    if (info.st_uid != geteuid())
        return scree_fail(err, SCREE_DENIED, "runtime", "the runtime directory %s belongs to user %u", path, (unsigned)info.st_uid);
    if ((info.st_mode & 0777) != 0700) {
        scree_fail(err, SCREE_DENIED, "runtime", "the runtime directory %s has mode %03o; others could reach the sockets", path,
                   (unsigned)(info.st_mode & 0777));
        scree_hint(err, "chmod 700 %s", path);
        return SCREE_DENIED;
    }
    return SCREE_OK;
}

/* ---- the list ---- */

static bool same_file(const struct stat *a, const struct stat *b)
{
    return a->st_ino == b->st_ino && a->st_dev == b->st_dev && a->st_size == b->st_size && a->st_mode == b->st_mode &&
           a->st_mtim.tv_sec == b->st_mtim.tv_sec && a->st_mtim.tv_nsec == b->st_mtim.tv_nsec;
}

/* Reads the list if it is another file than the one that was read. */
static enum scree_status read_list(struct auth *auth, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 16];
    struct stat now = {0};
    snprintf(path, sizeof path, "%s/trusted", auth->config->keys);
    if (stat(path, &now) != 0)
        now = (struct stat){0};
    if (same_file(&now, &auth->seen))
        return SCREE_OK;
    free(auth->list);
    auth->seen = now;
    enum scree_status status = trusted_read(auth->config->keys, &auth->list, &auth->count, err);
    if (!status)
        log_line(LOG_INFO, "keys=%s trusted=%zu", auth->config->keys, auth->count);
    return status;
}

static const struct trusted *find_trusted(struct auth *auth, const char *key)
{
    struct scree_error error;
    if (read_list(auth, &error))
        log_line(LOG_ERROR, "nobody is let in from the network: %s", error.message);
    for (size_t k = 0; k < auth->count; k++)
        if (strcmp(auth->list[k].key, key) == 0)
            return &auth->list[k];
    return NULL;
}

/* ---- the handler ---- */

static enum scree_status read_server_key(struct auth *auth, struct scree_error *err)
{
    char path[CONFIG_PATH_MAX + 16], public_key[KEY_TEXT_MAX];
    enum scree_status status = keys_folder_check(auth->config->keys, err);
    snprintf(path, sizeof path, "%s/server.key", auth->config->keys);
    if (!status)
        status = keys_read_pair(path, &auth->key, err);
    if (status == SCREE_NOT_FOUND) {
        err->status = status = SCREE_INVALID; // of the options: they ask for a network
        scree_hint(err, "a network endpoint needs a key: SCREE_KEYS=%s scree keygen server", auth->config->keys);
    }
    if (!status && (zmq_curve_public(public_key, auth->key.secret_key) != 0 || strcmp(public_key, auth->key.public_key) != 0))
        status = scree_fail(err, SCREE_CORRUPT, "keys", "%s: the two keys are not a pair", path);
    if (status)
        return status;
    return read_list(auth, err);
}

enum scree_status auth_open(struct auth **out, void *context, const struct config *config, struct scree_error *err)
{
    struct auth *auth = calloc(1, sizeof *auth);
    int no_linger = 0;
    enum scree_status status = SCREE_OK;
    if (!auth)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory");
    auth->config = config;
    if (!(auth->socket = zmq_socket(context, ZMQ_REP)) ||
        zmq_setsockopt(auth->socket, ZMQ_LINGER, &no_linger, sizeof no_linger) != 0 ||
        zmq_bind(auth->socket, "inproc://zeromq.zap.01") != 0)
        status = scree_fail(err, SCREE_IO, "", "no handler for who may connect: %s", zmq_strerror(errno));
    else if (*config->network)
        status = read_server_key(auth, err);
    if (status) {
        auth_close(auth);
        return status;
    }
    *out = auth;
    return SCREE_OK;
}

void auth_close(struct auth *auth)
{
    if (!auth)
        return;
    if (auth->socket)
        zmq_close(auth->socket);
    explicit_bzero(&auth->key, sizeof auth->key);
    free(auth->list);
    free(auth);
}

void *auth_socket(struct auth *auth)
{
    return auth->socket;
}

/* A line a second at most: strangers must not fill the disk. */
static void log_refusal(struct auth *auth, const char *key)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    auth->refused++;
    if (now.tv_sec == auth->refused_since)
        return;
    log_line(LOG_WARNING, "key=%s is not trusted; refused=%lu", key, auth->refused);
    auth->refused_since = now.tv_sec;
    auth->refused = 0;
}

/* The frames of RFC 27: version, request id, domain, address, identity, mechanism, credentials. */
enum { ZAP_VERSION, ZAP_REQUEST, ZAP_DOMAIN_NAME, ZAP_ADDRESS, ZAP_IDENTITY, ZAP_MECHANISM, ZAP_CREDENTIALS, ZAP_FRAMES };

static bool frame_is(zmq_msg_t *frame, const char *text)
{
    return zmq_msg_size(frame) == strlen(text) && memcmp(zmq_msg_data(frame), text, strlen(text)) == 0;
}

/* The user id of the connection that asks, in `id`; "" refuses it. */
static void judge(struct auth *auth, zmq_msg_t *frames, int count, char id[KEY_TEXT_MAX])
{
    *id = 0;
    if (count < ZAP_CREDENTIALS || !frame_is(&frames[ZAP_VERSION], "1.0"))
        return;
    if (frame_is(&frames[ZAP_DOMAIN_NAME], DOMAIN_LOCAL) && frame_is(&frames[ZAP_MECHANISM], "NULL")) {
        snprintf(id, KEY_TEXT_MAX, "%s", OWNER_ID);
        return;
    }
    if (!frame_is(&frames[ZAP_DOMAIN_NAME], DOMAIN_NETWORK) || !frame_is(&frames[ZAP_MECHANISM], "CURVE") || count != ZAP_FRAMES ||
        zmq_msg_size(&frames[ZAP_CREDENTIALS]) != 32)
        return;
    char key[KEY_TEXT_MAX];
    zmq_z85_encode(key, zmq_msg_data(&frames[ZAP_CREDENTIALS]), 32);
    if (find_trusted(auth, key))
        memcpy(id, key, sizeof key);
    else
        log_refusal(auth, key);
}

static void answer(struct auth *auth, zmq_msg_t *request, const char *id)
{
    const char *parts[] = {*id ? "200" : "400", *id ? "OK" : "not trusted", id, ""};
    zmq_send(auth->socket, "1.0", 3, ZMQ_SNDMORE | ZMQ_DONTWAIT);
    zmq_send(auth->socket, zmq_msg_data(request), zmq_msg_size(request), ZMQ_SNDMORE | ZMQ_DONTWAIT);
    for (int k = 0; k < 4; k++)
        zmq_send(auth->socket, parts[k], strlen(parts[k]), (k < 3 ? ZMQ_SNDMORE : 0) | ZMQ_DONTWAIT);
}

void auth_turn(struct auth *auth)
{
    for (int taken = 0; taken < 64; taken++) {
        zmq_msg_t frames[ZAP_FRAMES];
        char id[KEY_TEXT_MAX];
        int count = 0, total = 0, more = 1;
        while (more) {
            zmq_msg_t frame;
            zmq_msg_init(&frame);
            if (zmq_msg_recv(&frame, auth->socket, ZMQ_DONTWAIT) < 0) {
                zmq_msg_close(&frame);
                break;
            }
            more = zmq_msg_more(&frame);
            total++;
            if (count < ZAP_FRAMES)
                frames[count++] = frame;
            else
                zmq_msg_close(&frame);
        }
        if (count == 0)
            return;
        judge(auth, frames, total, id);
        if (count > ZAP_REQUEST)
            answer(auth, &frames[ZAP_REQUEST], id);
        for (int k = 0; k < count; k++)
            zmq_msg_close(&frames[k]);
    }
}

/* ---- sockets and messages ---- */

static enum scree_status guard(void *socket, const char *domain, struct scree_error *err)
{
    int enforce = 1;
    if (zmq_setsockopt(socket, ZMQ_ZAP_DOMAIN, domain, strlen(domain)) != 0 ||
        zmq_setsockopt(socket, ZMQ_ZAP_ENFORCE_DOMAIN, &enforce, sizeof enforce) != 0)
        return scree_fail(err, SCREE_INTERNAL, "", "a socket cannot be guarded: %s", zmq_strerror(errno));
    return SCREE_OK;
}

enum scree_status auth_guard_local(void *socket, struct scree_error *err)
{
    return guard(socket, DOMAIN_LOCAL, err);
}

enum scree_status auth_guard_network(const struct auth *auth, void *socket, struct scree_error *err)
{
    int server = 1, patience_ms = 1000 * (auth->config->handshake_s + 1);
    if (zmq_setsockopt(socket, ZMQ_CURVE_SERVER, &server, sizeof server) != 0 ||
        zmq_setsockopt(socket, ZMQ_CURVE_SECRETKEY, auth->key.secret_key, KEY_TEXT_MAX) != 0 ||
        zmq_setsockopt(socket, ZMQ_HANDSHAKE_IVL, &patience_ms, sizeof patience_ms) != 0)
        return scree_fail(err, SCREE_INTERNAL, "", "a socket cannot be encrypted: %s", zmq_strerror(errno));
    return guard(socket, DOMAIN_NETWORK, err);
}

struct user auth_user(struct auth *auth, zmq_msg_t *frame)
{
    struct user user = {.role = ROLE_NONE, .network = true};
    const char *id = zmq_msg_gets(frame, "User-Id");
    if (!id)
        return user;
    if (strcmp(id, OWNER_ID) == 0)
        return (struct user){.role = ROLE_ADMIN};
    const struct trusted *trusted = find_trusted(auth, id);
    if (trusted) {
        user.role = trusted->role;
        snprintf(user.name, sizeof user.name, "%s", trusted->name);
    }
    return user;
}

/* The least role for each operation of the control socket; what is not listed takes an admin. */
static const struct {
    const char *op;
    enum role role;
} roles[] = {
    {"ping", ROLE_VIEW},   {"check", ROLE_VIEW},      {"list", ROLE_VIEW},   {"show", ROLE_VIEW},     {"fetch", ROLE_VIEW},
    {"plot", ROLE_VIEW},   {"fetch_part", ROLE_VIEW}, {"open", ROLE_VIEW},   {"credit", ROLE_VIEW},   {"close", ROLE_VIEW},
    {"table", ROLE_VIEW},  {"submit", ROLE_SUBMIT},   {"mesh", ROLE_SUBMIT}, {"replay", ROLE_SUBMIT}, {"cancel", ROLE_STEER},
    {"pause", ROLE_STEER}, {"resume", ROLE_STEER},    {"set", ROLE_STEER},   {"fork", ROLE_STEER},    {"checkpoint", ROLE_STEER},
};

enum scree_status auth_permit(const struct user *user, const char *op, struct scree_error *err)
{
    enum role needed = ROLE_ADMIN;
    for (size_t k = 0; k < sizeof roles / sizeof *roles; k++)
        if (strcmp(roles[k].op, op) == 0)
            needed = roles[k].role;
    if (user->role >= needed)
        return SCREE_OK;
    if (user->role == ROLE_NONE) {
        scree_fail(err, SCREE_DENIED, "", "this key is not trusted, or no longer");
    } else {
        scree_fail(err, SCREE_DENIED, "", "%s has the role %s; %s takes %s", user->name, role_word(user->role), op,
                   role_word(needed));
        scree_hint(err, "on the daemon's machine: scree trust %s.pub --role %s", user->name, role_word(needed));
    }
    return SCREE_DENIED;
}
