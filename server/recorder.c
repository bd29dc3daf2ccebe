/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See recorder.h. */
#include "recorder.h"

#include <dirent.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>

#include "base/failpoint.h"

enum { USELESS_MAX = 3 };

struct recorder {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t work;
    bool stop;
    int wake_fd;
    struct record_order *waiting, *done; // oldest first
    struct errand *errands;              // oldest first
    pthread_cond_t errand_done;
    int useless;      // times in a row that libhdf5 could do nothing; the recorder's thread alone
    atomic_bool lost; // and will do nothing any more
};

/* On the stack of the thread that waits for it. */
struct errand {
    enum scree_status (*run)(void *context, struct scree_error *err);
    void *context;
    struct scree_error *err;
    enum scree_status status;
    bool done;
    const struct record_order *behind; // the last order that was asked for before it
    struct errand *next;
};

static void append(struct record_order **list, struct record_order *order)
{
    order->next = NULL;
    while (*list)
        list = &(*list)->next;
    *list = order;
}

struct reader {
    struct chunk_log *log;
    const struct record_order *order;
};

static enum scree_status next_chunk(void *context, const char *stream, uint64_t seq, struct scree_chunk *chunk, bool *more,
                                    struct scree_error *err)
{
    struct reader *reader = context;
    struct chunk_row row;
    enum scree_status status = chunk_log_get(reader->log, stream, seq, &row, more, err);
    if (status || !*more)
        return status;
    for (size_t k = 0; k < reader->order->stream_count; k++)
        if (strcmp(reader->order->streams[k]->name, stream) == 0)
            chunk->stream = reader->order->streams[k];
    chunk->seq = seq;
    chunk->t0_s = row.t0_s;
    chunk->dt_s = row.dt_s;
    chunk->rows = row.rows;
    chunk->values = row.payload;
    return SCREE_OK;
}

/* checkpoint-STEP-APPLIED.h5: the newest two of them stay, older ones and a write that was cut short go. */
static void remove_older(const char *path)
{
    char folder[CONFIG_PATH_MAX + 96], name[CONFIG_PATH_MAX + 400];
    uint64_t steps[2] = {0};
    snprintf(folder, sizeof folder, "%s", path);
    *strrchr(folder, '/') = 0;
    for (int pass = 0; pass < 2; pass++) {
        DIR *directory = opendir(folder);
        for (struct dirent *entry; directory && (entry = readdir(directory));) {
            unsigned long long step;
            long long applied;
            int end = 0;
            if (sscanf(entry->d_name, "checkpoint-%llu-%lld.h5%n", &step, &applied, &end) != 2 || end == 0)
                continue;
            bool whole = !entry->d_name[end];
            if (pass == 0 && whole && step > steps[0]) {
                steps[1] = steps[0];
                steps[0] = step;
            } else if (pass == 0 && whole && step > steps[1] && step < steps[0]) {
                steps[1] = step;
            } else if (pass == 1 && (step < steps[1] || !whole)) {
                snprintf(name, sizeof name, "%s/%s", folder, entry->d_name);
                remove(name);
            }
        }
        if (directory)
            closedir(directory);
    }
}

static void write_image(struct record_order *order)
{
    if (order->image) // else there was no memory for the copy, and the order only tells so
        order->status = scree_image_write(order->image, order->path, &order->error);
    scree_image_free(order->image);
    order->image = NULL;
    if (!order->status && order->kind == RECORD_CHECKPOINT)
        remove_older(order->path);
    FAILPOINT("image-recorded");
}

static void carry_out(struct record_order *order)
{
    if (order->kind != RECORD_RESULT) {
        write_image(order);
        return;
    }
    struct reader reader = {.order = order};
    if (order->write) {
        order->status = order->write(order, &order->error);
        return;
    }
    const struct scree_source source = {.next = next_chunk, .context = &reader};
    const struct scree_result result = {.path = order->path,
                                        .spec_json = order->spec_text,
                                        .journal_json = order->journal_text ? order->journal_text : "[]",
                                        .job_id = order->id,
                                        .title = order->spec.title,
                                        .state = order->state,
                                        .verdict = scree_verdict_word(order->report.verdict),
                                        .evidence = order->report.evidence,
                                        .job = &order->spec,
                                        .numbers = order->report.numbers,
                                        .number_count = order->report.number_count,
                                        .steps = order->report.steps,
                                        .time_s = order->report.time_s,
                                        .streams = order->streams,
                                        .stream_count = order->stream_count};
    order->status = chunk_log_open(&reader.log, order->log_path, false, &order->error);
    if (!order->status)
        order->status = scree_result_write(&result, &source, &order->error);
    chunk_log_close(reader.log);
    FAILPOINT("result-recorded");
}

