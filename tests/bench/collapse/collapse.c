/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Seconds a step of the continuum on the column of run B00 (protocols 3.1), by
 * phase, with the history of the residual: fixed inputs, so that two builds can be
 * told apart. Prints CSV-like lines to stdout.
 *
 *     bench_collapse [--scale 1] [--points 6] [--steps 5] [--warm 0] [--threads 1]
 *                    [--sweeps 200] [--tolerance 1e-8] [--plain] [--isa NAME] [--history] */
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

#include "mpm/mpm.h"

struct options {
    double scale; // cells along an axis over the script's
    int points, steps, warm, threads, sweeps, check;
    double tolerance, step_s, recover_s, jitter;
    bool plain, history;
    const char *isa;
};

/* B00: column 0.224 x 0.06 x 0.1194 m on a bed of an eighth of its height, gate of two cells that lifts at 0.2 s. */
static enum scree_status build(const struct options *o, struct mpm **out, struct scree_error *err)
{
    const double column = 0.224, height = 0.1194, width = 0.06, bed = height / 8;
    int along = (int)round(22 * o->scale), up = (int)round(30 * o->scale), across = (int)round(6 * o->scale);
    double h = column / along;
    int total = (int)ceil(0.62 / h);
    struct mpm_region regions[2] = {{{0, 0, 0}, {total * h, width, bed}}, {{0, 0, bed}, {column, width, bed + height}}};
    struct mpm_body gate = {.low = {column, -1, bed},
                            .high = {column + 2 * h, 1, 1},
                            .velocity = {0, 0, 0.7},
                            .start_s = 0.0,
                            .tau_s = 0.13,
                            .mu = 0.23};
    struct mpm_setup s = {
        .step_s = o->step_s,
        .gravity = {0, 0, -9.81},
        .length = {total * h, width, height / 0.8},
        .cells = {total, across, up},
        .density = 1473,
        .walls = {[MPM_X_LOW] = {MPM_FRICTION, .mu = 0.23},
                  [MPM_X_HIGH] = {MPM_STICK},
                  [MPM_Y_LOW] = {MPM_FRICTION, .mu = 0.23},
                  [MPM_Y_HIGH] = {MPM_FRICTION, .mu = 0.23},
                  [MPM_Z_LOW] = {MPM_STICK},
                  [MPM_Z_HIGH] = {MPM_SLIP}},
        .bodies = &gate,
        .body_count = 1,
        .regions = regions,
        .region_count = 2,
        .points_per_cell = o->points,
        .jitter = o->jitter,
        .seed = 1,
        .law = &mpm_law_constant,
        .coefs = {.mu = 0.44},
        .grain_diameter = 0.47e-3,
        .inertial_density = 1473 / 0.6,
        .recover_s = o->recover_s,
        .solver = {.tolerance = o->tolerance, .sweeps = o->sweeps, .check = o->check, .accelerate = !o->plain},
        .threads = o->threads,
        .isa = o->isa,
    };
    return mpm_create(&s, out, err);
}

static void see(void *context, uint64_t sweeps, struct mpm_residual residual)
{
    (void)context;
    printf("sweep %llu mean %.3e largest %.3e\n", (unsigned long long)sweeps, residual.mean, residual.largest);
}

static double cpu_seconds(void)
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static bool take(struct options *o, char **argv)
{
    const char *name = argv[0];
    const char *value = argv[1] ? argv[1] : "0";
    if (strcmp(name, "--scale") == 0)
        o->scale = atof(value);
    else if (strcmp(name, "--points") == 0)
        o->points = atoi(value);
    else if (strcmp(name, "--steps") == 0)
        o->steps = atoi(value);
    else if (strcmp(name, "--warm") == 0)
        o->warm = atoi(value);
    else if (strcmp(name, "--threads") == 0)
        o->threads = atoi(value);
    else if (strcmp(name, "--sweeps") == 0)
        o->sweeps = atoi(value);
    else if (strcmp(name, "--check") == 0)
        o->check = atoi(value);
    else if (strcmp(name, "--tolerance") == 0)
        o->tolerance = atof(value);
    else if (strcmp(name, "--step") == 0)
        o->step_s = atof(value);
    else if (strcmp(name, "--recover") == 0)
        o->recover_s = atof(value);
    else if (strcmp(name, "--jitter") == 0)
        o->jitter = atof(value);
    else if (strcmp(name, "--isa") == 0)
        o->isa = value;
    else
        return false;
    return true;
}

