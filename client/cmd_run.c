/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree run`: from a spec to a result in one go.
 *
 * In order: the spec is checked, the place of the result is made sure of, a daemon
 * is found or started, the job is submitted, followed, fetched, summed up. What
 * can be refused is refused before anything runs. */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "destination.h"
#include "download.h"
#include "follow.h"
#include "output.h"
#include "signals.h"
#include "spec_file.h"
#include "study_print.h"
#include "submit.h"
#include "summary.h"
#include "verbs.h"

struct run {
    const struct arguments *arguments;
    struct spec_file spec;
    struct destination place;
    char text_file[PATH_MAX]; // a study's table as text
    bool placed;              // `place` is settled: at once with -o, once the job has an id without
    struct link *link;
    struct daemon own; // pid 0: the daemon is somebody else's
    bool is_private;
    char job[32];
    cJSON *record;
    bool fetched;
};

/* The daemon that was chosen, or the default one if it answers, or a private one. */
static enum outcome find_daemon(struct run *run, struct scree_error *err)
{
    char endpoint[WIRE_ENDPOINT_MAX];
    bool chosen;
    cJSON *pong = NULL;
    enum outcome outcome = link_endpoint(run->arguments->connect, endpoint, &chosen, err);
    if (outcome)
        return outcome;
    outcome = link_open(endpoint, &run->link, err);
    if (chosen)
        return outcome; // who named a daemon does not want another
    if (!outcome)
        outcome = link_ping(run->link, LINK_SILENCE_S, &pong, err);
    cJSON_Delete(pong);
    if (!outcome)
        return OUTCOME_DONE;
    link_close(run->link);
    run->link = NULL;
    say("no daemon answers at %s: starting a private one for this run", endpoint);
    run->is_private = true;
    if ((outcome = daemon_start(run->placed ? run->place.folder : ".", &run->own, err)))
        return outcome;
    return link_open(run->own.endpoint, &run->link, err);
}

static enum outcome settle_place(struct run *run, struct scree_error *err)
{
    const char *out = arguments_value(run->arguments, "-o");
    if (out) {
        enum outcome outcome = destination_prepare(out, &run->place, err);
        run->placed = !outcome;
        return outcome;
    }
    return destination_try_here(err);
}

static enum outcome submit(struct run *run, struct scree_error *err)
{
    bool reused;
    char stem[128];
    enum outcome outcome =
        submit_spec(run->link, &run->spec, arguments_flag(run->arguments, "--again"), run->job, sizeof run->job, &reused, err);
    if (outcome)
        return outcome;
    if (reused)
        say("%s has run this spec before and answers with its result (--again runs it anew)", run->job);
    if (run->placed)
        return OUTCOME_DONE;
    snprintf(stem, sizeof stem, "scree-%.40s-%s",
             run->spec.is_study ? study_kinds[run->spec.study.spec.kind].name : run->spec.job.scenario->name, run->job);
    outcome = destination_fresh(stem, &run->place, err);
    run->placed = !outcome;
    return outcome;
}

/* The result of an ended job; a job that failed before its first step may have none. */
static enum outcome fetch(struct run *run, struct scree_error *err)
{
    struct download download;
    char size[TEXT_MAX];
    enum outcome outcome = run->spec.is_study ? download_study(run->link, run->job, run->place.file, run->text_file, &download, err)
                                              : download_result(run->link, run->job, run->place.file, &download, err);
    run->fetched = outcome == OUTCOME_DONE;
    if (run->fetched && download.bytes > 64e6)
        say("fetched %s", text_bytes(download.bytes, size));
    return outcome;
}

static void report(const struct run *run)
{
    if (!run->arguments->json) {
        if (run->spec.is_study)
            study_print(run->record, run->fetched ? run->place.file : NULL, run->fetched ? run->text_file : NULL);
        else
            summary_print(run->record, run->fetched ? run->place.file : NULL);
        return;
    }
    if (run->spec.is_study)
        json_put_text(run->record, "csv", run->fetched ? run->text_file : NULL);
    json_put_text(run->record, "file", run->fetched ? run->place.file : NULL);
    put_json_line(run->record);
}

static enum outcome follow_and_fetch(struct run *run, struct scree_error *err)
{
    enum outcome outcome = OUTCOME_DONE;
    switch (follow_job(run->link, run->is_private ? &run->own : NULL, run->job, &run->record, &outcome, err)) {
    case FOLLOW_FAILED:
        return outcome;
    case FOLLOW_DETACHED:
        say("%s goes on without us: `scree watch %s`, `scree fetch %s`, `scree cancel %s`", run->job, run->job, run->job, run->job);
        return OUTCOME_DONE;
    case FOLLOW_ENDED:
        break;
    }
    enum outcome ended = outcome_of_state(json_text(run->record, "state"));
    outcome = fetch(run, err);
    report(run);
    if (ended == OUTCOME_FAILED)
        say("%s failed: %s", run->job, *summary_error(run->record) ? summary_error(run->record) : "the daemon does not say why");
    if (outcome && ended != OUTCOME_FAILED) // a job that failed before its first step has no result
        say_error(err);
    if (!ended && outcome)
        ended = outcome;
    return ended;
}

static enum outcome carry_out(struct run *run)
{
    struct scree_error err = {.status = SCREE_OK};
    enum outcome outcome = spec_file_read(run->arguments->words[0], run->arguments, 0, &run->spec, &err);
    if (outcome || (outcome = settle_place(run, &err)) || (outcome = find_daemon(run, &err)) || (outcome = submit(run, &err)))
        return give_up(outcome, &err);
    err.message[0] = 0;
    outcome = follow_and_fetch(run, &err);
    if (outcome && !run->record)
        say_error(&err);
    return outcome;
}

static enum outcome run_run(const struct arguments *arguments)
{
    struct run run = {.arguments = arguments};
    signals_catch();
    enum outcome outcome = carry_out(&run);
    if (run.is_private)
        daemon_stop(&run.own, run.link, signals_count() >= 2);
    link_close(run.link);
    if (run.placed && !run.fetched)
        destination_abandon(&run.place);
    bool detached = outcome == OUTCOME_DONE && !run.record;
    cJSON_Delete(run.record);
    spec_file_free(&run.spec);
    if (detached)
        signals_die();
    return outcome;
}

static const char *const options[] = {"--set=*", "-o=", "--again", NULL};

const struct verb verb_run = {
    .name = "run",
    .synopsis = "FILE [--set path=value]... [-o DIR|FILE.h5] [--again]",
    .doc = "run a job or a study: submit it, follow it, fetch its result",
    .help =
        "FILE is the JSON of a job or a study, \"-\" is stdin. --set changes one value of it. The result goes to DIR/result.h5\n"
        "or FILE.h5, without -o to a new folder scree-SCENARIO-JOB here; an older file of that name is replaced.\n"
        "\n"
        "The job is given to the daemon at the default endpoint if it answers, or to the one that --connect or\n"
        "SCREE_CONNECT names. If nobody was named and none answers, a private screed is started for this run,\n"
        "keeps its data beside the result, and is gone at the end.\n"
        "\n"
        "A daemon that has finished the same spec before answers with that result, unless --again.\n"
        "\n"
        "Ctrl-C with a private daemon cancels the job and keeps the result so far (exit code 3); a second one\n"
        "leaves at once. With any other daemon Ctrl-C only stops following: the job goes on.\n"
        "\n"
        "  scree run client/examples/slidequake.json -o data/first\n"
        "  scree run job.json --set params.slope_deg=24 --set time.end_s=2 -o steep.h5\n"
        "  scree run client/examples/bisect-mu_t.json\n"
        "  echo '{\"scenario\": \"collision\"}' | scree --json run -\n",
    .options = options,
    .words_min = 1,
    .words_max = 1,
    .run = run_run,
};
