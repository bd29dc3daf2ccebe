/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Published runs of seed 002 on the bare solver: prints the deposit's numbers along
 * time as CSV and what they come to at rest. The tables beside this file were made with it.
 *
 *     build/tests/results/continuum collapse B15 [params.key=value]...
 *     build/tests/results/continuum tilt [params.key=value]...
 *
 * `coarser=F` makes cells F times larger. A collapse ends when no point moves at
 * 0.01 m/s any more, a tilt at its end. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "measure/deposit.h"
#include "scenario/continuum.h"
#include "spec/scenarios.h"

static int fail(const struct scree_error *err)
{
    fprintf(stderr, "%s\n", err->message);
    return 1;
}

/* key=value by the table's own rows: numbers, words and true or false. */
static enum scree_status assign(struct job_spec *job, const char *text, struct scree_error *err)
{
    char key[128];
    const char *equals = strchr(text, '=');
    if (!equals || (size_t)(equals - text) >= sizeof key)
        return scree_fail(err, SCREE_INVALID, NULL, "%s is no key=value", text);
    memcpy(key, text, (size_t)(equals - text));
    key[equals - text] = 0;
    const char *value = equals + 1;
    bool time = strncmp(key, "time.", 5) == 0;
    const struct field *row;
    void *address;
    enum scree_status status = time ? field_resolve(&job_table, job, key, &row, &address, err)
                                    : field_resolve(job->scenario->params, job->params, key, &row, &address, err);
    if (status)
        return status;
    if (row->type == FIELD_REAL)
        *(double *)address = atof(value);
    else if (row->type == FIELD_INT)
        *(int64_t *)address = atoll(value);
    else if (row->type == FIELD_BOOL)
        *(bool *)address = strcmp(value, "true") == 0;
    else if (row->type == FIELD_ENUM)
        for (int k = 0; row->choices[k]; k++)
            if (strcmp(row->choices[k], value) == 0)
                *(int *)address = k;
    return SCREE_OK;
}

static void coarsen(struct job_spec *job, double factor)
{
    if (job->scenario == &scenario_collapse_fields) {
        struct collapse_params *p = (struct collapse_params *)(void *)job->params;
        p->cell_m *= factor;
        p->cell_height_m *= factor;
    } else {
        struct tilt_params *p = (struct tilt_params *)(void *)job->params;
        p->cells_x = (int64_t)round((double)p->cells_x / factor);
        p->cells_y = (int64_t)round((double)p->cells_y / factor);
        p->cells_z = (int64_t)round((double)p->cells_z / factor);
    }
}

static enum scree_status job_of(int argc, char **argv, struct job_spec *job, struct scree_error *err)
{
    bool collapse = argc > 1 && strcmp(argv[1], "collapse") == 0;
    int first = 2;
    job_defaults(job, collapse ? &scenario_collapse_fields : &scenario_tilt_fields);
    if (collapse && argc > 2) {
        struct collapse_params *p = (struct collapse_params *)(void *)job->params;
        const struct field *row = field_find(job->scenario->params, "run");
        for (p->run = 0; row->choices[p->run] && strcmp(row->choices[p->run], argv[2]) != 0;)
            p->run++;
        if (!row->choices[p->run])
            return scree_fail(err, SCREE_INVALID, NULL, "no run %s", argv[2]);
        job->scenario->adopt(job);
        first = 3;
    }
    for (int k = first; k < argc; k++) {
        enum scree_status status = SCREE_OK;
        if (strncmp(argv[k], "coarser=", 8) == 0)
            coarsen(job, atof(argv[k] + 8));
        else
            status = assign(job, argv[k], err);
        if (status)
            return status;
    }
    return job_check(job, 0, err);
}

