/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See gate.h. A connection is two descriptors and a buffer a way. It has proved
 * itself once the daemon has sent READY, the end of a CURVE handshake (ZeroMQ RFC
 * 25): frames up to there are not encrypted and are read here. */
#include "gate.h"

#include <arpa/inet.h>
#include <errno.h>
#include <math.h>
#include <netdb.h>
#include <netinet/tcp.h>
#include <pthread.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/epoll.h>
#include <sys/eventfd.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "log.h"
#include "protocol/frame.h"

enum {
    BUFFER_BYTES = 32 << 10,
    STRANGER_BYTES = 2 << 10, // a handshake sends 64 + 202 + some 400
    GREETING_BYTES = 64,      // of ZMTP 3
    WATCHED_BYTES = 1 << 10,  // of the daemon's side, in which READY must come
    ACCEPTS_PER_S = 500,
    SWEEP_MS = 250,
    CLOSING_S = 1
};

struct way { // bytes on their way from one end to the other
    unsigned char bytes[BUFFER_BYTES];
    size_t from, to;
};

struct passage {
    int fd[2];          // 0: the peer, 1: the daemon
    struct way way[2];  // 0: from the peer, 1: to the peer
    uint32_t events[2]; // as told to epoll
    bool proven, closed;
    double since;
    size_t spoken; // bytes from the peer while it was a stranger
    unsigned char heard[WATCHED_BYTES];
    size_t heard_size;
    struct sockaddr_storage address;
    struct passage *next; // in the list of all, newest first
};

struct gate {
    const struct config *config;
    int epoll_fd, stop_fd, listeners[GATE_SOCKETS];
    char inner[GATE_SOCKETS][CONFIG_PATH_MAX];
    struct passage *all;
    int count, strangers, strangers_max;
    double tokens, filled_at, sweep_at;
    unsigned long dropped;
    pthread_t thread;
    bool started;
};

