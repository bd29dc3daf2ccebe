/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See follow.h.
 *
 * `show` is the truth and is asked a few times a second; the basal force comes
 * along its stream, whose chunks are averaged for the sparkline as they arrive.
 * A job without that stream is followed just the same. */
#include "follow.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

#include "output.h"
#include "progress.h"
#include "reader.h"
#include "signals.h"

#define STREAM "basal_force"
/* A late watcher starts that many chunks before the head: enough for a first spark. */
enum { LATE_CHUNKS = 16, FIRST_POLL_MS = 40, POLL_MS = 250 };

struct following {
    struct link *link;
    struct daemon *own;
    const char *job;
    struct progress progress;
    struct reader *reader;
    bool reader_done; // ended, refused or not recorded
    bool cancelled;   // by us
    double gone;      // since when the daemon does not answer; 0: it does
    bool held_told;
};

bool state_ended(const char *state)
{
    return state && (strcmp(state, "done") == 0 || strcmp(state, "failed") == 0 || strcmp(state, "cancelled") == 0);
}

bool is_study_id(const char *id)
{
    return id[0] == 's' && id[1] >= '0' && id[1] <= '9';
}

enum outcome ask_record(struct link *link, const char *id, bool all, cJSON **record, struct scree_error *err)
{
    if (all || !is_study_id(id))
        return link_job(link, "show", id, record, err);
    cJSON *body = cJSON_CreateObject();
    if (body) {
        json_put_text(body, "job", id);
        json_put_bool(body, "open", true);
    }
    return link_request(link, "show", body, record, err);
}

/* The column of the normal force: "Fz" by name. */
static int normal_column(const struct reader_chunk *chunk)
{
    for (int c = 0; c < (int)chunk->columns; c++) {
        const char *name = cJSON_GetStringValue(cJSON_GetArrayItem(chunk->column_names, c));
        if (name && (strcmp(name, "Fz") == 0 || strcmp(name, "force_z") == 0))
            return c;
    }
    return -1;
}

static void take_force(struct progress *progress, const struct reader_chunk *chunk)
{
    int column = normal_column(chunk);
    double sum = 0;
    if (column < 0 || chunk->rows == 0)
        return;
    for (size_t r = 0; r < chunk->rows; r++)
        sum += chunk->values[r * chunk->columns + (size_t)column];
    progress_force(progress, sum / (double)chunk->rows, (double)chunk->rows);
}

/* Opens the force's stream near its head, once the record shows that there is one. */
static void open_reader(struct following *f, const cJSON *record)
{
    const cJSON *stream = json_get(json_get(record, "streams"), STREAM);
    struct scree_error ignored;
    if (f->reader || f->reader_done || !cJSON_IsObject(stream))
        return;
    double chunks = json_number(stream, "chunks", 0);
    uint64_t from = chunks > LATE_CHUNKS ? (uint64_t)chunks - LATE_CHUNKS : 0;
    if (reader_open(f->link, f->job, STREAM, from, READER_MANY, &f->reader, &ignored))
        f->reader_done = true; // a picture less; the job is what counts
}

static void close_reader(struct following *f)
{
    reader_close(f->reader);
    f->reader = NULL;
}

/* Spends `milliseconds`, on the stream if there is one. */
static void listen_for(struct following *f, int milliseconds)
{
    struct reader_chunk chunk;
    struct scree_error ignored;
    int interrupts = signals_count();
    for (double end = now_s() + milliseconds / 1000.0, now = now_s(); now < end && signals_count() == interrupts; now = now_s()) {
        int left = (int)ceil(1000 * (end - now));
        if (!f->reader) {
            wait_ms(left);
            continue;
        }
        switch (reader_next(f->reader, left < WAIT_SLICE_MS ? left : WAIT_SLICE_MS, &chunk, &ignored)) {
        case READER_CHUNK:
            take_force(&f->progress, &chunk);
            break;
        case READER_QUIET:
            break;
        case READER_END:
        case READER_ERROR:
        case READER_DAMAGED:
            f->reader_done = true;
            close_reader(f);
            break;
        }
    }
}

