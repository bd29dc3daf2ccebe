/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Runs a state without daemon, streams or records, and prints moving grain-steps
 * per CPU second. States are plain text: `N Lx Ly`, then a grain a line:
 * id, type (1 moves, 2 is fixed), radius, x y z, vx vy vz, wx wy wz, in SI. */
#include "bench.h"

#include <errno.h>
#include <math.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/memory.h"
#include "dem/dem.h"
#include "protocol/json.h"
#include "scree.h"

static const char help[] =
    "usage: scree bench [--case flow|rest|big | --state FILE] [--slope_deg A] [--steps N] [--warm N]\n"
    "                   [--tile NXxNY] [--threads N] [--isa NAME] [--ledger] [--json]\n"
    "\n"
    "  --case NAME     flow: 1,000 grains in steady flow at 23.5 deg (default); rest: the same at rest, 5 deg;\n"
    "                  big: the flow tiled to 28,000 grains\n"
    "  --state FILE    a state in plain text: `N Lx Ly`, then `id type radius x y z vx vy vz wx wy wz` a grain\n"
    "  --tile NXxNY    that many copies of the state side by side (default 1x1; big: 7x4)\n"
    "  --slope_deg A   slope, degrees (default: the case's)\n"
    "  --steps N       timed steps (default: about two seconds' worth)\n"
    "  --warm N        steps before them (default 2000)\n"
    "  --threads N     threads that step the world together (default 1)\n"
    "  --isa NAME      x86-64-v2, x86-64-v3 or x86-64-v4 (default: the best this machine has)\n"
    "  --ledger        keep the ledger of energy\n"
    "  --json          end with one line of JSON: grain_steps_per_s counts moving grains and CPU seconds\n"
    "\n"
    "example: scree bench --case rest --isa x86-64-v2\n";

enum { STEPS_A_SECOND = 4000000 }; // of 2.5e-7 s

struct options {
    const char *state, *isa;
    double slope_deg;
    long steps, warm;
    int threads, tiles_x, tiles_y;
    bool json, ledger;
};

struct state {
    struct dem_grain *grains;
    size_t count;
    double length[2];
};