static double monotonic(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* ---- endpoints ---- */

enum scree_status gate_inner(const struct config *config, int index, char out[CONFIG_PATH_MAX], struct scree_error *err)
{
    static const char *const names[GATE_SOCKETS] = {"net-control", "net-stream", "net-events"};
    return protocol_endpoint(config->runtime, names[index], out, CONFIG_PATH_MAX, err);
}

enum scree_status gate_outer(const struct config *config, int index, char out[CONFIG_PATH_MAX], struct scree_error *err)
{
    const char *colon = strrchr(config->network, ':');
    int length = (int)(colon - config->network);
    if (snprintf(out, CONFIG_PATH_MAX, "%.*s:%ld", length, config->network, strtol(colon + 1, NULL, 10) + index) >= CONFIG_PATH_MAX)
        return scree_fail(err, SCREE_INVALID, "listen", "listen: the endpoint is too long");
    return SCREE_OK;
}

/* A listening TCP socket at an outer endpoint. */
static enum scree_status open_listener(const char *endpoint, int *out, struct scree_error *err)
{
    char host[256];
    const char *address = endpoint + strlen("tcp://"), *colon = strrchr(address, ':');
    struct addrinfo hints = {.ai_socktype = SOCK_STREAM, .ai_flags = AI_PASSIVE | AI_NUMERICHOST | AI_NUMERICSERV}, *found = NULL;
    size_t length = (size_t)(colon - address);
    bool brackets = *address == '[' && length > 1 && colon[-1] == ']';
    snprintf(host, sizeof host, "%.*s", (int)(brackets ? length - 2 : length), address + brackets);
    int wrong = getaddrinfo(host, colon + 1, &hints, &found), yes = 1;
    if (wrong)
        return scree_fail(err, SCREE_INVALID, "listen", "listen: %s: %s (an address in digits is expected)", endpoint,
                          gai_strerror(wrong));
    int fd = socket(found->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    bool good = fd >= 0 && setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) == 0 &&
                bind(fd, found->ai_addr, found->ai_addrlen) == 0 && listen(fd, 128) == 0;
    int why = errno;
    freeaddrinfo(found);
    if (good) {
        *out = fd;
        return SCREE_OK;
    }
    if (fd >= 0)
        close(fd);
    return scree_fail(err, SCREE_IO, "listen", "cannot listen on %s: %s", endpoint, strerror(why));
}

/* ---- passages ---- */

/* An epoll datum: the passage's address with the end in its lowest bit, or a listener's number (small). */
static uint64_t datum(const struct passage *p, int which)
{
    return (uint64_t)(uintptr_t)p | (uint64_t)which;
}

static void watch(struct gate *g, struct passage *p)
{
    for (int k = 0; k < 2; k++) {
        /* An end is read when the way from it is empty, and written when the way to it is not. */
        const struct way *out = &p->way[k], *in = &p->way[!k];
        uint32_t wanted = (out->from == out->to ? EPOLLIN : 0u) | (in->from != in->to ? EPOLLOUT : 0u);
        struct epoll_event event = {.events = wanted, .data.u64 = datum(p, k)};
        if (wanted != p->events[k] && epoll_ctl(g->epoll_fd, EPOLL_CTL_MOD, p->fd[k], &event) == 0)
            p->events[k] = wanted;
    }
}

/* Closes its ends. It is freed at the end of the turn: events of this turn may still name it. */
static void drop(struct gate *g, struct passage *p)
{
    if (p->closed)
        return;
    p->closed = true;
    close(p->fd[0]);
    close(p->fd[1]);
    g->count--;
    g->strangers -= !p->proven;
}

static void bury(struct gate *g)
{
    for (struct passage **link = &g->all; *link;) {
        struct passage *p = *link;
        if (p->closed) {
            *link = p->next;
            free(p);
        } else {
            link = &p->next;
        }
    }
}

static bool same_address(const struct sockaddr_storage *a, const struct sockaddr_storage *b)
{
    if (a->ss_family != b->ss_family)
        return false;
    if (a->ss_family == AF_INET)
        return ((const struct sockaddr_in *)a)->sin_addr.s_addr == ((const struct sockaddr_in *)b)->sin_addr.s_addr;
    /* Of IPv6 the first 64 bits: a host has as many addresses as it likes below them. */
    return memcmp(&((const struct sockaddr_in6 *)a)->sin6_addr, &((const struct sockaddr_in6 *)b)->sin6_addr, 8) == 0;
}

/* Makes room for a stranger from `address`: the oldest of its own if it holds a
 * quarter of the places, else the oldest of all. */
static void make_room(struct gate *g, const struct sockaddr_storage *address)
{
    struct passage *oldest = NULL, *own = NULL;
    int held = 0;
    if (g->strangers < g->strangers_max)
        return;
    for (struct passage *p = g->all; p; p = p->next) {
        if (p->closed || p->proven)
            continue;
        oldest = p; // the list has the newest first
        if (same_address(&p->address, address)) {
            own = p;
            held++;
        }
    }
    g->dropped++;
    if (own && held >= g->strangers_max / 4)
        drop(g, own);
    else if (oldest)
        drop(g, oldest);
}

static int connect_inner(const char *endpoint)
{
    struct sockaddr_un address = {.sun_family = AF_UNIX};
    int fd = socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    snprintf(address.sun_path, sizeof address.sun_path, "%s", endpoint + strlen("ipc://"));
    if (fd >= 0 && connect(fd, (const struct sockaddr *)&address, sizeof address) != 0) {
        close(fd);
        return -1;
    }
    return fd;
}

static void set_up(int fd)
{
    int yes = 1, idle = 60, interval = 15, tries = 4;
    setsockopt(fd, SOL_SOCKET, SO_KEEPALIVE, &yes, sizeof yes);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPIDLE, &idle, sizeof idle);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPINTVL, &interval, sizeof interval);
    setsockopt(fd, IPPROTO_TCP, TCP_KEEPCNT, &tries, sizeof tries);
    setsockopt(fd, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);
}

static void let_in(struct gate *g, int index, int fd, const struct sockaddr_storage *address, double now)
{
    if (g->count - g->strangers >= g->config->max_connections - g->strangers_max) {
        g->dropped++;
        close(fd);
        return;
    }
    make_room(g, address);
    int inner = connect_inner(g->inner[index]);
    struct passage *p = inner >= 0 ? calloc(1, sizeof *p) : NULL;
    if (!p) {
        g->dropped++;
        close(fd);
        if (inner >= 0)
            close(inner);
        return;
    }
    set_up(fd);
    p->fd[0] = fd;
    p->fd[1] = inner;
    p->address = *address;
    p->since = now;
    p->next = g->all;
    g->all = p;
    g->count++;
    g->strangers++;
    for (int k = 0; k < 2; k++) {
        struct epoll_event event = {.events = EPOLLIN, .data.u64 = datum(p, k)};
        p->events[k] = EPOLLIN;
        if (epoll_ctl(g->epoll_fd, EPOLL_CTL_ADD, p->fd[k], &event) != 0)
            drop(g, p);
    }
}

