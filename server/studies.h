/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Every study of a data directory. A study is a durable parent of ordinary jobs,
 * its trials: it submits them, reads how they ended, and decides what comes next.
 * Runs on the control thread, on top of the scheduler. */
#ifndef SCREE_SERVER_STUDIES_H
#define SCREE_SERVER_STUDIES_H

#include "scheduler.h"
#include "study.h"

struct studies;

/* Told when a study has another state. */
struct studies_watch {
    void (*changed)(void *context, const struct study *study);
    void *context;
};

/* The scheduler must be open and outlive the studies. */
enum scree_status studies_open(struct studies **out, struct scheduler *scheduler, const struct config *config,
                               const struct studies_watch *watch, struct scree_error *err);
void studies_close(struct studies *studies);

/* Looks at trials that have ended and submits the next ones. True when the scheduler has something to do for it. */
bool studies_turn(struct studies *studies);

/* Commits a study. *reused: a finished one of the same spec and build, or the one of the same request, answers. */
enum scree_status studies_submit(struct studies *studies, const char *request, const cJSON *json, bool again, struct study **out,
                                 bool *reused, struct scree_error *err);
/* Cancels what runs of it; an ended study stays as it is. */
enum scree_status studies_cancel(struct studies *studies, struct study *study, struct scree_error *err);

/* Pauses or resumes what runs of it; until it is resumed nothing else is started. `request` as for scheduler_steer: one that
 * was made before does nothing. SCREE_CONFLICT: the study has ended. */
enum scree_status studies_steer(struct studies *studies, const char *request, struct study *study, enum command_op op,
                                struct scree_error *err);

/* By id ("s3"), NULL if there is none. */
struct study *studies_find(struct studies *studies, const char *id);
size_t studies_count(const struct studies *studies);
struct study *studies_at(struct studies *studies, size_t index);

/* The id of the study that submitted a job, "" if nobody did. */
void studies_parent(const struct job *job, char out[JOB_ID_MAX]);

#endif
