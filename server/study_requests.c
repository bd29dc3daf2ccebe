/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See study_requests.h. Files of a study are made when they are asked for, out of
 * what the journal knows: they are small, and always up to date. */
#include "study_requests.h"

#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#include "io/files.h"
#include "io/table.h"
#include "limits.h"
#include "meshes.h"
#include "study_view.h"

enum { PART_MAX = 512 << 10, FILE_PATH_MAX = CONFIG_PATH_MAX + 64 };

bool study_request_is(const char *op, const cJSON *body)
{
    const char *id = json_text(body, "job");
    if (strcmp(op, "submit") == 0 || strcmp(op, "check") == 0)
        return study_is(json_get(body, "spec"));
    return id && id[0] == 's' && id[1] >= '0' && id[1] <= '9';
}

static enum scree_status find_study(struct daemon *daemon, const cJSON *body, struct study **out, struct scree_error *err)
{
    const char *id = json_text(body, "job");
    *out = studies_find(daemon->studies, id);
    if (*out)
        return SCREE_OK;
    scree_fail(err, SCREE_NOT_FOUND, "job", "there is no study \"%.32s\"", id ? id : "");
    scree_hint(err, "`scree list` shows the studies there are");
    return SCREE_NOT_FOUND;
}

/* ---- files ---- */

enum format { FORMAT_H5, FORMAT_CSV };
static const char *const formats[] = {"h5", "csv", NULL};

static enum scree_status read_format(const cJSON *body, enum format *format, struct scree_error *err)
{
    const char *word = json_text(body, "format");
    *format = FORMAT_H5;
    if (!json_get(body, "format"))
        return SCREE_OK;
    for (int k = 0; word && formats[k]; k++)
        if (strcmp(formats[k], word) == 0) {
            *format = (enum format)k;
            return SCREE_OK;
        }
    return scree_fail(err, SCREE_INVALID, "format", "format: \"h5\" or \"csv\" is expected");
}

static enum scree_status file_path(const struct daemon *daemon, const struct study *study, enum format format, char *out,
                                   struct scree_error *err)
{
    snprintf(out, FILE_PATH_MAX, "%s/studies", daemon->config->data);
    if (mkdir(out, 0700) != 0 && errno != EEXIST)
        return scree_fail(err, SCREE_IO, "", "cannot make %s: %s", out, strerror(errno));
    snprintf(out, FILE_PATH_MAX, "%s/studies/%s.%s", daemon->config->data, study->id, formats[format]);
    return SCREE_OK;
}

static cJSON *fetched(const char *id, const char *path, bool complete)
{
    struct stat info;
    cJSON *json = cJSON_CreateObject();
    json_put_text(json, "job", id);
    json_put_text(json, "path", path);
    json_put_int(json, "bytes", stat(path, &info) == 0 ? (long long)info.st_size : 0);
    json_put_bool(json, "complete", complete);
    return json;
}

static enum scree_status write_csv(const struct study *study, const char *path, struct scree_error *err)
{
    char part[FILE_PATH_MAX + 8];
    cJSON *table = study_table(study);
    char *text = table ? study_csv(table) : NULL;
    enum scree_status status;
    snprintf(part, sizeof part, "%s.part", path);
    if (!text)
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the table of %s", study->id);
    else
        status = files_put(part, path, text, strlen(text), err);
    free(text);
    cJSON_Delete(table);
    return status;
}

/* A column of the table as HDF5 takes it: numbers, unless one of its cells is a word. */
static enum scree_status make_column(const cJSON *table, int index, size_t rows, struct io_column *out, struct scree_error *err)
{
    const cJSON *head = cJSON_GetArrayItem(json_get(table, "columns"), index), *row;
    bool words = false;
    cJSON_ArrayForEach(row, json_get(table, "rows"))
    {
        const cJSON *cell = cJSON_GetArrayItem(row, index);
        words |= !cJSON_IsNull(cell) && !cJSON_IsNumber(cell) && !cJSON_IsRaw(cell);
    }
    double *values = words ? NULL : calloc(rows + 1, sizeof *values);
    const char **texts = words ? calloc(rows + 1, sizeof *texts) : NULL;
    *out = (struct io_column){.name = json_text(head, "name"), .unit = json_text(head, "unit"), .values = values, .words = texts};
    if (!values && !texts)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a column");
    size_t k = 0;
    cJSON_ArrayForEach(row, json_get(table, "rows"))
    {
        const cJSON *cell = cJSON_GetArrayItem(row, index);
        if (values)
            values[k] = cJSON_IsNumber(cell) ? cell->valuedouble : cJSON_IsRaw(cell) ? strtod(cell->valuestring, NULL) : NAN;
        else
            texts[k] = cJSON_IsString(cell) ? cell->valuestring : cJSON_IsTrue(cell) ? "true" : cJSON_IsFalse(cell) ? "false" : "";
        k++;
    }
    return SCREE_OK;
}

