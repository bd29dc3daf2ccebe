/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree watch`: a job's progress, as `run` shows it. */
#include "follow.h"
#include "output.h"
#include "signals.h"
#include "study_print.h"
#include "summary.h"
#include "verbs.h"

static enum outcome watch_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *record = NULL;
    const char *job = arguments->words[0];
    bool detached = false;
    signals_catch();
    enum outcome outcome = link_open_for(arguments, &link, &err);
    if (!outcome) {
        detached = follow_job(link, NULL, job, &record, &outcome, &err) == FOLLOW_DETACHED;
        if (record && arguments->json)
            put_json_line(record);
        else if (record && is_study_id(job))
            study_print(record, NULL, NULL);
        else if (record)
            summary_print(record, json_text(record, "result"));
    }
    link_close(link);
    if (detached) {
        say("%s goes on: `scree watch %s`, `scree cancel %s`", job, job, job);
        output_end();
        signals_die();
    }
    if (!record)
        return give_up(outcome, &err);
    outcome = outcome_of_state(json_text(record, "state"));
    if (outcome == OUTCOME_FAILED)
        say("%s failed: %s", job, *summary_error(record) ? summary_error(record) : "the daemon does not say why");
    cJSON_Delete(record);
    return outcome;
}

const struct verb verb_watch = {
    .name = "watch",
    .synopsis = "ID",
    .doc = "follow a job's or a study's progress to its end; exits with its outcome",
    .help = "On a terminal a bar with time, ETA, grain-steps per second and the basal normal force; elsewhere a line\n"
            "every ten seconds, all on stderr. Ends with the summary on stdout, with --json the job's record.\n"
            "Ctrl-C stops watching, not the job. A daemon that is gone is waited for, 10 s at most (exit code 69).\n"
            "\n"
            "  scree watch j17\n",
    .words_min = 1,
    .words_max = 1,
    .run = watch_run,
};
