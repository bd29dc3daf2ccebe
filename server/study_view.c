/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See study_view.h, and study.h for what a search came to. */
#include "study_view.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "base/text.h"
#include "outcome.h"
#include "protocol/frame.h"

/* ---- what a search came to ---- */

static const char *const bisect_words[] = {"searching", "found", "same_ends", "reversed", "stuck"};
static const char *const root_words[] = {"searching", "found", "same_ends", "stuck"};

const char *study_conclusion(const struct study *study, size_t replica)
{
    if (study->bisects)
        return bisect_words[study->bisects[replica].end];
    return study->roots ? root_words[study->roots[replica].end] : "";
}

bool study_found(const struct study *study, size_t replica, double *value, double *low, double *high)
{
    if (study->bisects) {
        const struct bisect *b = &study->bisects[replica];
        *value = bisect_value(b);
        *low = b->low;
        *high = b->high;
        return b->end == BISECT_FOUND;
    }
    const struct root *r = &study->roots[replica];
    *value = root_value(r);
    *low = r->low;
    *high = r->high;
    return r->end == ROOT_FOUND;
}

const char *study_answer_word(const struct study *study, const struct study_trial *trial)
{
    if (!trial->job)
        return "lost";
    if (trial->spared && trial->job->state == JOB_CANCELLED)
        return "not needed";
    if (trial->job->state != JOB_DONE)
        return job_state_word(trial->job->state);
    if (trial->job->altered)
        return "steered";
    if (!study->bisects)
        return "done";
    static const char *const words[] = {"undecided", "raise", "lower", "undecided"};
    const struct bisect *b = &study->bisects[trial->replica];
    if (trial->point >= b->point_count || trial != study_trial_at(study, trial->replica, trial->point))
        return "undecided"; // and run again, for longer
    return words[b->points[trial->point].answer];
}

/* "j5 at material.mu_t = 0.5 is steady" */
static void describe(const struct study *study, size_t replica, int point, char *out, size_t size)
{
    const struct study_trial *t = study_trial_at(study, (int)replica, point);
    double at = study->bisects ? study->bisects[replica].points[point].at : study->roots[replica].points[point].at;
    char value[TEXT_REAL_MAX], number[TEXT_REAL_MAX], end[TEXT_REAL_MAX];
    size_t length = (size_t)snprintf(out, size, "%s at %s = %s ", t && t->job ? t->job->id : "a trial", study->plan.spec.over,
                                     text_real(at, value));
    if (!t || !t->job || length >= size)
        return;
    if (t->job->state != JOB_DONE)
        snprintf(out + length, size - length, "%s%s%.200s", t->job->state == JOB_FAILED ? "failed" : "was cancelled",
                 *t->job->report.error.message ? ": " : "", t->job->report.error.message);
    else if (t->job->altered)
        snprintf(out + length, size - length, "was changed with `set`, so that it is no answer");
    else if (study->roots && study->roots[replica].points[point].failed)
        snprintf(out + length, size - length, "has no number \"%s\"", study->plan.spec.number);
    else if (study->roots)
        snprintf(out + length, size - length, "gives %s = %s", study->plan.spec.number,
                 text_real(study->roots[replica].points[point].number, number));
    else
        snprintf(out + length, size - length, "is %s after %s s", scree_verdict_word(t->job->report.verdict),
                 text_real(t->job->report.time_s, end));
}

void study_contradiction(const struct study *study, size_t replica, char *out, size_t size)
{
    int lower, raise;
    char a[240], b[240];
    *out = 0;
    if (!study->bisects || !bisect_contradiction(&study->bisects[replica], &lower, &raise))
        return;
    describe(study, replica, lower, a, sizeof a);
    describe(study, replica, raise, b, sizeof b);
    snprintf(out, size, "verdicts are not monotone: %s, yet %s; the bracket is that of the lowest change", a, b);
}