/* As many connections as the second's share allows; the rest wait in the kernel. */
static void accept_some(struct gate *g, int index, double now)
{
    g->tokens += (now - g->filled_at) * ACCEPTS_PER_S;
    g->tokens = g->tokens < 64 ? g->tokens : 64;
    g->filled_at = now;
    while (g->tokens >= 1) {
        struct sockaddr_storage address = {0};
        socklen_t size = sizeof address;
        int fd = accept4(g->listeners[index], (struct sockaddr *)&address, &size, SOCK_CLOEXEC | SOCK_NONBLOCK);
        if (fd < 0)
            return;
        g->tokens -= 1;
        let_in(g, index, fd, &address, now);
    }
}

/* ---- bytes ---- */

/* Looks for READY among the frames that the daemon sends in clear: true once it
 * has come, *gone when it cannot come any more. */
static bool hears_ready(const struct passage *p, bool *gone)
{
    *gone = false;
    for (size_t at = GREETING_BYTES; at + 2 < p->heard_size;) {
        const unsigned char *frame = p->heard + at;
        if (frame[0] != 4) { // a short command: all of a handshake's are
            *gone = true;
            return false;
        }
        if (frame[2] == 5 && at + 8 <= p->heard_size && memcmp(frame + 3, "READY", 5) == 0)
            return true;
        at += 2u + frame[1];
    }
    *gone = p->heard_size == WATCHED_BYTES;
    return false;
}

static bool pass_muster(struct gate *g, struct passage *p, int which, const unsigned char *bytes, size_t size)
{
    if (p->proven)
        return true;
    if (which == 0) {
        p->spoken += size;
        return p->spoken <= STRANGER_BYTES;
    }
    bool gone;
    size_t room = WATCHED_BYTES - p->heard_size, kept = size < room ? size : room;
    memcpy(p->heard + p->heard_size, bytes, kept);
    p->heard_size += kept;
    if (hears_ready(p, &gone)) {
        p->proven = true;
        g->strangers--;
    }
    return !gone;
}

/* Writes what waits for the other end; false when that end is gone. */
static bool flush_way(struct way *way, int fd)
{
    while (way->from < way->to) {
        ssize_t sent = send(fd, way->bytes + way->from, way->to - way->from, MSG_NOSIGNAL | MSG_DONTWAIT);
        if (sent <= 0)
            return sent < 0 && (errno == EAGAIN || errno == EINTR);
        way->from += (size_t)sent;
    }
    way->from = way->to = 0;
    return true;
}

/* Something can be done at one end. */
static void serve(struct gate *g, struct passage *p, int which, uint32_t events)
{
    struct way *out = &p->way[which], *in = &p->way[!which];
    bool good = true;
    if (p->closed)
        return;
    if (events & EPOLLOUT)
        good = flush_way(in, p->fd[which]);
    if (good && events & (EPOLLIN | EPOLLHUP | EPOLLERR) && out->from == out->to) {
        /* A stranger's bytes beyond the limit are not even read. */
        size_t room = p->proven || which == 1 ? BUFFER_BYTES : STRANGER_BYTES + 1;
        ssize_t got = recv(p->fd[which], out->bytes, room, MSG_DONTWAIT);
        if (got > 0) {
            out->to = (size_t)got;
            good = pass_muster(g, p, which, out->bytes, (size_t)got) && flush_way(out, p->fd[!which]);
        } else {
            good = got < 0 && (errno == EAGAIN || errno == EINTR);
        }
    }
    if (good)
        watch(g, p);
    else
        drop(g, p);
}

/* ---- the thread ---- */

static void sweep(struct gate *g, double now)
{
    for (struct passage *p = g->all; p; p = p->next)
        if (!p->closed && !p->proven && now - p->since > g->config->handshake_s) {
            g->dropped++;
            drop(g, p);
        }
    if (g->dropped > 0) {
        log_line(LOG_WARNING, "gate dropped=%lu connections=%d strangers=%d", g->dropped, g->count, g->strangers);
        g->dropped = 0;
    }
}

/* Nobody is let in any more. */
static void shut(struct gate *g)
{
    for (int k = 0; k < GATE_SOCKETS; k++)
        epoll_ctl(g->epoll_fd, EPOLL_CTL_DEL, g->listeners[k], NULL);
    epoll_ctl(g->epoll_fd, EPOLL_CTL_DEL, g->stop_fd, NULL);
}

