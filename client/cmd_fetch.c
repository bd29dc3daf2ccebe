/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree fetch`: a job's result, or what there is of it so far. */
#include <stdio.h>

#include "destination.h"
#include "download.h"
#include "follow.h"
#include "output.h"
#include "protocol/frame.h"
#include "signals.h"
#include "verbs.h"

static void report(const char *job, const char *file, const struct download *download, bool json)
{
    if (!download->complete)
        say("%s has not ended: this is its result so far", job);
    if (!json) {
        puts(file);
        return;
    }
    cJSON *line = cJSON_CreateObject();
    json_put_text(line, "job", job);
    json_put_text(line, "file", file);
    json_put_real(line, "bytes", download->bytes);
    json_put_bool(line, "complete", download->complete);
    put_json_line(line);
    cJSON_Delete(line);
}

static void report_study(const char *study, const char *file, const char *text_file, const struct download *download, bool json)
{
    if (!download->complete)
        say("%s has not ended: these are its trials so far", study);
    if (!json) {
        puts(file);
        puts(text_file);
        return;
    }
    cJSON *line = cJSON_CreateObject();
    json_put_text(line, "job", study);
    json_put_text(line, "file", file);
    json_put_text(line, "csv", text_file);
    json_put_real(line, "bytes", download->bytes);
    json_put_bool(line, "complete", download->complete);
    put_json_line(line);
    cJSON_Delete(line);
}

static enum outcome fetch(struct link *link, const char *id, const char *file, bool json, struct scree_error *err)
{
    struct download download;
    char text_file[PATH_MAX];
    enum outcome outcome = is_study_id(id) ? download_study(link, id, file, text_file, &download, err)
                                           : download_result(link, id, file, &download, err);
    if (!outcome && is_study_id(id))
        report_study(id, file, text_file, &download, json);
    else if (!outcome)
        report(id, file, &download, json);
    return outcome;
}

static enum outcome fetch_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    struct destination place = {.existing = 0};
    cJSON *record = NULL;
    const char *job = arguments->words[0], *out = arguments_value(arguments, "-o");
    char name[PROTOCOL_ID_MAX + 8];
    if (!protocol_id_valid(job))
        return give_up(outcome_fail(&err, OUTCOME_REFUSED, "\"%.40s\" is no job's id", job), &err);
    snprintf(name, sizeof name, "%s.h5", job);
    signals_catch();
    enum outcome outcome = link_open_for(arguments, &link, &err);
    /* Whether there is such a job comes before a folder for it. */
    if (!outcome && !(outcome = ask_record(link, job, false, &record, &err)) &&
        !(outcome = destination_prepare(out ? out : name, &place, &err))) {
        outcome = fetch(link, job, place.file, arguments->json, &err);
        if (outcome)
            destination_abandon(&place);
    }
    cJSON_Delete(record);
    link_close(link);
    if (outcome && signals_count() > 0) {
        say_error(&err);
        signals_die();
    }
    return give_up(outcome, &err);
}

static const char *const options[] = {"-o=", NULL};

const struct verb verb_fetch = {
    .name = "fetch",
    .synopsis = "ID [-o DIR|FILE.h5]",
    .doc = "the result of a job as HDF5, or what there is so far",
    .help = "Writes ID.h5 here, FILE.h5, or DIR/result.h5, and prints its path; an older file of that name is replaced\n"
            "once the new one is whole. The file comes through the daemon's socket, wherever its data lie.\n"
            "\n"
            "Of a study it is a table with a row a trial, as ID.h5 and as ID.csv.\n"
            "\n"
            "  scree fetch j17\n"
            "  scree fetch j17 -o results/slope-24.h5\n",
    .options = options,
    .words_min = 1,
    .words_max = 1,
    .run = fetch_run,
};
