/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See recorder.h. */
#include "recorder.h"

#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>

struct recorder {
    pthread_t thread;
    pthread_mutex_t lock;
    pthread_cond_t work;
    bool stop;
    int wake_fd;
    struct record_order *waiting, *done; // oldest first
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

static void carry_out(struct record_order *order)
{
    struct reader reader = {.order = order};
    if (order->write) {
        order->status = order->write(order, &order->error);
        return;
    }
    const struct scree_source source = {.next = next_chunk, .context = &reader};
    const struct scree_result result = {.path = order->path,
                                        .spec_json = order->spec_text,
                                        .journal_json = "[]",
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
}

static void *recorder_main(void *argument)
{
    struct recorder *self = argument;
    for (;;) {
        pthread_mutex_lock(&self->lock);
        while (!self->waiting && !self->stop)
            pthread_cond_wait(&self->work, &self->lock);
        struct record_order *order = self->waiting;
        if (order)
            self->waiting = order->next;
        pthread_mutex_unlock(&self->lock);
        if (!order)
            return NULL;
        carry_out(order);
        pthread_mutex_lock(&self->lock);
        append(&self->done, order);
        pthread_mutex_unlock(&self->lock);
        eventfd_write(self->wake_fd, 1);
    }
}

enum scree_status recorder_start(struct recorder **out, int wake_fd, struct scree_error *err)
{
    struct recorder *recorder = calloc(1, sizeof *recorder);
    if (!recorder)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the recorder");
    recorder->wake_fd = wake_fd;
    pthread_mutex_init(&recorder->lock, NULL);
    pthread_cond_init(&recorder->work, NULL);
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
    if (order)
        free(order->spec_text);
    free(order);
}

void recorder_stop(struct recorder *recorder)
{
    if (!recorder)
        return;
    pthread_mutex_lock(&recorder->lock);
    recorder->stop = true;
    pthread_cond_signal(&recorder->work);
    pthread_mutex_unlock(&recorder->lock);
    pthread_join(recorder->thread, NULL);
    for (struct record_order *order; (order = recorder_take(recorder));)
        record_order_free(order);
    pthread_cond_destroy(&recorder->work);
    pthread_mutex_destroy(&recorder->lock);
    free(recorder);
}
