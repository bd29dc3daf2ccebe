/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See download.h. */
#include "download.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "output.h"
#include "protocol/frame.h"
#include "signals.h"

enum { PIECE_BYTES = 512 << 10 };

/* What is copied and where to. */
struct wanted {
    const char *job, *file;
    const char *format; // of a study's table, NULL for a job's result
};

static enum outcome write_all(int fd, const unsigned char *data, size_t size, const char *file, struct scree_error *err)
{
    while (size > 0) {
        ssize_t written = write(fd, data, size);
        if (written < 0 && errno == EINTR)
            continue;
        if (written <= 0)
            return outcome_fail(err, OUTCOME_FAILED, "cannot write %s: %s", file, strerror(errno));
        data += written;
        size -= (size_t)written;
    }
    return OUTCOME_DONE;
}

/* One piece from `offset`; *got is how many bytes it had. */
static enum outcome take_piece(struct link *link, const struct wanted *w, double offset, double total, int fd, size_t *got,
                               bool *changed, struct scree_error *err)
{
    const char *job = w->job, *file = w->file;
    cJSON *body = cJSON_CreateObject(), *piece = NULL;
    unsigned char *data = NULL;
    enum outcome outcome = OUTCOME_DONE;
    if (body) {
        json_put_text(body, "job", job);
        json_put_real(body, "offset", offset);
        json_put_int(body, "bytes", PIECE_BYTES);
        if (w->format)
            json_put_text(body, "format", w->format);
    }
    if ((outcome = link_request(link, "fetch_part", body, &piece, err)))
        goto out;
    const char *text = json_text(piece, "data");
    size_t length = text ? strlen(text) : 0;
    if (!(data = malloc(length / 4 * 3 + 3))) {
        outcome = outcome_fail(err, OUTCOME_FAILED, "no memory to fetch the result");
        goto out;
    }
    *got = text ? base64_decode(text, length, data) : SIZE_MAX;
    if (*got == 0 || *got > PIECE_BYTES || json_number(piece, "total", -1) != total || offset + (double)*got > total) {
        *changed = true;
        outcome = outcome_fail(err, OUTCOME_FAILED, "the result of %s changed while it was fetched", job);
        goto out;
    }
    outcome = write_all(fd, data, *got, file, err);
out:
    free(data);
    cJSON_Delete(piece);
    return outcome;
}

static enum outcome take_pieces(struct link *link, const struct wanted *w, double total, int fd, bool *changed,
                                struct scree_error *err)
{
    int interrupts = signals_count();
    double told = now_s();
    for (double offset = 0; offset < total;) {
        size_t got = 0;
        enum outcome outcome = take_piece(link, w, offset, total, fd, &got, changed, err);
        if (outcome)
            return outcome;
        if (signals_count() > interrupts)
            return outcome_fail(err, OUTCOME_CANCELLED, "interrupted; %s was not written", w->file);
        offset += (double)got;
        if (now_s() - told > 5) {
            char have[TEXT_MAX], all[TEXT_MAX];
            told = now_s();
            say("fetched %s of %s", text_bytes(offset, have), text_bytes(total, all));
        }
    }
    return OUTCOME_DONE;
}

/* One attempt; *changed says that the file was made anew meanwhile, as happens when the job ends. */
static enum outcome attempt(struct link *link, const struct wanted *w, const char *part, bool *changed, struct download *out,
                            struct scree_error *err)
{
    const char *job = w->job, *file = w->file;
    cJSON *body = cJSON_CreateObject(), *made = NULL;
    *changed = false;
    if (body) {
        json_put_text(body, "job", job);
        if (w->format)
            json_put_text(body, "format", w->format);
    }
    enum outcome outcome = link_request_slow(link, "fetch", true, body, &made, err);
    if (outcome)
        return outcome;
    *out = (struct download){.bytes = json_number(made, "bytes", 0), .complete = json_bool(made, "complete", false)};
    cJSON_Delete(made);
    if (!(out->bytes > 0))
        return outcome_fail(err, OUTCOME_FAILED, "the daemon has no result of %s", job);
    int fd = open(part, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
    if (fd < 0)
        return outcome_fail(err, OUTCOME_REFUSED, "cannot write %s: %s", part, strerror(errno));
    outcome = take_pieces(link, w, out->bytes, fd, changed, err);
    if (!outcome && fsync(fd) != 0)
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot write %s: %s", file, strerror(errno));
    if (close(fd) != 0 && !outcome)
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot write %s: %s", file, strerror(errno));
    if (!outcome && rename(part, file) != 0)
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot write %s: %s", file, strerror(errno));
    if (outcome)
        unlink(part);
    return outcome;
}

static enum outcome download(struct link *link, const struct wanted *w, struct download *out, struct scree_error *err)
{
    char part[PATH_MAX];
    bool changed = true;
    enum outcome outcome = OUTCOME_DONE;
    if (snprintf(part, sizeof part, "%s.part-%ld", w->file, (long)getpid()) >= (int)sizeof part)
        return outcome_fail(err, OUTCOME_REFUSED, "the path of the result is too long");
    for (int k = 0; k < 3 && changed; k++)
        outcome = attempt(link, w, part, &changed, out, err);
    return outcome;
}

enum outcome download_result(struct link *link, const char *job, const char *file, struct download *out, struct scree_error *err)
{
    return download(link, &(struct wanted){.job = job, .file = file}, out, err);
}

enum outcome download_study(struct link *link, const char *study, const char *file, char text_file[PATH_MAX], struct download *out,
                            struct scree_error *err)
{
    struct download text;
    size_t stem = strlen(file) - strlen(".h5");
    if (stem + sizeof ".csv" > PATH_MAX)
        return outcome_fail(err, OUTCOME_REFUSED, "the path of the result is too long");
    snprintf(text_file, PATH_MAX, "%.*s.csv", (int)stem, file);
    enum outcome outcome = download(link, &(struct wanted){.job = study, .file = file, .format = "h5"}, out, err);
    return outcome ? outcome : download(link, &(struct wanted){.job = study, .file = text_file, .format = "csv"}, &text, err);
}