/* The first point of the last round that has no answer. */
static int missing_point(const struct study *study, size_t replica)
{
    if (study->roots) {
        for (int k = 0; k < study->roots[replica].point_count; k++)
            if (study->roots[replica].points[k].failed)
                return k;
        return 0;
    }
    const struct bisect *b = &study->bisects[replica];
    for (int k = b->rounds[b->round_count - 1].first; k < b->point_count; k++)
        if (b->points[k].needed && b->points[k].answer == BISECT_NEITHER)
            return k;
    return 0;
}

bool study_explain(const struct study *study, struct scree_error *err)
{
    char a[300], b[300], low_text[TEXT_REAL_MAX], high_text[TEXT_REAL_MAX];
    for (size_t r = 0; r < (size_t)study->plan.spec.replicas; r++) {
        double value, low, high;
        if (study_found(study, r, &value, &low, &high))
            continue;
        const char *why = study_conclusion(study, r);
        if (strcmp(why, "stuck") == 0) {
            describe(study, r, missing_point(study, r), a, sizeof a);
            scree_fail(err, SCREE_NOT_FOUND, study->plan.spec.over, "the search cannot go on within %s..%s: %s",
                       text_real(low, low_text), text_real(high, high_text), a);
            if (study->bisects && strstr(a, "is undecided"))
                scree_hint(err, "let trials run longer: time.end_s, extend_to_s");
            return true;
        }
        describe(study, r, 0, a, sizeof a);
        describe(study, r, 1, b, sizeof b);
        scree_fail(err, SCREE_NOT_FOUND, study->plan.spec.over,
                   strcmp(why, "reversed") == 0 ? "the ends of the bracket answer the wrong way round: %s, %s"
                                                : "both ends of the bracket give the same answer: %s, %s",
                   a, b);
        scree_hint(err, study->bisects ? "raise_low_when must hold at the low end and not at the high end"
                                       : "the target must lie between the two");
        return true;
    }
    return false;
}

/* ---- JSON ---- */

static void put_time(cJSON *json, const char *key, double unix_seconds)
{
    if (unix_seconds > 0)
        json_put_real(json, key, unix_seconds);
    else
        json_put(json, key, cJSON_CreateNull());
}

/* Done part of a job that is on its way. */
static double fraction_of(const struct job *job)
{
    double end = job ? job->spec.time.end_s : 0;
    if (!job || job_state_ended(job->state))
        return 1;
    return end > 0 ? fmin(1, job->report.time_s / end) : 0;
}

static double sweep_progress(const struct study *study)
{
    double done = (double)study->first_open;
    for (size_t k = study->first_open; k < study->trial_count; k++)
        done += fraction_of(study->trials[k].job);
    return study->plan.trials ? done / (double)study->plan.trials : 0;
}

/* Rounds of all replicas that are complete over those there may be. */
static double search_progress(const struct study *study)
{
    double done = 0, all = 0;
    for (size_t r = 0; r < (size_t)study->plan.spec.replicas; r++) {
        double complete = study->bisects ? study->bisects[r].round_count : study->roots[r].point_count - 1;
        double left = study->bisects ? bisect_rounds_left(&study->bisects[r]) : study->roots[r].end == ROOT_SEARCHING ? 4 : 0;
        bool begun = complete > 0;
        done += complete;
        all += complete + (begun ? left : left + 1);
    }
    return all > 0 ? done / all : 0;
}

static double progress_of(const struct study *study)
{
    if (study->state == JOB_DONE)
        return 1;
    if (!study->readable)
        return 0;
    return study_is_search(study) ? search_progress(study) : sweep_progress(study);
}

/* Why it waits: the reason of the first of its trials that is held. */
static const char *why_of(const struct study *study)
{
    for (size_t k = study->first_open; k < study->trial_count; k++)
        if (study->trials[k].job && study->trials[k].job->state == JOB_HELD)
            return study->trials[k].job->why;
    return "";
}

/* One word for the whole study. */
static const char *conclusion_of(const struct study *study)
{
    const char *word = "";
    for (size_t r = 0; study_is_search(study) && study->readable && r < (size_t)study->plan.spec.replicas; r++) {
        word = study_conclusion(study, r);
        if (strcmp(word, "found") != 0)
            break;
    }
    return study_is_search(study) ? word : study->state == JOB_DONE ? "complete" : "";
}