static void *gate_main(void *argument)
{
    struct gate *g = argument;
    pthread_setname_np(pthread_self(), "gate"); // as `top -H` shows it
    for (double end = INFINITY; g->count > 0 || end == INFINITY;) {
        struct epoll_event events[64];
        /* Listeners stay ready while their share of the second is used up: then the turn waits for the next share. */
        int count = epoll_wait(g->epoll_fd, events, 64, SWEEP_MS);
        double now = monotonic();
        bool starved = false;
        if (now > end)
            break;
        for (int k = 0; k < count; k++) {
            uint64_t what = events[k].data.u64;
            if (what == UINT64_MAX) {
                shut(g);
                end = now + CLOSING_S;
                continue;
            }
            if (what < GATE_SOCKETS) {
                accept_some(g, (int)what, now);
                starved |= g->tokens < 1;
                continue;
            }
            serve(g, (struct passage *)(uintptr_t)(what & ~(uint64_t)1), (int)(what & 1), events[k].events);
        }
        if (now >= g->sweep_at) {
            sweep(g, now);
            g->sweep_at = now + 1;
        }
        bury(g);
        if (starved && count < 8)
            usleep(2000);
    }
    return NULL;
}

/* Every passage takes two descriptors here and one in ZeroMQ. */
static enum scree_status check_descriptors(const struct config *config, struct scree_error *err)
{
    struct rlimit files;
    rlim_t needed = 3 * (rlim_t)config->max_connections + 256;
    if (getrlimit(RLIMIT_NOFILE, &files) == 0 && files.rlim_cur < needed)
        return scree_fail(err, SCREE_INVALID, "max-connections",
                          "max-connections: %d takes %llu file descriptors; %llu are allowed (ulimit -n)", config->max_connections,
                          (unsigned long long)needed, (unsigned long long)files.rlim_cur);
    return SCREE_OK;
}

static enum scree_status open_all(struct gate *g, struct scree_error *err)
{
    char outer[CONFIG_PATH_MAX];
    enum scree_status status = check_descriptors(g->config, err);
    struct epoll_event event = {.events = EPOLLIN, .data.u64 = UINT64_MAX};
    if (status)
        return status;
    g->epoll_fd = epoll_create1(EPOLL_CLOEXEC);
    g->stop_fd = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (g->epoll_fd < 0 || g->stop_fd < 0 || epoll_ctl(g->epoll_fd, EPOLL_CTL_ADD, g->stop_fd, &event) != 0)
        return scree_fail(err, SCREE_IO, "listen", "no resources for the network: %s", strerror(errno));
    for (int k = 0; k < GATE_SOCKETS; k++) {
        if ((status = gate_inner(g->config, k, g->inner[k], err)) || (status = gate_outer(g->config, k, outer, err)) ||
            (status = open_listener(outer, &g->listeners[k], err)))
            return status;
        event.data.u64 = (uint64_t)k;
        if (epoll_ctl(g->epoll_fd, EPOLL_CTL_ADD, g->listeners[k], &event) != 0)
            return scree_fail(err, SCREE_IO, "listen", "no resources for the network: %s", strerror(errno));
    }
    return SCREE_OK;
}

enum scree_status gate_open(struct gate **out, const struct config *config, struct scree_error *err)
{
    struct gate *g = calloc(1, sizeof *g);
    if (!g)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the network");
    g->config = config;
    g->epoll_fd = g->stop_fd = -1;
    for (int k = 0; k < GATE_SOCKETS; k++)
        g->listeners[k] = -1;
    g->strangers_max = config->max_connections / 16 > 8 ? config->max_connections / 16 : 8;
    g->filled_at = monotonic();
    enum scree_status status = open_all(g, err);
    if (!status && pthread_create(&g->thread, NULL, gate_main, g) != 0)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no thread for the network");
    g->started = !status;
    if (status)
        gate_close(g);
    else
        *out = g;
    return status;
}

void gate_close(struct gate *g)
{
    if (!g)
        return;
    if (g->started) {
        eventfd_write(g->stop_fd, 1);
        pthread_join(g->thread, NULL);
    }
    for (struct passage *p = g->all; p; p = p->next)
        drop(g, p);
    bury(g);
    for (int k = 0; k < GATE_SOCKETS; k++)
        if (g->listeners[k] >= 0)
            close(g->listeners[k]);
    if (g->stop_fd >= 0)
        close(g->stop_fd);
    if (g->epoll_fd >= 0)
        close(g->epoll_fd);
    free(g);
}
