/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree plot`: a job or a study as a picture. */
#include <stdio.h>

#include "follow.h"
#include "output.h"
#include "plot.h"
#include "protocol/frame.h"
#include "verbs.h"

static enum outcome plot_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct link *link = NULL;
    cJSON *record = NULL;
    const char *id = arguments->words[0], *out = arguments_value(arguments, "-o");
    const struct plot_sweep how = {arguments_value(arguments, "--x"), arguments_value(arguments, "--y"),
                                   arguments_value(arguments, "--by"), arguments_flag(arguments, "--log"),
                                   arguments_value(arguments, "--beside")};
    char file[PROTOCOL_ID_MAX + 8];
    if (!protocol_id_valid(id))
        return give_up(outcome_fail(&err, OUTCOME_REFUSED, "\"%.40s\" is no id of a job or a study", id), &err);
    if ((how.x || how.y || how.by || how.log || how.beside) && !is_study_id(id))
        return give_up(
            outcome_fail(&err, OUTCOME_REFUSED, "--x, --y, --by, --log and --beside are for sweeps, and %s is a job", id), &err);
    snprintf(file, sizeof file, "%s.png", id);
    out = out ? out : file;
    enum outcome outcome = link_open_for(arguments, &link, &err);
    if (!outcome && !(outcome = ask_record(link, id, true, &record, &err)))
        outcome = is_study_id(id) ? plot_study(link, record, &how, out, &err) : plot_job(link, record, out, &err);
    if (!outcome && arguments->json) {
        cJSON *line = cJSON_CreateObject();
        json_put_text(line, "job", id);
        json_put_text(line, "file", out);
        put_json_line(line);
        cJSON_Delete(line);
    } else if (!outcome) {
        puts(out);
    }
    cJSON_Delete(record);
    link_close(link);
    return give_up(outcome, &err);
}

static const char *const options[] = {"-o=", "--x=", "--y=", "--by=", "--log", "--beside=", NULL};

const struct verb verb_plot = {
    .name = "plot",
    .synopsis = "ID [-o FILE.png|FILE.svg] [--x COLUMN] [--y COLUMN] [--by COLUMN] [--log] [--beside LAWS]",
    .doc = "a picture of a job: force, spectrum, profiles; or of what a study has come to",
    .help = "Draws ID.png here, or FILE, with gnuplot (Debian: gnuplot-nox), and prints its name. Of a job: the force on\n"
            "the base against time, averaged and with its extremes; spectrum and profiles where they are recorded; of a\n"
            "continuum the free surface and what flows below it at three times; of a flow down a chute the apparatus and its\n"
            "section with the grains of four snapshots, the deposit from above, variance, losses and layers; of rigid bodies with\n"
            "record.views what they look like from aside and from above at five instants of a collapse, with the run-out and the\n"
            "height of the last. Of a search: the bracket and the trials, round by round. Of a sweep: one column of its table\n"
            "(`scree fetch`) against another, by default the first that differ; trials that differ in more get a line each, or a\n"
            "line each value of --by. --log fits a power law to each line; --beside draws others with them, as \"2,1 3.4,0.65\"\n"
            "for 2 x and 3.4 x^0.65. Where the force has a spectrum, by default its power against the inertial number and beside\n"
            "what models predict; of flows down a chute, mobility against beta with its bars beside the published lines; of a\n"
            "sweep over scenarios grains beside continuum.\n"
            "\n"
            "  scree plot j17\n"
            "  scree plot s3 -o sweep.svg --x params.slope_deg --y mean_velocity\n"
            "  scree plot s5 --x aspect_ratio --y run_out_ratio --by params.plane --log --beside \"2,1 3.4,0.65\"\n",
    .options = options,
    .words_min = 1,
    .words_max = 1,
    .run = plot_run,
};