static double clock_seconds(clockid_t clock)
{
    struct timespec now;
    clock_gettime(clock, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static enum scree_status read_state(const char *path, struct state *state, struct scree_error *err)
{
    FILE *file = fopen(path, "r");
    enum scree_status status = SCREE_OK;
    if (!file)
        return scree_fail(err, SCREE_INVALID, "state", "cannot read %s: %s", path, strerror(errno));
    if (fscanf(file, "%zu %lf %lf", &state->count, &state->length[0], &state->length[1]) != 3 || state->count < 1 ||
        state->count > SPEC_GRAINS_MAX || !(state->length[0] > 0 && state->length[1] > 0)) {
        status = scree_fail(err, SCREE_INVALID, "state", "%s:1: `N Lx Ly` is expected", path);
        goto out;
    }
    if (!(state->grains = memory_rows(state->count, sizeof *state->grains))) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu grains", state->count);
        goto out;
    }
    for (size_t k = 0; k < state->count && !status; k++) {
        struct dem_grain *g = &state->grains[k];
        double id;
        int type;
        if (fscanf(file, "%lf %d %lf %lf %lf %lf %lf %lf %lf %lf %lf %lf", &id, &type, &g->radius, &g->position[0], &g->position[1],
                   &g->position[2], &g->velocity[0], &g->velocity[1], &g->velocity[2], &g->spin[0], &g->spin[1],
                   &g->spin[2]) != 12 ||
            (type != 1 && type != 2) || !(g->radius > 0))
            status = scree_fail(err, SCREE_INVALID, "state",
                                "%s:%zu: `id type radius x y z vx vy vz wx wy wz` is expected, type 1 or 2", path, k + 2);
        g->fixed = type == 2;
        g->density = 2530;
    }
out:
    fclose(file);
    return status;
}

/* Copies of the state side by side. */
static enum scree_status tile(struct state *state, int nx, int ny, struct scree_error *err)
{
    size_t copies = (size_t)nx * (size_t)ny, k = 0;
    struct dem_grain *grains = memory_rows(state->count * copies, sizeof *grains);
    if (!grains)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for %zu grains", state->count * copies);
    for (int i = 0; i < nx; i++)
        for (int j = 0; j < ny; j++)
            for (size_t g = 0; g < state->count; g++, k++) {
                grains[k] = state->grains[g];
                grains[k].position[0] += i * state->length[0];
                grains[k].position[1] += j * state->length[1];
            }
    free(state->grains);
    state->grains = grains;
    state->count *= copies;
    state->length[0] *= nx;
    state->length[1] *= ny;
    return SCREE_OK;
}

/* Memory that the process holds now, bytes; 0 where the system does not say. */
static double resident_bytes(void)
{
    FILE *file = fopen("/proc/self/statm", "r");
    double pages = 0;
    if (file && fscanf(file, "%*s %lf", &pages) != 1)
        pages = 0;
    if (file)
        fclose(file);
    return pages * (double)sysconf(_SC_PAGESIZE);
}

static enum scree_status make_world(const struct options *o, const struct state *state, struct dem **out, struct scree_error *err)
{
    double slope = o->slope_deg * (M_PI / 180);
    const struct dem_setup setup = {.step_s = 1.0 / STEPS_A_SECOND,
                                    .gravity = {9.81 * sin(slope), 0, -9.81 * cos(slope)},
                                    .length = {state->length[0], state->length[1], 0},
                                    .grains = state->grains,
                                    .grain_count = state->count,
                                    .material = material_preset_find("glass-beads-2mm")->values,
                                    .floor_z = -INFINITY,
                                    .threads = o->threads,
                                    .isa = o->isa,
                                    .overlaps = true,
                                    .ledger = o->ledger};
    return dem_create(&setup, out, err);
}

/* Runs once more under a profile and prints where the time went. The clock's own
 * cost, some ten nanoseconds a phase and step, is in the shares. */
static enum scree_status print_breakdown(struct dem *dem, uint64_t steps, struct scree_error *err)
{
    static const char *const names[DEM_PHASES] = {"integrate",   "lists",  "search of the hot list",
                                                  "contact law", "gather", "measure"};
    struct dem_profile profile = {{0}};
    double wall = clock_seconds(CLOCK_MONOTONIC), total = 0;
    dem_profile(dem, &profile);
    enum scree_status status = dem_advance(dem, steps, err);
    dem_profile(dem, NULL);
    wall = clock_seconds(CLOCK_MONOTONIC) - wall;
    for (int k = 0; k < DEM_PHASES; k++)
        total += (double)profile.ticks[k];
    if (status || total <= 0)
        return status;
    double scale = 1e9 * wall / total / ((double)steps * (double)dem_moving(dem));
    for (int k = 0; k < DEM_PHASES; k++)
        printf("  %-24s %6.3f ns a grain-step, %4.1f %%\n", names[k], scale * (double)profile.ticks[k],
               100 * (double)profile.ticks[k] / total);
    return SCREE_OK;
}

/* The timed part; frees the state's grains once the world has its own. */
static enum scree_status run(const struct options *o, struct state *state, struct scree_error *err)
{
    struct dem *dem = NULL;
    double set_up = clock_seconds(CLOCK_MONOTONIC);
    enum scree_status status = make_world(o, state, &dem, err);
    if (status)
        return status;
    set_up = clock_seconds(CLOCK_MONOTONIC) - set_up;
    free(state->grains); // so that what is resident is the world's
    state->grains = NULL;
    if ((status = dem_advance(dem, (uint64_t)o->warm, err)))
        goto out;
    long steps = o->steps;
    if (steps <= 0) { // as many as take about two seconds
        double probe = clock_seconds(CLOCK_MONOTONIC);
        if ((status = dem_advance(dem, 200, err)))
            goto out;
        probe = clock_seconds(CLOCK_MONOTONIC) - probe;
        steps = (long)fmax(200, 200 * 2.0 / fmax(probe, 1e-6));
    }
    struct dem_counts before = dem_counts(dem);
    double wall = clock_seconds(CLOCK_MONOTONIC), cpu = clock_seconds(CLOCK_PROCESS_CPUTIME_ID);
    if ((status = dem_advance(dem, (uint64_t)steps, err)))
        goto out;
    wall = clock_seconds(CLOCK_MONOTONIC) - wall;
    cpu = clock_seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu;
    struct dem_counts after = dem_counts(dem);
    double moving = (double)dem_moving(dem), rate = moving * (double)steps / cpu;
    double refreshes = (double)(after.refreshes - before.refreshes), rebuilds = (double)(after.rebuilds - before.rebuilds);
    printf("%zu moving and %zu fixed grains, %ld steps, %s, %d thread%s\n", dem_moving(dem), dem_fixed(dem), steps, dem_isa(dem),
           o->threads, o->threads == 1 ? "" : "s");
    printf("%.4g million grain-steps a CPU second, %.4g a second; %.3g ns a grain-step; set up in %.3g s\n", rate / 1e6,
           moving * (double)steps / wall / 1e6, 1e9 / rate, set_up);
    printf("%.3g contacts a grain; %.3g hot pairs; %.3g near pairs, refreshed every %.4g steps; %.3g outer pairs, rebuilt every "
           "%.4g\n",
           (double)after.contacts / moving, (double)after.hot / moving, (double)after.near / moving,
           (double)steps / fmax(refreshes, 1), (double)after.outer / moving, (double)steps / fmax(rebuilds, 1));
    if (!o->json && (status = print_breakdown(dem, (uint64_t)(steps / 5 + 1), err)))
        goto out;
    if (o->json)
        printf("{\"grain_steps_per_s\":%.17g,\"wall_grain_steps_per_s\":%.17g,\"moving\":%zu,\"fixed\":%zu,\"steps\":%ld,"
               "\"cpu_s\":%.9g,\"wall_s\":%.9g,\"contacts_per_grain\":%.6g,\"near_per_grain\":%.6g,\"outer_per_grain\":%.6g,"
               "\"refreshes\":%.0f,\"rebuilds\":%.0f,\"set_up_s\":%.6g,\"resident_bytes\":%.0f,\"isa\":\"%s\",\"threads\":%d,"
               "\"hash\":\"%016llx\"}\n",
               rate, moving * (double)steps / wall, dem_moving(dem), dem_fixed(dem), steps, cpu, wall,
               (double)after.contacts / moving, (double)after.near / moving, (double)after.outer / moving, refreshes, rebuilds,
               set_up, resident_bytes(), dem_isa(dem), o->threads, (unsigned long long)dem_hash(dem));
out:
    dem_free(dem);
    return status;
}

/* The project's own states lie in the source tree; a moved build finds them from its own place. */
static void case_path(const char *name, char *out, size_t size)
{
    char exe[1024];
    ssize_t length = readlink("/proc/self/exe", exe, sizeof exe - 1);
    snprintf(out, size, SCREE_STATES "/%s.txt", name);
    if (access(out, R_OK) == 0 || length <= 0)
        return;
    exe[length] = 0;
    *strrchr(exe, '/') = 0;
    snprintf(out, size, "%s/../../tests/bench/states/%s.txt", exe, name);
}

static bool number(const char *text, double low, double high, double *out)
{
    char *end;
    *out = strtod(text, &end);
    return end != text && !*end && *out >= low && *out <= high;
}

static enum scree_status set_case(struct options *o, const char *name, char *path, size_t size, struct scree_error *err)
{
    bool rest = strcmp(name, "rest") == 0, big = strcmp(name, "big") == 0;
    if (!rest && !big && strcmp(name, "flow") != 0)
        return scree_fail(err, SCREE_INVALID, "case", "--case: \"%s\" is none of flow, rest, big", name);
    case_path(rest ? "static1k" : "flow1k", path, size);
    o->state = path;
    o->slope_deg = rest ? 5 : 23.5;
    o->tiles_x = big ? 7 : 1;
    o->tiles_y = big ? 4 : 1;
    return SCREE_OK;
}

static enum scree_status read_options(struct options *o, int argc, char **argv, char *path, size_t size, struct scree_error *err)
{
    enum scree_status status = set_case(o, "flow", path, size, err);
    for (int k = 1; k < argc && !status; k++) {
        const char *name = argv[k];
        double value = 0;
        if (strcmp(name, "--json") == 0 || strcmp(name, "--ledger") == 0) {
            *(name[2] == 'j' ? &o->json : &o->ledger) = true;
            continue;
        }
        if (k + 1 >= argc)
            return scree_fail(err, SCREE_INVALID, "", "%s: unknown, or its value is missing; see scree bench --help", name);
        const char *text = argv[++k];
        bool good = true;
        char rest;
        if (strcmp(name, "--case") == 0) {
            status = set_case(o, text, path, size, err);
        } else if (strcmp(name, "--state") == 0) {
            o->state = text;
            o->tiles_x = o->tiles_y = 1;
        } else if (strcmp(name, "--tile") == 0) {
            good = sscanf(text, "%dx%d%c", &o->tiles_x, &o->tiles_y, &rest) == 2 && o->tiles_x >= 1 && o->tiles_x <= 1000 &&
                   o->tiles_y >= 1 && o->tiles_y <= 1000;
        } else if (strcmp(name, "--isa") == 0) {
            o->isa = text;
        } else if (strcmp(name, "--slope_deg") == 0) {
            good = number(text, -90, 90, &o->slope_deg);
        } else if (strcmp(name, "--steps") == 0) {
            good = number(text, 1, 1e12, &value);
            o->steps = (long)value;
        } else if (strcmp(name, "--warm") == 0) {
            good = number(text, 0, 1e12, &value);
            o->warm = (long)value;
        } else if (strcmp(name, "--threads") == 0) {
            good = number(text, 1, 256, &value);
            o->threads = (int)value;
        } else {
            return scree_fail(err, SCREE_INVALID, "", "%s: unknown; see scree bench --help", name);
        }
        if (!good)
            return scree_fail(err, SCREE_INVALID, "", "%s: \"%s\" is not a value in its range", name, text);
    }
    return status;
}

int bench_main(int argc, char **argv)
{
    struct options options = {.threads = 1, .warm = 2000};
    struct state state = {0};
    struct scree_error error = {0};
    char path[2048];
    for (int k = 1; k < argc; k++)
        if (strcmp(argv[k], "--help") == 0 || strcmp(argv[k], "-h") == 0) {
            fputs(help, stdout);
            return 0;
        }
    enum scree_status status = read_options(&options, argc, argv, path, sizeof path, &error);
    if (!status)
        status = read_state(options.state, &state, &error);
    if (!status && options.tiles_x * options.tiles_y > 1)
        status = tile(&state, options.tiles_x, options.tiles_y, &error);
    if (!status)
        status = run(&options, &state, &error);
    free(state.grains);
    if (!status)
        return 0;
    fprintf(stderr, "scree bench: %s\n", error.message);
    return status == SCREE_INVALID ? 2 : 1;
}
