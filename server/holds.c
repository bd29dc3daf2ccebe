/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Jobs that wait for room on the disk or in memory.
 *
 * Below the disk floor running jobs write a checkpoint into what the floor keeps
 * free, and are held; nothing starts. Held jobs go on by themselves. Being held is
 * not written to the journal: it is found out anew at every start. */
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <sys/statvfs.h>

#include "log.h"
#include "requests.h"
#include "scheduler_state.h"

#define GB         1e9
#define FULL_BYTES 4e6
enum { FAULTS_MAX = 6 }; // failures in a row after which a job fails

/* Decimal, as disks are sold: "1.9 GB", "12 MB". */
static char *text_of(double bytes, char out[32])
{
    snprintf(out, 32, bytes >= 0.1 * GB ? "%.1f GB" : "%.0f MB", bytes >= 0.1 * GB ? bytes / GB : bytes / 1e6);
    return out;
}

/* Hardly anything left: what then fails is not counted against the job. */
static bool disk_is_full(const struct scheduler *s)
{
    struct statvfs disk;
    return statvfs(s->config->data, &disk) == 0 && (double)disk.f_bavail * (double)disk.f_frsize < FULL_BYTES;
}

/* Fills `why` when there is less than the floor; by default that is 1 GB, or a twentieth of a small disk. */
static void look_at_disk(const struct scheduler *s, char why[JOB_NOTE_MAX])
{
    struct statvfs disk;
    char free_text[32], floor_text[32];
    why[0] = 0;
    if (statvfs(s->config->data, &disk) != 0)
        return;
    double unit = (double)disk.f_frsize, free_bytes = (double)disk.f_bavail * unit;
    double floor_bytes =
        s->config->disk_floor_gb >= 0 ? s->config->disk_floor_gb * GB : fmin(GB, 0.05 * (double)disk.f_blocks * unit);
    if (free_bytes < floor_bytes)
        snprintf(why, JOB_NOTE_MAX, "disk %s free, floor %s", text_of(free_bytes, free_text), text_of(floor_bytes, floor_text));
}

/* Fills `why` when the job's world does not fit beside those that run. */
static void look_at_memory(const struct scheduler *s, const struct job *job, char why[JOB_NOTE_MAX])
{
    double need = job->spec.scenario->cost(&job->spec).bytes, used = 0, room;
    char need_text[32], room_text[32];
    why[0] = 0;
    if (s->config->memory_gb >= 0) {
        for (size_t k = 0; k < s->count; k++)
            if (s->jobs[k]->run)
                used += s->jobs[k]->spec.scenario->cost(&s->jobs[k]->spec).bytes;
        room = s->config->memory_gb * GB - used;
    } else {
        room = requests_memory();
    }
    if (need > room)
        snprintf(why, JOB_NOTE_MAX, "needs %s of memory, %s to be had", text_of(need, need_text),
                 text_of(fmax(0, room), room_text));
}

static void hold(struct scheduler *s, struct job *job, enum hold what, const char *why)
{
    snprintf(job->why, sizeof job->why, "%s", why);
    job->hold = what;
    if (job->state != JOB_HELD)
        scheduler_set_state(s, job, JOB_HELD);
}

bool holds_stop(struct scheduler *s, struct job *job)
{
    char why[JOB_NOTE_MAX];
    if (*s->disk_low) {
        hold(s, job, HOLD_DISK, s->disk_low);
        return true;
    }
    look_at_memory(s, job, why);
    if (*why)
        hold(s, job, HOLD_MEMORY, why);
    return *why;
}

bool holds_fault(struct scheduler *s, struct job *job, const struct scree_error *error)
{
    char why[JOB_NOTE_MAX];
    if (error->status != SCREE_IO && error->status != SCREE_NO_MEMORY)
        return false;
    look_at_disk(s, s->disk_low);
    if (!*s->disk_low && !disk_is_full(s) && ++job->faults > FAULTS_MAX)
        return false;
    snprintf(why, sizeof why, "%.400s; tried again soon", error->message);
    job->retry_at = scheduler_monotonic() + fmin(60, ldexp(0.5, job->faults));
    log_line(LOG_WARNING, "job=%s fault=%d %s", job->id, job->faults, error->message);
    hold(s, job, HOLD_FAULT, why);
    return true;
}

static void release(struct scheduler *s, struct job *job)
{
    char why[JOB_NOTE_MAX] = "";
    if (*s->disk_low)
        snprintf(why, sizeof why, "%s", s->disk_low);
    else if (job->hold == HOLD_MEMORY)
        look_at_memory(s, job, why);
    if (*why)
        snprintf(job->why, sizeof job->why, "%s", why);
    else if (job->hold == HOLD_FAULT && scheduler_monotonic() < job->retry_at)
        return;
    else if (job->recording) {
        scheduler_set_state(s, job, JOB_RUNNING);
        scheduler_record_again(s, job);
    } else {
        scheduler_set_state(s, job, JOB_QUEUED);
    }
}

void holds_turn(struct scheduler *s)
{
    double now = scheduler_monotonic();
    if (s->closing || now - s->looked_s < 0.5)
        return;
    s->looked_s = now;
    look_at_disk(s, s->disk_low);
    for (size_t k = 0; k < s->count; k++) {
        struct job *job = s->jobs[k];
        if (job->late)
            scheduler_enter(s, job, job->verdict_state);
        else if (*s->disk_low && job->run && !job->recording)
            scheduler_order(job, RUN_HOLD);
        else if (job->state == JOB_HELD)
            release(s, job);
    }
}