/* The daemon did not answer: wait for it for a while, unless it was our own and has died. */
static enum outcome bear_silence(struct following *f, enum outcome outcome, struct scree_error *err)
{
    char last[SCREE_MESSAGE_MAX - 64];
    if (outcome != OUTCOME_UNREACHABLE)
        return outcome;
    if (f->own && !daemon_alive(f->own)) {
        daemon_last_words(f->own, last, sizeof last);
        return outcome_fail(err, OUTCOME_UNREACHABLE, "the private daemon is gone%s%s", *last ? "; it said last: " : "", last);
    }
    if (f->gone == 0) {
        f->gone = now_s();
        say("the daemon is gone; waiting for it (at most %d s)", FOLLOW_PATIENCE_S);
    }
    if (now_s() - f->gone > FOLLOW_PATIENCE_S)
        return outcome;
    close_reader(f);
    f->reader_done = false;
    wait_ms(500);
    return OUTCOME_DONE;
}

static void look_at(struct following *f, const cJSON *record)
{
    const char *state = json_text(record, "state"), *why = json_text(record, "why");
    if (f->gone > 0)
        say("the daemon is back");
    f->gone = 0;
    if (state && strcmp(state, "held") == 0 && !f->held_told) {
        f->held_told = true;
        say("%s is held: %s", f->job, why && *why ? why : "the daemon does not say why");
    }
    if (is_study_id(f->job)) {
        if (!state_ended(state))
            progress_show_study(&f->progress, record);
        return;
    }
    open_reader(f, record);
    if (!state_ended(state))
        progress_show(&f->progress, record);
}

/* What Ctrl-C does; true when following ends with it. */
static bool interrupted(struct following *f, enum outcome *outcome, struct scree_error *err)
{
    cJSON *result = NULL;
    struct scree_error refused;
    if (signals_count() == 0)
        return false;
    if (!f->own)
        return true;
    if (signals_count() >= 2) {
        *outcome = outcome_fail(err, OUTCOME_CANCELLED, "interrupted again: leaving at once, without the result");
        return true;
    }
    if (f->cancelled)
        return false;
    say("cancelling %s; its result so far will be kept (Ctrl-C again leaves at once)", f->job);
    if (link_job(f->link, "cancel", f->job, &result, &refused))
        say_error(&refused);
    cJSON_Delete(result);
    f->cancelled = true;
    return false;
}

enum follow_end follow_job(struct link *link, struct daemon *own, const char *job, cJSON **record, enum outcome *outcome,
                           struct scree_error *err)
{
    struct following f = {.link = link, .own = own, .job = job};
    enum follow_end end = FOLLOW_ENDED;
    int pause = FIRST_POLL_MS;
    *record = NULL;
    *outcome = OUTCOME_DONE;
    progress_start(&f.progress);
    for (;;) {
        if (interrupted(&f, outcome, err)) {
            end = *outcome ? FOLLOW_FAILED : FOLLOW_DETACHED;
            break;
        }
        cJSON *now = NULL;
        if ((*outcome = ask_record(link, job, false, &now, err))) {
            if ((*outcome = bear_silence(&f, *outcome, err)) == OUTCOME_DONE)
                continue;
            end = FOLLOW_FAILED;
            break;
        }
        look_at(&f, now);
        if (state_ended(json_text(now, "state"))) {
            *record = now;
            if (!is_study_id(job) || ask_record(link, job, true, &now, err))
                break;
            cJSON_Delete(*record); // of a study all trials are wanted in the end
            *record = now;
            break;
        }
        cJSON_Delete(now);
        listen_for(&f, pause);
        pause = pause * 3 / 2 < POLL_MS ? pause * 3 / 2 : POLL_MS;
    }
    close_reader(&f);
    progress_erase();
    return end;
}
