/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What lies in a job's folder that a run can go on from.
 *
 * A checkpoint's name says its step and the number of the last command that is in
 * it, hence the spec that it must have been written with; whether it is sound is
 * found when it is read. */
#include <dirent.h>
#include <errno.h>
#include <inttypes.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "io/files.h"
#include "protocol/job_json.h"
#include "scheduler_state.h"

struct found {
    uint64_t step;
    int64_t applied;
    char name[64];
};

/* Later steps first, then later commands. */
static int newest_first(const void *a, const void *b)
{
    const struct found *x = a, *y = b;
    if (x->step != y->step)
        return x->step < y->step ? 1 : -1;
    return x->applied < y->applied ? 1 : x->applied > y->applied ? -1 : 0;
}

/* The checkpoints of a job, newest first; of more than fit some are left out. */
enum { FOUND_MAX = 64 };
static size_t find(const struct scheduler *s, const struct job *job, struct found all[FOUND_MAX])
{
    char folder[CONFIG_PATH_MAX + 64];
    size_t count = 0;
    snprintf(folder, sizeof folder, "%s/jobs/%s", s->config->data, job->id);
    DIR *directory = opendir(folder);
    for (struct dirent *entry; directory && count < FOUND_MAX && (entry = readdir(directory));) {
        int end = 0;
        struct found *f = &all[count];
        if (strlen(entry->d_name) < sizeof f->name &&
            sscanf(entry->d_name, "checkpoint-%" SCNu64 "-%" SCNd64 ".h5%n", &f->step, &f->applied, &end) == 2 && end > 0 &&
            !entry->d_name[end]) {
            snprintf(f->name, sizeof f->name, "%s", entry->d_name);
            count++;
        }
    }
    if (directory)
        closedir(directory);
    qsort(all, count, sizeof *all, newest_first);
    return count;
}

static enum scree_status start_of(const struct scheduler *s, const struct job *job, const struct found *found,
                                  struct run_start *out, struct scree_error *err)
{
    snprintf(out->path, sizeof out->path, "%s/jobs/%s/%s", s->config->data, job->id, found->name);
    out->step = found->step;
    out->applied = found->applied;
    return steering_compose(s, job, found->applied, false, &out->spec, err);
}

bool restart_newest(const struct scheduler *s, const struct job *job, struct run_start *out)
{
    struct found found[FOUND_MAX];
    return find(s, job, found) > 0 && start_of(s, job, &found[0], out, NULL) == SCREE_OK;
}

static enum scree_status read_origin(const struct scheduler *s, const struct job *job, struct run *run, struct scree_error *err)
{
    cJSON *json = NULL;
    enum scree_status status = json_read(job->origin, strlen(job->origin), "origin", &json, err);
    const cJSON *fork = json_get(json, "fork"), *replay = json_get(json, "replay");
    const char *file = json_text(fork, "file");
    if (!status && fork && !file)
        status = scree_fail(err, SCREE_CORRUPT, "", "the journal does not say what %s was forked from", job->id);
    if (!status && fork) {
        snprintf(run->origin.path, sizeof run->origin.path, "%s/jobs/%s", s->config->data, file);
        status = job_decode(json_get(fork, "spec"), &run->origin.spec, err);
    }
    if (!status && json_get(replay, "stop_step"))
        run->stop_step = (uint64_t)json_number(replay, "stop_step", 0);
    cJSON_Delete(json);
    return status;
}

enum scree_status restart_find(const struct scheduler *s, const struct job *job, struct run *run, struct scree_error *err)
{
    struct found found[FOUND_MAX];
    size_t count = find(s, job, found);
    enum scree_status status = *job->origin ? read_origin(s, job, run, err) : SCREE_OK;
    for (size_t k = 0; k < count && k < RUN_STARTS_MAX && !status; k++)
        status = start_of(s, job, &found[k], &run->starts[run->start_count++], err);
    return status;
}

void restart_forget(const struct scheduler *s, const struct job *job)
{
    struct found found[FOUND_MAX];
    for (size_t k = 0, count = find(s, job, found); k < count; k++) {
        char path[CONFIG_PATH_MAX + 128];
        snprintf(path, sizeof path, "%s/jobs/%s/%s", s->config->data, job->id, found[k].name);
        unlink(path);
    }
}

enum scree_status restart_link(const char *from, const char *to, struct scree_error *err)
{
    unlink(to);
    if (link(from, to) != 0)
        return scree_fail(err, SCREE_IO, "", "cannot keep the checkpoint %s for a fork: %s", from, strerror(errno));
    return files_settle(to, err);
}