/* On the recorder's thread: everything it needs is in the order's content. */
static enum scree_status write_h5(const struct record_order *order, struct scree_error *err)
{
    const cJSON *content = order->content, *table = json_get(content, "table");
    size_t count = (size_t)cJSON_GetArraySize(json_get(table, "columns")),
           rows = (size_t)cJSON_GetArraySize(json_get(table, "rows"));
    struct io_column *columns = calloc(count + 1, sizeof *columns);
    enum scree_status status = columns ? SCREE_OK : scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the table");
    for (size_t k = 0; k < count && !status; k++)
        status = make_column(table, (int)k, rows, &columns[k], err);
    if (!status) {
        const struct io_table file = {.path = order->path,
                                      .id = order->id,
                                      .kind = json_text(content, "kind"),
                                      .title = json_text(content, "title"),
                                      .state = order->state,
                                      .conclusion = json_text(content, "conclusion"),
                                      .build = json_text(content, "build"),
                                      .spec_json = order->spec_text,
                                      .columns = columns,
                                      .column_count = count,
                                      .rows = rows};
        status = io_table_write(&file, err);
    }
    for (size_t k = 0; k < count && columns; k++) {
        free((void *)(uintptr_t)columns[k].values);
        free((void *)(uintptr_t)columns[k].words);
    }
    free(columns);
    return status;
}

static void release_content(void *content)
{
    cJSON_Delete(content);
}

/* Orders the HDF5 file; the reply comes with the ticket. */
static enum scree_status order_h5(struct daemon *daemon, const struct study *study, const char *path, struct scree_error *err)
{
    struct record_order *order = calloc(1, sizeof *order);
    cJSON *content = order ? study_summary(study) : NULL;
    if (!content || !(order->spec_text = strdup(study->spec_text))) {
        cJSON_Delete(content);
        record_order_free(order);
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the table of %s", study->id);
    }
    json_put_text(content, "build", *study->build ? study->build : scree_build());
    json_put(content, "table", study_table(study));
    order->write = write_h5;
    order->release = release_content;
    order->content = content;
    order->ticket = daemon->tickets;
    order->final = job_state_ended(study->state);
    snprintf(order->id, sizeof order->id, "%s", study->id);
    snprintf(order->state, sizeof order->state, "%s", job_state_word(study->state));
    snprintf(order->path, sizeof order->path, "%s", path);
    scheduler_record(daemon->scheduler, order);
    return SCREE_OK;
}

cJSON *study_recorded_reply(const char *request, const struct record_order *order)
{
    if (order->status)
        return reply_error(request, scree_status_word(order->status), &order->error);
    return reply_ok(request, fetched(order->id, order->path, order->final));
}

/* ---- operations ---- */

static enum scree_status do_check(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    struct study_plan plan;
    struct job_cost cost;
    enum scree_status status = study_decode(json_get(body, "spec"), &plan, err);
    if (!status && !(status = study_plan_check(&plan, requests_memory(), meshes_check_job, daemon->config, &cost, err))) {
        *result = cJSON_CreateObject();
        json_put(*result, "spec", study_encode(&plan));
        json_put(*result, "cost", job_cost_encode(&cost));
        json_put(*result, "trials", plan.trials ? json_real((double)plan.trials) : cJSON_CreateNull());
    }
    study_plan_free(&plan);
    return status;
}

/* Studies of a user from the network that have not ended, 0 if `request` is one of them: each brings at most at_once jobs with it.
 */
static size_t studies_of(const struct daemon *daemon, const struct user *user, const char *request)
{
    size_t count = 0, length = strlen(user->name);
    for (size_t k = 0; k < studies_count(daemon->studies); k++) {
        const struct study *study = studies_at(daemon->studies, k);
        if (strcmp(study->request, request) == 0)
            return 0; // the same submit once more
        count +=
            !job_state_ended(study->state) && strncmp(study->request, user->name, length) == 0 && study->request[length] == '/';
    }
    return count;
}

static enum scree_status do_submit(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                   struct scree_error *err)
{
    struct study *study;
    bool reused;
    char request[LIMITS_REQUEST_MAX];
    limits_request(&daemon->user, id, request);
    enum scree_status status =
        limits_check(&daemon->user, studies_of(daemon, &daemon->user, request), daemon->config->max_jobs, "studies under way", err);
    if (status)
        return status;
    status =
        studies_submit(daemon->studies, request, json_get(body, "spec"), json_bool(body, "again", false), &study, &reused, err);
    if (status)
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "job", study->id);
    json_put_text(*result, "state", job_state_word(study->state));
    json_put_bool(*result, "reused", reused);
    return SCREE_OK;
}

static enum scree_status do_show(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    struct study *study;
    enum scree_status status = find_study(daemon, body, &study, err);
    if (!status)
        *result = study_record(study, json_bool(body, "open", false));
    return status;
}

