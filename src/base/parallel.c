/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Barriers come twice a step, some microseconds apart, so members spin before
 * they sleep in the kernel (not at all when they outnumber the processors);
 * between runs they sleep on a condition. */
#include "base/parallel.h"

#include <linux/futex.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <unistd.h>

enum { SPIN = 10000 }; // pauses, some hundreds of microseconds: a wake-up takes as long on a virtual machine

struct member {
    struct team *team;
    pthread_t thread;
    int number;
};

struct team {
    int size, started, spin;
    struct member *members; // [1 .. size-1] are threads of ours
    pthread_mutex_t lock;
    pthread_cond_t wake;
    unsigned long run; // number of the current run; under lock
    int stop;          // under lock
    void (*work)(void *context, int member);
    void *context;
    _Alignas(64) atomic_int waiting;
    _Alignas(64) atomic_uint phase;
    atomic_int asleep; // members that may sleep on phase
};

void team_barrier(struct team *team)
{
    if (team->size == 1)
        return;
    unsigned phase = atomic_load_explicit(&team->phase, memory_order_acquire);
    if (atomic_fetch_add_explicit(&team->waiting, 1, memory_order_acq_rel) == team->size - 1) {
        atomic_store_explicit(&team->waiting, 0, memory_order_relaxed);
        atomic_store(&team->phase, phase + 1);
        if (atomic_load(&team->asleep) > 0)
            syscall(SYS_futex, &team->phase, FUTEX_WAKE_PRIVATE, team->size, NULL, NULL, 0);
        return;
    }
    for (int spins = 0; spins < team->spin; spins++) {
        if (atomic_load_explicit(&team->phase, memory_order_acquire) != phase)
            return;
        __builtin_ia32_pause();
    }
    atomic_fetch_add(&team->asleep, 1);
    while (atomic_load(&team->phase) == phase)
        syscall(SYS_futex, &team->phase, FUTEX_WAIT_PRIVATE, phase, NULL, NULL, 0);
    atomic_fetch_sub(&team->asleep, 1);
}

static void *member_main(void *argument)
{
    struct member *self = argument;
    struct team *team = self->team;
    for (unsigned long done = 0;;) {
        pthread_mutex_lock(&team->lock);
        while (team->run == done && !team->stop)
            pthread_cond_wait(&team->wake, &team->lock);
        done = team->run;
        int stop = team->stop;
        pthread_mutex_unlock(&team->lock);
        if (stop)
            return NULL;
        team->work(team->context, self->number);
        team_barrier(team);
    }
}

enum scree_status team_create(int size, struct team **out, struct scree_error *err)
{
    struct team *team = aligned_alloc(64, (sizeof *team + 63) / 64 * 64);
    if (!team)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a team of %d threads", size);
    *team = (struct team){.size = size, .started = 1, .lock = PTHREAD_MUTEX_INITIALIZER, .wake = PTHREAD_COND_INITIALIZER};
    team->spin = size <= sysconf(_SC_NPROCESSORS_ONLN) ? SPIN : 0;
    team->members = calloc((size_t)size, sizeof *team->members);
    if (!team->members) {
        scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a team of %d threads", size);
        goto fail;
    }
    for (int k = 1; k < size; k++) {
        team->members[k] = (struct member){.team = team, .number = k};
        if (pthread_create(&team->members[k].thread, NULL, member_main, &team->members[k]) != 0) {
            scree_fail(err, SCREE_NO_MEMORY, "threads", "the system gave only %d of %d threads", k, size);
            goto fail;
        }
        team->started = k + 1;
    }
    *out = team;
    return SCREE_OK;
fail:
    team_free(team);
    return SCREE_NO_MEMORY;
}

void team_free(struct team *team)
{
    if (!team)
        return;
    pthread_mutex_lock(&team->lock);
    team->stop = 1;
    pthread_cond_broadcast(&team->wake);
    pthread_mutex_unlock(&team->lock);
    for (int k = 1; k < team->started; k++)
        pthread_join(team->members[k].thread, NULL);
    pthread_cond_destroy(&team->wake);
    pthread_mutex_destroy(&team->lock);
    free(team->members);
    free(team);
}

int team_size(const struct team *team)
{
    return team->size;
}

void team_run(struct team *team, void (*work)(void *context, int member), void *context)
{
    if (team->size > 1) {
        pthread_mutex_lock(&team->lock);
        team->work = work;
        team->context = context;
        team->run++;
        pthread_cond_broadcast(&team->wake);
        pthread_mutex_unlock(&team->lock);
    }
    work(context, 0);
    team_barrier(team);
}