static void report_step(struct mpm *mpm)
{
    struct mpm_report r = mpm_report(mpm);
    double base[3];
    mpm_take_base_force(mpm, base);
    struct continuum_view view;
    if (mpm_view(mpm, &view, NULL) != SCREE_OK)
        return;
    double far = 0;
    for (size_t p = 0; p < view.points; p++)
        far = fmax(far, view.position[p][2] > 0.02 ? view.position[p][0] : 0);
    printf("step %llu t %.5f rows %llu contacts %llu sweeps %llu mean %.2e largest %.2e moved %llu overfull %.3f%% courant %.3f "
           "stalls %llu base %.3f %.3f %.3f kinetic %.4e front %.3f\n",
           (unsigned long long)mpm_step(mpm), mpm_time(mpm), (unsigned long long)r.rows, (unsigned long long)r.contacts,
           (unsigned long long)r.sweeps, r.residual.mean, r.residual.largest, (unsigned long long)r.moved,
           100 * r.overfull / view.volume, r.worst_courant, (unsigned long long)r.stalls, base[0], base[1], base[2], view.kinetic,
           far);
}

int main(int argc, char **argv)
{
    struct options o = {.scale = 1,
                        .points = 6,
                        .steps = 5,
                        .threads = 1,
                        .sweeps = 1000,
                        .check = 10,
                        .tolerance = 1e-8,
                        .step_s = 1.0 / 1200,
                        .jitter = 1};
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--plain") == 0)
            o.plain = true;
        else if (strcmp(argv[k], "--history") == 0)
            o.history = true;
        else if (take(&o, argv + k))
            k++;
        else
            return fprintf(stderr, "unknown option %s\n", argv[k]), 2;
    struct scree_error err;
    struct mpm *mpm;
    if (build(&o, &mpm, &err) != SCREE_OK)
        return fprintf(stderr, "%s\n", err.message), 1;
    struct mpm_profile profile = {{0}};
    enum scree_status status = o.warm ? mpm_advance(mpm, (uint64_t)o.warm, &err) : SCREE_OK;
    mpm_profile(mpm, &profile);
    if (o.history)
        mpm_watch(mpm, see, NULL);
    printf("points %zu isa %s\n", mpm_points(mpm), mpm_isa(mpm));
    double began = cpu_seconds(), steps_cpu = 0;
    for (int k = 0; k < o.steps && !status; k++) {
        began = cpu_seconds();
        status = mpm_advance(mpm, 1, &err);
        steps_cpu += cpu_seconds() - began;
        if (o.steps <= 20 || (k + 1) % (o.steps / 20) == 0)
            report_step(mpm);
    }
    if (status)
        return fprintf(stderr, "%s\n", err.message), 1;
    static const char *const names[MPM_PHASES] = {"assemble", "prepare", "sweep", "residual", "extrapolate", "move", "sort"};
    for (int k = 0; k < MPM_PHASES; k++)
        printf("%s %.5f s a step\n", names[k], profile.seconds[k] / o.steps);
    printf("cpu %.5f s a step, %.3g point-steps a second, hash %016llx\n", steps_cpu / o.steps,
           (double)mpm_points(mpm) * o.steps / steps_cpu, (unsigned long long)mpm_hash(mpm));
    mpm_free(mpm);
    return 0;
}
