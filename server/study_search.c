/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The search of a study: what its trials answer to the machines of calibrate/, and
 * which points still wait for a trial. See study.h. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "study.h"

/* Points of a round: what may run at once is shared by the replicas. */
static int sections_of(const struct study_spec *spec)
{
    int64_t share = spec->at_once / spec->replicas;
    return (int)(share < 1 ? 1 : share > BISECT_SECTIONS_MAX ? BISECT_SECTIONS_MAX : share);
}

enum scree_status study_start_searches(struct study *study, struct scree_error *err)
{
    const struct study_spec *s = &study->plan.spec;
    size_t replicas = (size_t)s->replicas;
    if (s->kind == STUDY_SWEEP)
        return SCREE_OK;
    if (s->kind == STUDY_BISECT)
        study->bisects = calloc(replicas, sizeof *study->bisects);
    else
        study->roots = calloc(replicas, sizeof *study->roots);
    if (!study->bisects && !study->roots)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a study");
    for (size_t r = 0; r < replicas; r++)
        if (study->bisects)
            bisect_start(&study->bisects[r], s->low, s->high, (int)s->digits, sections_of(s));
        else
            root_start(&study->roots[r], s->low, s->high, s->target, (int)s->digits);
    return SCREE_OK;
}

int study_point_count(const struct study *study, int replica)
{
    return study->bisects ? study->bisects[replica].point_count : study->roots[replica].point_count;
}

bool study_point_needed(const struct study *study, int replica, int point)
{
    if (study->bisects)
        return study->bisects[replica].points[point].needed;
    return true;
}

static bool point_pending(const struct study *study, int replica, int point)
{
    if (study->bisects)
        return study->bisects[replica].points[point].answer == BISECT_PENDING;
    return !study->roots[replica].points[point].answered;
}

double study_point_at(const struct study *study, int replica, int point)
{
    return study->bisects ? study->bisects[replica].points[point].at : study->roots[replica].points[point].at;
}

double study_longer(const struct study *study, const struct study_trial *trial)
{
    double limit = study_plan_extension(&study->plan), end = trial->job ? trial->job->spec.time.end_s : limit;
    return end < limit * (1 - 1e-12) ? fmin(2 * end, limit) : 0;
}

static void take_bisection(struct study *study, const struct study_trial *trial)
{
    struct bisect *b = &study->bisects[trial->replica];
    enum bisect_answer answer = BISECT_NEITHER;
    enum scree_verdict verdict = trial->job ? trial->job->report.verdict : VERDICT_UNDECIDED;
    static const unsigned bits[] = {[VERDICT_UNDECIDED] = 0,
                                    [VERDICT_REST] = STOP_REST,
                                    [VERDICT_STEADY] = STOP_STEADY,
                                    [VERDICT_ACCELERATING] = STOP_ACCELERATING};
    static const enum bisect_answer undecided[] = {
        [UNDECIDED_REPORT] = BISECT_NEITHER, [UNDECIDED_RAISE] = BISECT_RAISE, [UNDECIDED_LOWER] = BISECT_LOWER};
    if (trial->job && trial->job->state == JOB_DONE && !trial->job->altered) {
        if (bits[verdict])
            answer = study->plan.spec.raise_low_when & bits[verdict] ? BISECT_RAISE : BISECT_LOWER;
        else if (b->points[trial->point].needed && study_longer(study, trial) > 0)
            return; // asked again, for longer
        else
            answer = undecided[study->plan.spec.undecided];
    }
    bisect_put(b, trial->point, answer);
}

static void take_root(struct study *study, const struct study_trial *trial)
{
    const struct job *job = trial->job;
    double number = NAN;
    for (size_t k = 0; job && job->state == JOB_DONE && !job->altered && k < job->report.number_count; k++)
        if (strcmp(job->report.numbers[k].name, study->plan.spec.number) == 0)
            number = job->report.numbers[k].value;
    root_put(&study->roots[trial->replica], trial->point, number, !isfinite(number));
}

const struct study_trial *study_trial_at(const struct study *study, int replica, int point)
{
    for (size_t k = study->trial_count; k-- > 0;)
        if (study->trials[k].replica == replica && study->trials[k].point == point)
            return &study->trials[k];
    return NULL;
}

void study_take(struct study *study, const struct study_trial *trial)
{
    if (trial->point >= study_point_count(study, trial->replica))
        return; // the journal has a trial that this search would not have asked for
    if (study->bisects)
        take_bisection(study, trial);
    else
        take_root(study, trial);
}

bool study_point_waits(const struct study *study, int replica, int point)
{
    return point_pending(study, replica, point) && study_point_needed(study, replica, point);
}