static enum scree_status do_table(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    (void)id;
    struct study *study;
    enum scree_status status = find_study(daemon, body, &study, err);
    if (!status)
        *result = study_table(study);
    return status;
}

static enum scree_status do_cancel(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                   struct scree_error *err)
{
    (void)id;
    struct study *study;
    enum scree_status status = find_study(daemon, body, &study, err);
    if (status || (status = studies_cancel(daemon->studies, study, err)))
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "job", study->id);
    json_put_text(*result, "state", job_state_word(study->state));
    return SCREE_OK;
}

static enum scree_status steer(struct daemon *daemon, const cJSON *body, const char *id, enum command_op op, cJSON **result,
                               struct scree_error *err)
{
    struct study *study;
    char request[LIMITS_REQUEST_MAX];
    limits_request(&daemon->user, id, request);
    enum scree_status status = find_study(daemon, body, &study, err);
    if (status || (status = studies_steer(daemon->studies, request, study, op, err)))
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "job", study->id);
    json_put_text(*result, "op", command_op_word(op));
    json_put_text(*result, "state", job_state_word(study->state));
    return SCREE_OK;
}

static enum scree_status do_pause(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result, struct scree_error *err)
{
    return steer(daemon, body, id, COMMAND_PAUSE, result, err);
}

static enum scree_status do_resume(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                   struct scree_error *err)
{
    return steer(daemon, body, id, COMMAND_RESUME, result, err);
}

/* Sets *later when the answer comes with the ticket. */
static enum scree_status do_fetch(struct daemon *daemon, const cJSON *body, bool *later, cJSON **result, struct scree_error *err)
{
    struct study *study;
    enum format format;
    char path[FILE_PATH_MAX];
    enum scree_status status = find_study(daemon, body, &study, err);
    if (status || (status = read_format(body, &format, err)) || (status = file_path(daemon, study, format, path, err)))
        return status;
    *later = format == FORMAT_H5;
    if (*later)
        return order_h5(daemon, study, path, err);
    if (!(status = write_csv(study, path, err)))
        *result = fetched(study->id, path, job_state_ended(study->state));
    return status;
}

static enum scree_status do_fetch_part(struct daemon *daemon, const cJSON *body, const char *id, cJSON **result,
                                       struct scree_error *err)
{
    (void)id;
    struct study *study;
    enum format format;
    char path[FILE_PATH_MAX];
    double offset = json_number(body, "offset", 0), bytes = json_number(body, "bytes", PART_MAX);
    enum scree_status status = find_study(daemon, body, &study, err);
    if (status || (status = read_format(body, &format, err)) || (status = file_path(daemon, study, format, path, err)))
        return status;
    if (!(offset >= 0 && offset <= 9e15 && offset == floor(offset)))
        return scree_fail(err, SCREE_INVALID, "offset", "offset: a whole number in 0..9e15 is expected");
    if (!(bytes >= 1 && bytes <= PART_MAX && bytes == floor(bytes)))
        return scree_fail(err, SCREE_INVALID, "bytes", "bytes: a whole number in 1..%d is expected", PART_MAX);
    return requests_file_part(study->id, path, offset, bytes, result, err);
}

static const struct operation {
    const char *name;
    enum scree_status (*carry_out)(struct daemon *, const cJSON *, const char *, cJSON **, struct scree_error *);
} operations[] = {
    {"check", do_check}, {"submit", do_submit},         {"show", do_show},   {"cancel", do_cancel},
    {"table", do_table}, {"fetch_part", do_fetch_part}, {"pause", do_pause}, {"resume", do_resume},
};

enum answer study_request(struct daemon *daemon, const struct envelope *envelope, const cJSON *body, cJSON **reply)
{
    struct scree_error error = {0};
    cJSON *result = NULL;
    enum scree_status status = SCREE_OK;
    bool later = false;
    size_t k = 0, count = sizeof operations / sizeof *operations;
    while (k < count && strcmp(operations[k].name, envelope->op) != 0)
        k++;
    if (strcmp(envelope->op, "fetch") == 0) {
        daemon->tickets++;
        status = do_fetch(daemon, body, &later, &result, &error);
        if (!status && later)
            return ANSWER_LATER;
    } else if (k < count) {
        status = operations[k].carry_out(daemon, body, envelope->id, &result, &error);
    } else {
        status = scree_fail(&error, SCREE_INVALID, "op", "\"%.32s\" is not an operation on a study", envelope->op);
    }
    *reply = status ? reply_error(envelope->id, scree_status_word(status), &error) : reply_ok(envelope->id, result);
    return ANSWER_NOW;
}

cJSON *study_list(struct daemon *daemon, unsigned wanted, size_t limit)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t k = studies_count(daemon->studies), taken = 0; k-- > 0 && taken < limit;) {
        const struct study *study = studies_at(daemon->studies, k);
        if (wanted && !(wanted >> study->state & 1))
            continue;
        cJSON_AddItemToArray(list, study_summary(study));
        taken++;
    }
    return list;
}