cJSON *study_summary(const struct study *study)
{
    size_t counts[JOB_STATES] = {0};
    struct timespec now;
    cJSON *json = cJSON_CreateObject(), *states = cJSON_CreateObject();
    double progress = progress_of(study);
    clock_gettime(CLOCK_REALTIME, &now);
    double elapsed = (double)now.tv_sec - study->started;
    for (size_t k = 0; k < study->trial_count; k++)
        counts[study->trials[k].job ? study->trials[k].job->state : JOB_FAILED]++;
    for (int k = 0; k < JOB_STATES; k++)
        json_put_int(states, job_state_word((enum job_state)k), (long long)counts[k]);
    json_put_text(json, "id", study->id);
    json_put_text(json, "kind", study_kinds[study->plan.spec.kind].name);
    json_put_text(json, "title", study->plan.spec.title);
    json_put_text(json, "scenario", study->plan.base.scenario->name);
    json_put_text(json, "state", job_state_word(study->state));
    json_put_text(json, "conclusion", conclusion_of(study));
    json_put_real(json, "progress", progress);
    if (study->state == JOB_RUNNING && progress > 0 && elapsed > 0)
        json_put_real(json, "eta_s", elapsed * (1 - progress) / progress);
    else
        json_put(json, "eta_s", cJSON_CreateNull());
    if (study_is_search(study))
        json_put(json, "total", cJSON_CreateNull());
    else
        json_put_int(json, "total", (long long)study->plan.trials);
    json_put(json, "jobs", states);
    put_time(json, "submitted", study->submitted);
    put_time(json, "started", study->started);
    put_time(json, "ended", study->ended);
    return json;
}

static void put_paper(cJSON *json, const struct study *study, double answer)
{
    const struct scree_number number = {.name = "answer", .value = answer};
    char paper[OUTCOME_PAPER_MAX];
    outcome_fill(study->plan.spec.paper, &number, 1, paper);
    json_put_text(json, "paper", paper);
}

/* Answers of a search, each replica's, and their spread; returns their mean, NaN if there is none. */
static double put_answers(cJSON *json, const struct study *study)
{
    cJSON *answers = cJSON_CreateArray();
    double n = 0, mean = 0, squares = 0, least = INFINITY, most = -INFINITY;
    for (size_t r = 0; r < (size_t)study->plan.spec.replicas; r++) {
        char note[640];
        double value, low, high;
        bool found = study_found(study, r, &value, &low, &high);
        cJSON *row = cJSON_CreateObject();
        json_put_int(row, "replica", (long long)r);
        json_put_text(row, "conclusion", study_conclusion(study, r));
        if (found)
            json_put_real(row, "value", value);
        else
            json_put(row, "value", cJSON_CreateNull());
        json_put_real(row, "low", low);
        json_put_real(row, "high", high);
        study_contradiction(study, r, note, sizeof note);
        json_put_text(row, "note", note);
        cJSON_AddItemToArray(answers, row);
        if (!found)
            continue;
        n++;
        double off = value - mean; // Welford
        mean += off / n;
        squares += off * (value - mean);
        least = fmin(least, value);
        most = fmax(most, value);
    }
    json_put(json, "answers", answers);
    cJSON *spread = n > 0 ? cJSON_CreateObject() : cJSON_CreateNull();
    if (n > 0) {
        json_put_real(spread, "replicas", n);
        json_put_real(spread, "mean", mean);
        json_put(spread, "deviation", n > 1 ? json_real(sqrt(squares / (n - 1))) : cJSON_CreateNull());
        json_put_real(spread, "least", least);
        json_put_real(spread, "most", most);
    }
    json_put(json, "spread", spread);
    return n > 0 ? mean : NAN;
}

static void put_bracket(cJSON *list, size_t replica, int round, double low, double high)
{
    cJSON *row = cJSON_CreateObject();
    json_put_int(row, "replica", (long long)replica);
    json_put_int(row, "round", round);
    json_put_real(row, "low", low);
    json_put_real(row, "high", high);
    cJSON_AddItemToArray(list, row);
}