/* Under the lock: the errand at the head, if every order before it is through. */
static struct errand *next_errand(struct recorder *self)
{
    struct errand *errand = self->errands;
    for (const struct record_order *order = self->waiting; errand && order; order = order->next)
        if (order == errand->behind)
            return NULL;
    if (errand)
        self->errands = errand->next;
    return errand;
}

/* After each piece of work. An allocation that libhdf5 was refused can leave it unable to make anything for good, which no call of
 * its own mends (closing it then frees twice): it is tried on a file in memory, and after USELESS_MAX failures in a row, over
 * which memory may have come back, it counts as lost. */
static void look_at_library(struct recorder *self, bool failed)
{
    self->useless = failed && scree_prepare(NULL) ? self->useless + 1 : 0;
    if (self->useless >= USELESS_MAX)
        atomic_store(&self->lost, true);
}

static void *recorder_main(void *argument)
{
    struct recorder *self = argument;
    pthread_setname_np(pthread_self(), "recorder"); // as `top -H` shows it
    for (;;) {
        pthread_mutex_lock(&self->lock);
        while (!self->waiting && !self->errands && !self->stop)
            pthread_cond_wait(&self->work, &self->lock);
        struct errand *errand = next_errand(self);
        struct record_order *order = errand ? NULL : self->waiting;
        if (order)
            self->waiting = order->next;
        pthread_mutex_unlock(&self->lock);
        if (!order && !errand)
            return NULL;
        if (errand)
            errand->status = errand->run(errand->context, errand->err);
        else
            carry_out(order);
        look_at_library(self, errand ? errand->status : order->status);
        pthread_mutex_lock(&self->lock);
        if (errand) {
            errand->done = true;
            pthread_cond_broadcast(&self->errand_done);
        } else {
            append(&self->done, order);
        }
        pthread_mutex_unlock(&self->lock);
        eventfd_write(self->wake_fd, 1);
    }
}

enum scree_status recorder_run(struct recorder *self, enum scree_status (*run)(void *context, struct scree_error *err),
                               void *context, struct scree_error *err)
{
    struct errand errand = {.run = run, .context = context, .err = err};
    struct errand **end = &self->errands;
    pthread_mutex_lock(&self->lock);
    for (errand.behind = self->waiting; errand.behind && errand.behind->next;)
        errand.behind = errand.behind->next;
    while (*end)
        end = &(*end)->next;
    *end = &errand;
    pthread_cond_signal(&self->work);
    while (!errand.done)
        pthread_cond_wait(&self->errand_done, &self->lock);
    pthread_mutex_unlock(&self->lock);
    return errand.status;
}

enum scree_status recorder_start(struct recorder **out, int wake_fd, struct scree_error *err)
{
    struct recorder *recorder = calloc(1, sizeof *recorder);
    if (!recorder)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the recorder");
    recorder->wake_fd = wake_fd;
    pthread_mutex_init(&recorder->lock, NULL);
    pthread_cond_init(&recorder->work, NULL);
    pthread_cond_init(&recorder->errand_done, NULL);
    if (pthread_create(&recorder->thread, NULL, recorder_main, recorder) != 0) {
        free(recorder);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "the system gave no thread for the recorder");
    }
    *out = recorder;
    return SCREE_OK;
}

void recorder_ask(struct recorder *recorder, struct record_order *order)
{
    pthread_mutex_lock(&recorder->lock);
    append(&recorder->waiting, order);
    pthread_cond_signal(&recorder->work);
    pthread_mutex_unlock(&recorder->lock);
}

struct record_order *recorder_take(struct recorder *recorder)
{
    pthread_mutex_lock(&recorder->lock);
    struct record_order *order = recorder->done;
    if (order)
        recorder->done = order->next;
    pthread_mutex_unlock(&recorder->lock);
    return order;
}

void record_order_free(struct record_order *order)
{
    if (order && order->release)
        order->release(order->content);
    if (order) {
        scree_image_free(order->image);
        free(order->journal_text);
        free(order->spec_text);
    }
    free(order);
}

bool recorder_is_lost(const struct recorder *recorder)
{
    return atomic_load(&recorder->lost);
}

void recorder_finish(struct recorder *recorder)
{
    if (!recorder || recorder->stop)
        return;
    pthread_mutex_lock(&recorder->lock);
    recorder->stop = true;
    pthread_cond_signal(&recorder->work);
    pthread_mutex_unlock(&recorder->lock);
    pthread_join(recorder->thread, NULL);
}

void recorder_free(struct recorder *recorder)
{
    if (!recorder)
        return;
    recorder_finish(recorder);
    for (struct record_order *order; (order = recorder_take(recorder));)
        record_order_free(order);
    pthread_cond_destroy(&recorder->errand_done);
    pthread_cond_destroy(&recorder->work);
    pthread_mutex_destroy(&recorder->lock);
    free(recorder);
}
