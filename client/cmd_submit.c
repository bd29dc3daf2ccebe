/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree submit`: jobs into the daemon's queue, one id a line. Every file is
 * checked before the first is submitted, so that a mistake submits nothing. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "protocol/frame.h"
#include "submit.h"
#include "verbs.h"

enum outcome submit_spec(struct link *link, const struct spec_file *spec, bool again, char *job, size_t size, bool *reused,
                         struct scree_error *err)
{
    cJSON *body = cJSON_CreateObject(), *result = NULL;
    enum outcome outcome = mesh_file_send(&spec->mesh, link, err);
    if (!outcome && body) {
        json_put(body, "spec", cJSON_Duplicate(spec->json, true));
        json_put_bool(body, "again", again);
    }
    if (outcome)
        cJSON_Delete(body);
    else
        outcome = link_request(link, "submit", body, &result, err);
    const char *id = outcome ? NULL : json_text(result, "job");
    if (outcome == OUTCOME_REFUSED) {
        struct scree_error plain = *err;
        snprintf(err->message, sizeof err->message, "%s: %s", spec->name, plain.message);
    } else if (!outcome && (!protocol_id_valid(id) || strlen(id) >= size)) {
        outcome = outcome_fail(err, OUTCOME_FAILED, "the daemon's answer to a submit names no job");
    } else if (!outcome) {
        snprintf(job, size, "%s", id);
        *reused = json_bool(result, "reused", false);
    }
    cJSON_Delete(result);
    return outcome;
}

static void report(const char *file, const char *job, bool reused, bool json)
{
    if (!json) {
        puts(job);
        fflush(stdout);
        if (reused)
            say("%s: %s has run this spec before (--again runs it anew)", file, job);
        return;
    }
    cJSON *line = cJSON_CreateObject();
    json_put_text(line, "job", job);
    json_put_text(line, "file", file);
    json_put_bool(line, "reused", reused);
    put_json_line(line);
    cJSON_Delete(line);
}

static enum outcome submit_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    enum outcome outcome = OUTCOME_DONE;
    struct spec_file *specs = calloc((size_t)arguments->word_count, sizeof *specs);
    if (!specs)
        return give_up(outcome_fail(&err, OUTCOME_FAILED, "no memory"), &err);
    for (int k = 0; k < arguments->word_count && !outcome; k++)
        outcome = spec_file_read(arguments->words[k], arguments, 0, &specs[k], &err);
    if (!outcome)
        outcome = link_open_for(arguments, &link, &err);
    for (int k = 0; k < arguments->word_count && !outcome; k++) {
        char job[32];
        bool reused;
        outcome = submit_spec(link, &specs[k], arguments_flag(arguments, "--again"), job, sizeof job, &reused, &err);
        if (!outcome)
            report(specs[k].name, job, reused, arguments->json);
    }
    for (int k = 0; k < arguments->word_count; k++)
        spec_file_free(&specs[k]);
    free(specs);
    link_close(link);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--set=*", "--again", NULL};

const struct verb verb_submit = {
    .name = "submit",
    .synopsis = "FILE... [--set path=value]... [--again]",
    .doc = "put jobs into the daemon's queue and print one id per line",
    .help =
        "FILE is the JSON of a job or a study, \"-\" is stdin. All files are checked before the first is submitted; --set changes\n"
        "a value of each. A spec that the daemon has finished before is answered with the id of that job, unless\n"
        "--again. A mesh that a job names (params.mesh.file, seen from FILE's folder) is read and given to the daemon first.\n"
        "Exit code 75: the queue is full, try again later.\n"
        "\n"
        "  scree submit job.json\n"
        "  scree wait $(scree submit a.json b.json)\n"
        "  scree submit job.json --set seed=2 --again\n"
        "  scree submit client/examples/slidequakes.json\n",
    .options = options,
    .words_min = 1,
    .words_max = -1,
    .run = submit_run,
};
