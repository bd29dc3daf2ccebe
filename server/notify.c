/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See notify.h. The protocol is two dozen lines; libsystemd would be one more library for them. */
#include "notify.h"

#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "base/memory.h"
#include "log.h"

/* A running job, and when it was last seen to move. */
struct mark {
    int64_t job;
    uint64_t done; // steps, and chunks of all streams
    double since;
    bool told;
};

struct notify {
    int fd; // -1: nobody to tell
    struct sockaddr_un address;
    socklen_t address_size;
    double period_s, fed_at, stall_s; // period 0: no watchdog
    struct mark *marks;
    size_t count, room;
};

static double monotonic(void)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* Half of $WATCHDOG_USEC, if it is meant for this process. */
static double watchdog_period(void)
{
    const char *period = getenv("WATCHDOG_USEC"), *pid = getenv("WATCHDOG_PID");
    if (!period || (pid && strtol(pid, NULL, 10) != getpid()))
        return 0;
    return 0.5e-6 * strtod(period, NULL);
}

enum scree_status notify_open(struct notify **out, int stall_s, struct scree_error *err)
{
    const char *path = getenv("NOTIFY_SOCKET");
    struct notify *n = calloc(1, sizeof *n);
    if (!n)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory");
    n->fd = -1;
    n->stall_s = stall_s;
    n->address.sun_family = AF_UNIX;
    if (path && (*path == '/' || *path == '@') && path[1] && strlen(path) < sizeof n->address.sun_path) {
        memcpy(n->address.sun_path, path, strlen(path));
        if (*path == '@') // the abstract namespace
            n->address.sun_path[0] = 0;
        n->address_size = (socklen_t)(offsetof(struct sockaddr_un, sun_path) + strlen(path));
        n->fd = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
        n->period_s = watchdog_period();
    }
    *out = n;
    return SCREE_OK;
}

void notify_close(struct notify *n)
{
    if (!n)
        return;
    if (n->fd >= 0)
        close(n->fd);
    free(n->marks);
    free(n);
}

static void tell(struct notify *n, const char *state)
{
    if (n->fd >= 0 && sendto(n->fd, state, strlen(state), MSG_NOSIGNAL, (const struct sockaddr *)&n->address, n->address_size) < 0)
        log_line(LOG_WARNING, "the service manager could not be told %s", state);
}

void notify_ready(struct notify *n)
{
    tell(n, "READY=1");
}

void notify_stopping(struct notify *n)
{
    tell(n, "STOPPING=1");
}

/* ---- progress ---- */

static struct mark *mark_of(struct notify *n, const struct job *job, double now)
{
    for (size_t k = 0; k < n->count; k++)
        if (n->marks[k].job == job->number)
            return &n->marks[k];
    if (memory_grow((void **)&n->marks, &n->room, n->count + 1, sizeof *n->marks, NULL))
        return NULL;
    n->marks[n->count] = (struct mark){.job = job->number, .since = now};
    return &n->marks[n->count++];
}

static void forget_ended(struct notify *n, struct scheduler *scheduler)
{
    for (size_t k = 0; k < n->count;) {
        char id[JOB_ID_MAX];
        snprintf(id, sizeof id, "j%lld", (long long)n->marks[k].job);
        const struct job *job = scheduler_find(scheduler, id);
        if (job && job->state == JOB_RUNNING)
            k++;
        else
            n->marks[k] = n->marks[--n->count];
    }
}

/* Whether every running job has moved within stall_s; says once of each that has not. */
static bool all_move(struct notify *n, struct scheduler *scheduler, double now)
{
    bool moving = true;
    for (size_t k = 0; k < scheduler_count(scheduler); k++) {
        const struct job *job = scheduler_at(scheduler, k);
        struct mark *mark = job->state == JOB_RUNNING ? mark_of(n, job, now) : NULL;
        uint64_t done = job->report.steps;
        if (!mark)
            continue;
        for (size_t h = 0; h < job->report.head_count; h++)
            done += job->report.heads[h].chunks;
        if (done != mark->done)
            *mark = (struct mark){.job = job->number, .done = done, .since = now};
        if (now - mark->since <= n->stall_s)
            continue;
        if (!mark->told)
            log_line(LOG_ERROR, "job=%s has not moved for %.0f s: the watchdog is not fed any more", job->id, n->stall_s);
        mark->told = true;
        moving = false;
    }
    return moving;
}

void notify_turn(struct notify *n, struct scheduler *scheduler)
{
    double now = monotonic();
    if (n->fd < 0 || n->period_s <= 0 || now - n->fed_at < n->period_s)
        return;
    n->fed_at = now;
    forget_ended(n, scheduler);
    if (all_move(n, scheduler, now))
        tell(n, "WATCHDOG=1");
}