/* Slope of a line through the surface over the middle of the box, rad (seed 002, section 2.4: 0.3 to 0.7 of its length). */
static double surface_slope(const struct continuum_view *view, const struct deposit_lines *lines)
{
    double n = 0, sx = 0, sz = 0, sxx = 0, sxz = 0;
    for (size_t k = 0; k < lines->layers; k++) {
        double x = (double)k * view->spacing[0], z = lines->surface[k];
        if (x < 0.3 * view->length[0] || x > 0.7 * view->length[0])
            continue;
        n++;
        sx += x;
        sz += z;
        sxx += x * x;
        sxz += x * z;
    }
    return atan((n * sxz - sx * sz) / (n * sxx - sx * sx));
}

static int run(const struct job_spec *job, struct mpm *mpm, const struct continuum_plan *plan, struct scree_error *err)
{
    const struct deposit_site site = {plan->bed, plan->gate_x, plan->start_s};
    bool collapse = plan->setup.tilt.hold_s == 0;
    struct continuum_view view;
    struct deposit_lines lines;
    struct deposit d;
    uint64_t every = (uint64_t)round(job->record.bulk.every_s / job->time.step_s),
             last = (uint64_t)round(job->time.end_s / job->time.step_s);
    if (mpm_view(mpm, &view, err) || deposit_lines_start(&lines, &view, err))
        return fail(err);
    printf("time_s,run_out_m,furthest_m,height_back_m,fastest_m_s,flowing,I30,I50,I70,surface_m3,overfull,sweeps,mean,largest,"
           "angle_deg,"
           "surface_deg\n");
    double surface0 = 0, began = (double)clock() / CLOCKS_PER_SEC;
    for (uint64_t step = 0; step <= last; step += every) {
        if ((step > 0 && mpm_advance(mpm, every, err)) || mpm_view(mpm, &view, err))
            return fail(err);
        deposit_measure(&view, &site, &lines, &d);
        struct mpm_report r = mpm_report(mpm);
        double angle = atan2(view.gravity[0], -view.gravity[2]);
        if (d.time_s <= 0)
            surface0 = d.surface_volume;
        printf("%.4f,%.4f,%.4f,%.4f,%.5f,%.4f,%.3g,%.3g,%.3g,%.6g,%.5f,%llu,%.2e,%.2e,%.3f,%.3f\n", d.time_s, d.run_out, d.furthest,
               d.height_back, d.fastest, d.flowing, d.inertial[0], d.inertial[1], d.inertial[2], d.surface_volume,
               d.overfull / view.volume, (unsigned long long)r.sweeps, r.residual.mean, r.residual.largest, angle * 180 / M_PI,
               (angle - surface_slope(&view, &lines)) * 180 / M_PI);
        if (collapse && d.time_s > 0.3 && d.fastest < DEPOSIT_REST)
            break;
    }
    struct mpm_report r = mpm_report(mpm);
    printf("# points %zu rows %llu steps %llu cpu_s %.1f sweeps a step %.1f unconverged %llu stalls %llu\n", mpm_points(mpm),
           (unsigned long long)r.rows, (unsigned long long)mpm_step(mpm), (double)clock() / CLOCKS_PER_SEC - began,
           (double)r.sweeps_total / (double)mpm_step(mpm), (unsigned long long)r.unconverged, (unsigned long long)r.stalls);
    printf("# t_f %.3f s, run-out %.4f m, H_f %.4f m, furthest %.4f m, surface volume lost %.2f %%, overfull %.2f %%\n", d.time_s,
           d.run_out, d.height_back, d.furthest, 100 * (1 - d.surface_volume / surface0), 100 * d.overfull / view.volume);
    deposit_lines_free(&lines);
    return 0;
}

int main(int argc, char **argv)
{
    struct job_spec job;
    struct scree_error err;
    struct continuum_plan plan;
    struct mpm *mpm;
    if (job_of(argc, argv, &job, &err))
        return fail(&err);
    continuum_scenario_find(job.scenario->name)->plan(&job, &plan);
    plan.setup.threads = (int)job.threads;
    if (mpm_create(&plan.setup, &mpm, &err))
        return fail(&err);
    int result = run(&job, mpm, &plan, &err);
    mpm_free(mpm);
    return result;
}