static cJSON *bracket_history(const struct study *study)
{
    cJSON *list = cJSON_CreateArray();
    for (size_t r = 0; r < (size_t)study->plan.spec.replicas; r++)
        if (study->bisects) {
            const struct bisect *b = &study->bisects[r];
            for (int k = 0; k < b->round_count; k++)
                put_bracket(list, r, k, b->rounds[k].low, b->rounds[k].high);
        } else {
            const struct root *root = &study->roots[r];
            for (int k = 1; k < root->point_count; k++)
                if (root->points[k].answered && (k > 1 || root->points[0].answered))
                    put_bracket(list, r, k - 1, root->points[k].low, root->points[k].high);
        }
    return list;
}

/* Round of a search's trial. */
static int round_of(const struct study *study, const struct study_trial *t)
{
    if (study->bisects && t->point < study->bisects[t->replica].point_count)
        return study->bisects[t->replica].points[t->point].round;
    return study->roots ? (t->point < 2 ? 0 : t->point - 1) : 0;
}

static cJSON *trial_json(const struct study *study, size_t index)
{
    const struct study_trial *t = &study->trials[index];
    const struct job *job = t->job;
    bool search = study_is_search(study);
    cJSON *json = cJSON_CreateObject(), *values = cJSON_CreateObject();
    json_put_int(json, "trial", (long long)index);
    json_put_int(json, "replica", search ? t->replica : (long long)study_plan_replica(&study->plan, (size_t)t->point));
    if (search)
        json_put_int(json, "round", round_of(study, t));
    for (size_t c = 0; job && c < study->plan.column_count; c++) {
        const char *unit;
        json_put(values, study->plan.columns[c], job_value_at(&job->spec, study->plan.columns[c], &unit));
    }
    json_put(json, "values", values);
    if (job && *job->spec.paper) {
        char paper[OUTCOME_PAPER_MAX];
        outcome_fill(job->spec.paper, job->report.numbers, job->report.number_count, paper);
        json_put_text(json, "paper", paper);
    }
    json_put_text(json, "answer", study_answer_word(study, t));
    json_put_text(json, "job", job ? job->id : NULL);
    json_put_text(json, "state", job ? job_state_word(job->state) : "lost");
    json_put_text(json, "verdict", job ? scree_verdict_word(job->report.verdict) : "undecided");
    json_put_text(json, "evidence", job ? job->report.evidence : "");
    json_put_real(json, "time_s", job ? job->report.time_s : 0);
    json_put_real(json, "end_s", job ? job->spec.time.end_s : 0);
    json_put_real(json, "progress", fraction_of(job));
    json_put_real(json, "wall_s", job ? job->report.wall_s : 0);
    if (study->roots && t->point < study->roots[t->replica].point_count && t->taken &&
        !study->roots[t->replica].points[t->point].failed)
        json_put_real(json, "number", study->roots[t->replica].points[t->point].number);
    if (job && job->state == JOB_FAILED)
        json_put_text(json, "error", job->report.error.message);
    return json;
}

cJSON *study_record(const struct study *study, bool open_only)
{
    cJSON *json = study_summary(study), *trials = cJSON_CreateArray();
    json_put(json, "spec", cJSON_CreateRaw(study->spec_text));
    json_put_text(json, "build", *study->build ? study->build : scree_build());
    double answer = NAN;
    if (study_is_search(study) && study->readable) {
        const char *unit;
        cJSON_Delete(job_value_at(&study->plan.base, study->plan.spec.over, &unit));
        json_put_text(json, "over", study->plan.spec.over);
        json_put_text(json, "unit", unit);
        answer = put_answers(json, study);
        json_put(json, "bracket", bracket_history(study));
    }
    put_paper(json, study, answer);
    for (size_t k = open_only ? study->first_open : 0; k < study->trial_count; k++)
        if (!open_only || !study->trials[k].taken)
            cJSON_AddItemToArray(trials, trial_json(study, k));
    json_put(json, "trials", trials);
    json_put(json, "error",
             study->state == JOB_FAILED ? error_json(scree_status_word(study->error.status), &study->error) : cJSON_CreateNull());
    json_put_text(json, "why", why_of(study));
    return json;
}
