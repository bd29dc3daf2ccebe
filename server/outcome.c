/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a run has come to, as JSON in the journal, and the words of states: see outcome.h. */
#include "outcome.h"

#include <inttypes.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/frame.h"

static const char *const words[JOB_STATES] = {"queued", "running", "paused", "done", "failed", "cancelled", "held"};

const char *job_state_word(enum job_state state)
{
    return words[state];
}

enum job_state job_state_of(const char *word)
{
    enum job_state state = 0;
    while (state < JOB_STATES && strcmp(words[state], word) != 0)
        state++;
    return state;
}

char *outcome_hash(const struct run_report *r, char out[OUTCOME_HASH_MAX])
{
    snprintf(out, OUTCOME_HASH_MAX, "%016" PRIx64, r->hash);
    return out;
}

void outcome_fill(const char *text, const struct scree_number *numbers, size_t count, char out[OUTCOME_PAPER_MAX])
{
    size_t length = 0;
    while (*text && length + 1 < OUTCOME_PAPER_MAX) {
        size_t name = strcspn(text + 1, "}");
        if (*text != '{' || text[1 + name] != '}') {
            out[length++] = *text++;
            continue;
        }
        char value[32] = "-";
        for (size_t k = 0; k < count; k++)
            if (strlen(numbers[k].name) == name && strncmp(numbers[k].name, text + 1, name) == 0 && isfinite(numbers[k].value))
                snprintf(value, sizeof value, "%.6g", numbers[k].value);
        int wrote = snprintf(out + length, OUTCOME_PAPER_MAX - length, "%s", value);
        length = length + (size_t)wrote < OUTCOME_PAPER_MAX ? length + (size_t)wrote : OUTCOME_PAPER_MAX - 1;
        text += name + 2;
    }
    out[length] = 0;
}

cJSON *outcome_json(const struct run_report *r)
{
    cJSON *json = cJSON_CreateObject(), *numbers = cJSON_CreateArray();
    json_put_text(json, "verdict", scree_verdict_word(r->verdict));
    json_put_text(json, "evidence", r->evidence);
    json_put_int(json, "steps", (long long)r->steps);
    json_put_real(json, "time_s", r->time_s);
    json_put_real(json, "wall_s", r->wall_s);
    json_put_real(json, "rate", r->rate);
    json_put_int(json, "moving", (long long)r->moving);
    json_put_int(json, "fixed", (long long)r->fixed);
    json_put_text(json, "isa", r->isa);
    json_put_int(json, "threads", r->threads);
    for (size_t k = 0; numbers && k < r->number_count; k++) {
        cJSON *n = cJSON_CreateObject();
        json_put_text(n, "name", r->numbers[k].name);
        json_put_text(n, "unit", r->numbers[k].unit);
        json_put_text(n, "doc", r->numbers[k].doc);
        json_put_real(n, "value", r->numbers[k].value);
        cJSON_AddItemToArray(numbers, n);
    }
    json_put(json, "numbers", numbers);
    if (r->hashed) {
        char hash[OUTCOME_HASH_MAX];
        json_put_text(json, "hash", outcome_hash(r, hash));
    }
    if (r->status && r->status != SCREE_CANCELLED && r->status != SCREE_BUSY)
        json_put(json, "error", error_json(scree_status_word(r->status), &r->error));
    return json;
}

/* Names of numbers live as long as the daemon: they are few, and kept once. */
static const char *kept_word(const char *word)
{
    static char *kept[512];
    static size_t count;
    for (size_t k = 0; k < count; k++)
        if (strcmp(kept[k], word) == 0)
            return kept[k];
    if (count == sizeof kept / sizeof *kept || !(kept[count] = strdup(word)))
        return "";
    return kept[count++];
}

void outcome_read(const char *text, struct run_report *r)
{
    cJSON *json = NULL;
    memset(r, 0, sizeof *r);
    if (!*text || json_read(text, strlen(text), "outcome", &json, NULL))
        return;
    const char *verdict = json_text(json, "verdict"), *evidence = json_text(json, "evidence"), *isa = json_text(json, "isa");
    for (enum scree_verdict v = VERDICT_UNDECIDED; v <= VERDICT_ACCELERATING; v++)
        if (verdict && strcmp(verdict, scree_verdict_word(v)) == 0)
            r->verdict = v;
    snprintf(r->evidence, sizeof r->evidence, "%s", evidence ? evidence : "");
    snprintf(r->isa, sizeof r->isa, "%s", isa ? isa : "");
    r->steps = (uint64_t)json_number(json, "steps", 0);
    r->time_s = json_number(json, "time_s", 0);
    r->wall_s = json_number(json, "wall_s", 0);
    r->rate = json_number(json, "rate", 0);
    r->moving = (size_t)json_number(json, "moving", 0);
    r->fixed = (size_t)json_number(json, "fixed", 0);
    r->threads = (int)json_number(json, "threads", 1);
    const char *hash = json_text(json, "hash");
    r->hashed = hash && sscanf(hash, "%" SCNx64, &r->hash) == 1;
    const cJSON *n = NULL, *error = json_get(json, "error");
    cJSON_ArrayForEach(n, json_get(json, "numbers")) if (r->number_count < SCREE_SUMMARY_MAX && json_text(n, "name"))
    {
        const char *unit = json_text(n, "unit"), *doc = json_text(n, "doc");
        r->numbers[r->number_count++] = (struct scree_number){.name = kept_word(json_text(n, "name")),
                                                              .unit = kept_word(unit ? unit : ""),
                                                              .doc = kept_word(doc ? doc : ""),
                                                              .value = json_number(n, "value", 0)};
    }
    if (error)
        r->status = error_read(error, &r->error);
    cJSON_Delete(json);
}
