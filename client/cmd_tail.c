/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree tail`: a stream as it is written, gapless, across restarts of the daemon.
 *
 * The reader knows the number of the next chunk and nothing else. When nothing
 * comes for a while it asks the daemon about the job: if there is something it
 * should have got, or another daemon answers, it opens the stream again from that
 * number. A restarted job may have to write chunks again that were read already;
 * they are the same bits under the same numbers, so the reader waits for its own. */
#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"
#include "follow.h"
#include "output.h"
#include "protocol/frame.h"
#include "reader.h"
#include "signals.h"
#include "spec/field.h"
#include "verbs.h"

enum { QUIET_MS = 2000, GONE_S = 60, DAMAGED_MAX = 5 };

enum format { FORMAT_CSV, FORMAT_NDJSON, FORMAT_RAW };

struct tail {
    const char *job, *stream;
    char endpoint[WIRE_ENDPOINT_MAX];
    enum format format;
    bool follow, header_written;
    bool verify;
    bool hash_known;     // false until a stream that is read from its middle has said its hash
    uint64_t hash;       // of the stream up to `next`
    uint64_t next, stop; // stop: the first chunk that --no-follow leaves out
    struct link *link;   // NULL while the daemon is gone
    struct reader *reader;
    double pid;  // of the daemon that `reader` reads from
    double gone; // since when it does not answer; 0: it does
    int damaged; // chunks that did not arrive whole, in a row
};

/* ---- writing ---- */

/* Fifteen digits where they are enough, else seventeen: always the same bits, and
 * fast enough for a stream, which the search for the shortest text is not. */
static const char *number(double value, char text[TEXT_REAL_MAX])
{
    snprintf(text, TEXT_REAL_MAX, "%.15g", value);
    if (strtod(text, NULL) != value)
        snprintf(text, TEXT_REAL_MAX, "%.17g", value);
    return text;
}

static void write_csv(struct tail *t, const struct reader_chunk *chunk)
{
    char text[TEXT_REAL_MAX];
    if (!t->header_written) {
        fputs("t (s)", stdout);
        for (int c = 0; c < (int)chunk->columns; c++) {
            const char *name = cJSON_GetStringValue(cJSON_GetArrayItem(chunk->column_names, c));
            const char *unit = cJSON_GetStringValue(cJSON_GetArrayItem(chunk->units, c));
            putchar(',');
            put_clean(stdout, name ? name : "?");
            if (unit && *unit) {
                fputs(" (", stdout);
                put_clean(stdout, unit);
                putchar(')');
            }
        }
        putchar('\n');
        t->header_written = true;
    }
    for (size_t r = 0; r < chunk->rows; r++) {
        fputs(number(chunk->t0_s + (double)r * chunk->dt_s, text), stdout);
        for (size_t c = 0; c < chunk->columns; c++) {
            putchar(',');
            fputs(number(chunk->values[r * chunk->columns + c], text), stdout);
        }
        putchar('\n');
    }
}

static void put_words(const char *key, const cJSON *words)
{
    char *text = words ? json_print(words, false) : NULL;
    printf(",\"%s\":%s", key, text ? text : "[]");
    free(text);
}

/* A chunk a line: one object with the rows as arrays, what is not finite as null. */
static void write_ndjson(const struct tail *t, const struct reader_chunk *chunk)
{
    char text[TEXT_REAL_MAX];
    printf("{\"job\":\"%s\",\"stream\":\"%s\",\"seq\":%llu,\"t0_s\":%s", t->job, t->stream, (unsigned long long)chunk->seq,
           number(chunk->t0_s, text));
    printf(",\"dt_s\":%s,\"n\":%zu", number(chunk->dt_s, text), chunk->rows);
    put_words("columns", chunk->column_names);
    put_words("units", chunk->units);
    fputs(",\"rows\":[", stdout);
    for (size_t r = 0; r < chunk->rows; r++) {
        fputs(r ? ",[" : "[", stdout);
        for (size_t c = 0; c < chunk->columns; c++) {
            double value = chunk->values[r * chunk->columns + c];
            fputs(c ? "," : "", stdout);
            fputs(isfinite(value) ? number(value, text) : "null", stdout);
        }
        putchar(']');
    }
    fputs("]}\n", stdout);
}

/* False when stdout takes no more. */
static bool write_chunk(struct tail *t, const struct reader_chunk *chunk)
{
    if (t->format == FORMAT_CSV)
        write_csv(t, chunk);
    else if (t->format == FORMAT_NDJSON)
        write_ndjson(t, chunk);
    else
        fwrite(chunk->values, sizeof(double), chunk->rows * chunk->columns, stdout);
    return fflush(stdout) == 0;
}

/* ---- the connection ---- */

static void disconnect(struct tail *t)
{
    reader_close(t->reader);
    t->reader = NULL;
    link_close(t->link);
    t->link = NULL;
}

/* Notes that nobody answers; OUTCOME_DONE while it is worth trying again. */
static enum outcome bear_silence(struct tail *t, enum outcome outcome)
{
    if (outcome != OUTCOME_UNREACHABLE)
        return outcome;
    disconnect(t);
    if (t->gone == 0) {
        t->gone = now_s();
        say("the daemon is gone; waiting for it (at most %d s), chunk %llu is next", GONE_S, (unsigned long long)t->next);
    }
    if (now_s() - t->gone > GONE_S)
        return outcome;
    wait_ms(500);
    return OUTCOME_DONE;
}

/* A job that records at all lists its streams: refuses one that is not among them. */
static enum outcome check_stream(const struct tail *t, const cJSON *streams, struct scree_error *err)
{
    const char *names[65];
    const cJSON *stream;
    int count = 0;
    if (json_get(streams, t->stream) || cJSON_GetArraySize(streams) == 0)
        return OUTCOME_DONE;
    cJSON_ArrayForEach(stream, streams) if (count < 64) names[count++] = stream->string;
    names[count] = NULL;
    const char *near = word_nearest(names, t->stream);
    outcome_fail(err, OUTCOME_REFUSED, "%s has no stream \"%.60s\"%s%s%s", t->job, t->stream, near ? "; did you mean \"" : "",
                 near ? near : "", near ? "\"?" : "");
    scree_hint(err, "`scree show %s` lists its streams", t->job);
    return OUTCOME_REFUSED;
}

/* How many chunks the daemon has; whether the job has ended. */
static enum outcome look(struct tail *t, double *chunks, bool *ended, struct scree_error *err)
{
    cJSON *record = NULL;
    enum outcome outcome = link_job(t->link, "show", t->job, &record, err);
    if (!outcome && !(outcome = check_stream(t, json_get(record, "streams"), err))) {
        *chunks = json_number(json_get(json_get(record, "streams"), t->stream), "chunks", 0);
        *ended = state_ended(json_text(record, "state"));
    }
    cJSON_Delete(record);
    return outcome;
}

/* After a silence: leaves the reader alone if all is well, closes it if it missed something. */
static enum outcome examine(struct tail *t, struct scree_error *err)
{
    double chunks = 0, pid;
    bool ended = false;
    cJSON *pong = NULL;
    enum outcome outcome = link_ping(t->link, LINK_SILENCE_S, &pong, err);
    pid = json_number(pong, "pid", 0);
    cJSON_Delete(pong);
    if (outcome || (outcome = look(t, &chunks, &ended, err)))
        return outcome;
    if (t->reader && (pid != t->pid || (double)t->next < chunks || ended)) {
        reader_close(t->reader);
        t->reader = NULL;
    }
    return OUTCOME_DONE;
}

/* Opens link and reader where they are missing. A reader is opened only once the
 * log has reached its position again. */
static enum outcome connect(struct tail *t, struct scree_error *err)
{
    double chunks = 0;
    bool ended = false;
    cJSON *pong = NULL;
    enum outcome outcome = t->link ? OUTCOME_DONE : link_open(t->endpoint, &t->link, err);
    if (outcome || (outcome = link_ping(t->link, LINK_SILENCE_S, &pong, err)))
        return outcome;
    t->pid = json_number(pong, "pid", 0);
    cJSON_Delete(pong);
    if ((outcome = look(t, &chunks, &ended, err)))
        return outcome;
    if (t->gone > 0)
        say("the daemon is back; going on with chunk %llu", (unsigned long long)t->next);
    t->gone = 0;
    if (!ended && (double)t->next > chunks) {
        wait_ms(500);
        return OUTCOME_DONE;
    }
    return reader_open(t->link, t->job, t->stream, t->next, READER_MANY, &t->reader, err);
}

/* ---- verifying ---- */

/* The running hash says that this chunk follows the one before, and both are what
 * was once written; the checksum has been looked at when the chunk came in. */
static enum outcome verify(struct tail *t, const struct reader_chunk *chunk, struct scree_error *err)
{
    uint64_t said = 0;
    if (!chunk->hash || sscanf(chunk->hash, "%" SCNx64, &said) != 1)
        return outcome_fail(err, OUTCOME_FAILED, "chunk %llu comes without a running hash", (unsigned long long)chunk->seq);
    uint64_t own = chunk_hash(t->hash, chunk->seq, chunk->t0_s, chunk->dt_s, chunk->rows, chunk->values,
                              chunk->rows * chunk->columns * sizeof(double));
    if (t->hash_known && own != said)
        return outcome_fail(err, OUTCOME_FAILED, "chunk %llu of %s: the running hash should be %016" PRIx64 " and is %.16s",
                            (unsigned long long)chunk->seq, t->stream, own, chunk->hash);
    t->hash = said;
    t->hash_known = true;
    return OUTCOME_DONE;
}

/* ---- following ---- */

enum step { STEP_ON, STEP_OVER };

/* Takes what comes next from the reader. */
static enum outcome take(struct tail *t, int *quiet_ms, enum step *step, struct scree_error *err)
{
    struct reader_chunk chunk;
    switch (reader_next(t->reader, WAIT_SLICE_MS, &chunk, err)) {
    case READER_CHUNK:
        *quiet_ms = 0;
        t->damaged = 0;
        t->next = chunk.seq + 1;
        if (t->verify && verify(t, &chunk, err))
            return OUTCOME_FAILED;
        if (!write_chunk(t, &chunk) || (!t->follow && t->next >= t->stop))
            *step = STEP_OVER;
        return OUTCOME_DONE;
    case READER_QUIET:
        *quiet_ms += WAIT_SLICE_MS;
        return OUTCOME_DONE;
    case READER_END:
        *step = STEP_OVER;
        return OUTCOME_DONE;
    case READER_ERROR:
        return outcome_of_status(err->status);
    case READER_DAMAGED:
        break;
    }
    if (++t->damaged > DAMAGED_MAX)
        return OUTCOME_FAILED;
    reader_close(t->reader);
    t->reader = NULL;
    return OUTCOME_DONE;
}

static enum outcome follow_stream(struct tail *t, struct scree_error *err)
{
    int quiet_ms = 0;
    enum step step = STEP_ON;
    enum outcome outcome = OUTCOME_DONE;
    while (step == STEP_ON && !outcome) {
        if (!t->reader)
            outcome = bear_silence(t, connect(t, err));
        else if (quiet_ms >= QUIET_MS)
            outcome = bear_silence(t, examine(t, err));
        else {
            outcome = take(t, &quiet_ms, &step, err);
            continue;
        }
        quiet_ms = 0;
    }
    return outcome;
}

static enum outcome read_format(const struct arguments *arguments, enum format *out, struct scree_error *err)
{
    static const char *const words[] = {"csv", "ndjson", "raw", NULL};
    const char *format = arguments_value(arguments, "--format");
    *out = arguments->json ? FORMAT_NDJSON : FORMAT_CSV;
    for (int k = 0; format && words[k]; k++)
        if (strcmp(format, words[k]) == 0) {
            *out = (enum format)k;
            return OUTCOME_DONE;
        }
    return format ? outcome_fail(err, OUTCOME_REFUSED, "--format: \"%.40s\" is none of csv, ndjson, raw", format) : OUTCOME_DONE;
}

static enum outcome tail_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct tail t = {
        .job = arguments->words[0], .stream = arguments->words[1], .follow = !arguments_flag(arguments, "--no-follow")};
    double chunks = 0;
    long long from;
    bool ended = false, chosen;
    enum outcome outcome = read_format(arguments, &t.format, &err);
    if (outcome || (outcome = arguments_integer(arguments, "--from", 0, 1ll << 52, 0, &from, &err)) ||
        (outcome = link_endpoint(arguments->connect, t.endpoint, &chosen, &err)) ||
        (outcome = link_open(t.endpoint, &t.link, &err)) || (outcome = look(&t, &chunks, &ended, &err)))
        goto out;
    t.next = (uint64_t)from;
    t.verify = arguments_flag(arguments, "--verify");
    t.hash_known = from == 0;
    t.stop = (uint64_t)chunks;
    if ((t.follow || t.next < t.stop || ended))
        outcome = follow_stream(&t, &err);
    if (!outcome && t.verify)
        say("%s of %s: chunks %lld..%lld verified, running hash %016" PRIx64, t.stream, t.job, from, (long long)t.next - 1, t.hash);
out:
    disconnect(&t);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--from=", "--format=", "--no-follow", "--verify", NULL};

const struct verb verb_tail = {
    .name = "tail",
    .synopsis = "ID STREAM [--from SEQ] [--format csv|ndjson|raw] [--no-follow] [--verify]",
    .doc = "a stream of a job, from its first chunk or SEQ, live to its end",
    .help = "csv (the default) starts with a line of names and units; ndjson (--json) is one chunk a line with its\n"
            "number \"seq\"; raw is the little-endian doubles alone, row by row. Row k of a chunk is at t0_s + k dt_s.\n"
            "--verify also follows the running hash from chunk to chunk (checksums are always looked at) and says what it\n"
            "came to; exit code 1 at the first chunk that does not fit.\n"
            "--no-follow ends with what there is now. Ends with 0 when the stream does, however the job ended.\n"
            "A daemon that is gone is waited for, 60 s at most (exit code 69), and the stream goes on without gap or\n"
            "repetition.\n"
            "\n"
            "  scree tail j17 basal_force | head\n"
            "  scree tail j17 basal_force --from 100 --format raw > force.f8\n",
    .options = options,
    .words_min = 2,
    .words_max = 2,
    .run = tail_run,
};
