/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The job's own fields, its defaults and the checks that need no simulation. */
#include <stdio.h>
#include <string.h>

#include "spec/spec.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

static const struct field time_fields[] = {
    {.name = "step_s",
     .type = FIELD_REAL,
     .offset = offsetof(struct time_spec, step_s),
     .min = 1e-12,
     .max = 1,
     .preset = 2.5e-7,
     .unit = "s",
     .doc = "time step",
     .source = "seed 000 S4.5"},
    {.name = "end_s",
     .type = FIELD_REAL,
     .offset = offsetof(struct time_spec, end_s),
     .min = 0,
     .max = 1e6,
     .preset = 20,
     .unit = "s",
     .doc = "simulated time at which the job ends at the latest",
     .source = "",
     .steerable = true},
};
static const struct field_table time_table = {"time", "", time_fields, COUNT(time_fields), sizeof(struct time_spec)};

static const char *const stop_words[] = {"rest", "steady", "accelerating", NULL};
static const struct field stop_fields[] = {
    {.name = "when",
     .type = FIELD_FLAGS,
     .offset = offsetof(struct stop_spec, when),
     .preset = STOP_REST | STOP_STEADY,
     .unit = "",
     .doc = "verdicts that end the job; [] runs to time.end_s",
     .source = "",
     .choices = stop_words,
     .steerable = true},
};
static const struct field_table stop_table = {"stop", "", stop_fields, COUNT(stop_fields), sizeof(struct stop_spec)};

#define EVERY(seconds, what)                                                                                                       \
    {                                                                                                                              \
        .name = "every_s", .type = FIELD_REAL, .offset = sizeof(double), .min = 1e-12, .max = 1e6, .preset = seconds, .unit = "s", \
        .doc = what, .source = "", .steerable = true                                                                               \
    }
static const struct field series_fields[] = {
    EVERY(2.5e-6, "length of the blocks that are averaged over, a whole number of steps"),
    {.name = "chunk",
     .type = FIELD_INT,
     .offset = offsetof(struct record_series, chunk),
     .min = 16,
     .max = 65536,
     .preset = 1024,
     .unit = "samples",
     .doc = "samples in a chunk of the stream; each chunk is a commit to disk, so take more where every_s is short",
     .source = ""},
};
static const struct field bulk_fields[] = {EVERY(1e-3, "interval between samples")};
static const struct field snapshot_fields[] = {EVERY(1e-2, "interval between frames")};
static const struct field flow_fields[] = {EVERY(0.1, "interval between samples")};
static const struct field surface_fields[] = {EVERY(1.0 / 15, "interval between frames")};
_Static_assert(offsetof(struct record_series, every_s) == sizeof(double) &&
                   offsetof(struct record_every, every_s) == sizeof(double),
               "EVERY takes the interval to follow the switch");
_Static_assert(offsetof(struct record_profiles, every_s) == sizeof(double) &&
                   offsetof(struct record_views, every_s) == sizeof(double),
               "here, too");

static const struct field_table series_table = {"series", "", series_fields, COUNT(series_fields), sizeof(struct record_series)};
static const struct field_table bulk_table = {"bulk", "", bulk_fields, COUNT(bulk_fields), sizeof(struct record_every)};
static const struct field_table snapshot_table = {"snapshots", "", snapshot_fields, COUNT(snapshot_fields),
                                                  sizeof(struct record_every)};
static const struct field_table flow_table = {"flow", "", flow_fields, COUNT(flow_fields), sizeof(struct record_every)};
static const struct field_table surface_table = {"surface", "", surface_fields, COUNT(surface_fields), sizeof(struct record_every)};
static const struct field_table contact_table = {"contact", "", NULL, 0, sizeof(struct record_every)};

static const struct field profiles_fields[] = {
    EVERY(1e-3, "interval between samples"),
    {.name = "frame_s",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_profiles, frame_s),
     .min = 1e-12,
     .max = 1e6,
     .preset = 0.1,
     .unit = "s",
     .doc = "time that a frame is the mean over, a whole number of samples",
     .source = ""},
};
static const struct field collisions_fields[] = {
    {.name = "chunk",
     .type = FIELD_INT,
     .offset = offsetof(struct record_log, chunk),
     .min = 16,
     .max = 65536,
     .preset = 4096,
     .unit = "collisions",
     .doc = "collisions in a chunk of the stream",
     .source = ""},
    {.name = "from_s",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_log, from_s),
     .min = 0,
     .max = 1e6,
     .unit = "s",
     .doc = "time from which collisions go into the stream; those before count in the summary alone",
     .source = ""},
};
static const struct field spectrum_fields[] = {
    {.name = "window_s",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_spectrum, window_s),
     .min = 1e-12,
     .max = 1e3,
     .preset = 0.5,
     .unit = "s",
     .doc = "time that each spectrum is of: at least 8 (segments + 1) blocks of basal_force.every_s",
     .source = "protocols 1.6"},
    {.name = "segments",
     .type = FIELD_INT,
     .offset = offsetof(struct record_spectrum, segments),
     .min = 1,
     .max = 64,
     .preset = 8,
     .unit = "",
     .doc = "half-overlapping Hann windows that a spectrum is the mean of",
     .source = "protocols 1.10"},
    {.name = "band_hz",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_spectrum, band_hz),
     .min = 1e-3,
     .max = 1e9,
     .preset = 1e3,
     .unit = "Hz",
     .doc = "width of the bands that power is averaged over",
     .source = "protocols 1.10"},
    {.name = "fit_from_hz",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_spectrum, fit_from_hz),
     .min = 1e-3,
     .max = 1e9,
     .preset = 2e3,
     .unit = "Hz",
     .doc =
         "lower end of the fit of an impact's spectrum: below, the flow's own motion counts; of softened grains lower as 1 / tau",
     .source = "protocols 1.10"},
    {.name = "fit_to_hz",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_spectrum, fit_to_hz),
     .min = 1e-3,
     .max = 1e9,
     .preset = 150e3,
     .unit = "Hz",
     .doc = "upper end of that fit",
     .source = "protocols 1.10"},
};
static const struct field rolling_fields[] = {
    {.name = "every_s",
     .type = FIELD_REAL,
     .offset = offsetof(struct record_every, every_s),
     .min = 1e-12,
     .max = 1e6,
     .preset = 1e-3,
     .unit = "s",
     .doc = "interval between samples, which are fitted",
     .source = ""},
};
static const struct field_table rolling_table = {"rolling", "", rolling_fields, COUNT(rolling_fields), sizeof(struct record_every)};
static const struct field connectivity_fields[] = {EVERY(1e-3, "interval between samples")};
static const struct field heap_fields[] = {EVERY(5e-3, "interval between samples")};
static const struct field views_fields[] = {
    EVERY(0.05, "interval between frames"),
    {.name = "pixels",
     .type = FIELD_INT,
     .offset = offsetof(struct record_views, pixels),
     .min = 1,
     .max = 40,
     .preset = 8,
     .unit = "pixels",
     .doc = "across the sphere of a body's volume; larger pixels where a picture would have more than four million",
     .source = "seed 001 III: some 20"},
};
static const struct field forces_fields[] = {EVERY(1e-2, "interval between frames")};
static const struct field_table profiles_table = {"profiles", "", profiles_fields, COUNT(profiles_fields),
                                                  sizeof(struct record_profiles)};
static const struct field_table collisions_table = {"collisions", "", collisions_fields, COUNT(collisions_fields),
                                                    sizeof(struct record_log)};
static const struct field_table spectrum_table = {"spectrum", "", spectrum_fields, COUNT(spectrum_fields),
                                                  sizeof(struct record_spectrum)};
static const struct field_table connectivity_table = {"connectivity", "", connectivity_fields, COUNT(connectivity_fields),
                                                      sizeof(struct record_every)};
static const struct field_table heap_table = {"heap", "", heap_fields, COUNT(heap_fields), sizeof(struct record_every)};
static const struct field_table views_table = {"views", "", views_fields, COUNT(views_fields), sizeof(struct record_views)};
static const struct field_table forces_table = {"forces", "", forces_fields, COUNT(forces_fields), sizeof(struct record_every)};

static const struct field record_fields[] = {
    {.name = "basal_force",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, basal_force),
     .preset = 1,
     .unit = "",
     .doc = "force of the flow on its base, three components, taken at every step and averaged over blocks",
     .source = "protocols 1.6",
     .table = &series_table},
    {.name = "bulk",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, bulk),
     .preset = 1,
     .unit = "",
     .doc = "energies, speeds, centre of mass: what verdicts rest on",
     .source = "protocols 1.5",
     .table = &bulk_table},
    {.name = "energy",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, energy),
     .preset = 0,
     .unit = "",
     .doc = "ledger: work of gravity, kinetic, elastic, dissipated",
     .source = "",
     .table = &bulk_table},
    {.name = "snapshots",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, snapshots),
     .preset = 0,
     .unit = "",
     .doc = "every grain's state",
     .source = "",
     .table = &snapshot_table},
    {.name = "flow",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, flow),
     .preset = 0,
     .unit = "",
     .doc = "scenario chute: place, transverse agitation and energy lost of the flow's central 5 cm",
     .source = "seed 003 3.4",
     .table = &flow_table},
    {.name = "surface",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, surface),
     .preset = 0,
     .unit = "",
     .doc = "continuum: free surface and line between static and flowing along the channel, a frame an instant",
     .source = "seed 002 section 4.2",
     .table = &surface_table},
    {.name = "contact",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, contact),
     .preset = 0,
     .unit = "",
     .doc = "scenario collision: overlap and forces of the one contact, at every step",
     .source = "",
     .table = &contact_table},
    {.name = "rolling",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, rolling),
     .preset = 0,
     .unit = "",
     .doc = "scenario rolling: place, velocity and spin of the sphere, and the fit of how it rocks",
     .source = "seed 000 S4.2",
     .table = &rolling_table},
    {.name = "profiles",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, profiles),
     .preset = 0,
     .unit = "",
     .doc = "by height over the base: solid fraction, velocity, temperature, impacts, share joined to the base",
     .source = "seed 000 S5",
     .table = &profiles_table},
    {.name = "collisions",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, collisions),
     .preset = 0,
     .unit = "",
     .doc = "every contact that forms, with its speeds of impact",
     .source = "seed 000 S5",
     .table = &collisions_table},
    {.name = "connectivity",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, connectivity),
     .preset = 0,
     .unit = "",
     .doc = "grains that chains of contacts join to the base",
     .source = "seed 000 S1",
     .table = &connectivity_table},
    {.name = "spectrum",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, spectrum),
     .preset = 0,
     .unit = "",
     .doc = "power spectrum of the force on the base, with the fit of an impact's",
     .source = "seed 000 S6",
     .table = &spectrum_table},
    {.name = "forces",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, forces),
     .preset = 0,
     .unit = "",
     .doc = "the network of contacts, a frame an instant",
     .source = "seed 000, movies S2 and S3",
     .table = &forces_table},
    {.name = "heap",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, heap),
     .preset = 0,
     .unit = "",
     .doc = "rigid bodies: speeds on the way, contacts and fabric when the gate goes or at the end, kind of collapse",
     .source = "seed 001 IV",
     .table = &heap_table},
    {.name = "views",
     .type = FIELD_SWITCH,
     .offset = offsetof(struct record_spec, views),
     .preset = 0,
     .unit = "",
     .doc = "rigid bodies: pictures from above and from aside, a frame an instant",
     .source = "seed 001 III.C",
     .table = &views_table},
};
static const struct field_table record_table = {"record", "", record_fields, COUNT(record_fields), sizeof(struct record_spec)};

static const struct field job_fields[] = {
    {.name = "seed",
     .type = FIELD_INT,
     .offset = offsetof(struct job_spec, seed),
     .min = 0,
     .max = 9007199254740992.0,
     .preset = 1,
     .unit = "",
     .doc = "of the random filling",
     .source = ""},
    {.name = "title",
     .type = FIELD_TEXT,
     .offset = offsetof(struct job_spec, title),
     .size = sizeof(((struct job_spec *)0)->title),
     .unit = "",
     .doc = "for people",
     .source = "",
     .aside = true},
    {.name = "paper",
     .type = FIELD_TEXT,
     .offset = offsetof(struct job_spec, paper),
     .size = sizeof(((struct job_spec *)0)->paper),
     .unit = "",
     .doc = SPEC_PAPER_DOC,
     .source = "",
     .aside = true},
    {.name = "threads",
     .type = FIELD_INT,
     .offset = offsetof(struct job_spec, threads),
     .min = 1,
     .max = 256,
     .preset = 1,
     .unit = "",
     .doc = "threads that step this world together; worth it above some 20,000 grains",
     .source = "",
     .aside = true},
    {.name = "priority",
     .type = FIELD_INT,
     .offset = offsetof(struct job_spec, priority),
     .min = -100,
     .max = 100,
     .preset = 0,
     .unit = "",
     .doc = "jobs of higher priority leave the queue first",
     .source = "",
     .aside = true,
     .steerable = true},
    {.name = "time",
     .type = FIELD_GROUP,
     .offset = offsetof(struct job_spec, time),
     .unit = "",
     .doc = "",
     .source = "",
     .table = &time_table},
    {.name = "stop",
     .type = FIELD_GROUP,
     .offset = offsetof(struct job_spec, stop),
     .unit = "",
     .doc = "",
     .source = "",
     .table = &stop_table},
    {.name = "record",
     .type = FIELD_GROUP,
     .offset = offsetof(struct job_spec, record),
     .unit = "",
     .doc = "",
     .source = "",
     .table = &record_table},
};
const struct field_table job_table = {"job", "what every job can say beside its scenario's params and its material", job_fields,
                                      COUNT(job_fields), sizeof(struct job_spec)};

void job_defaults(struct job_spec *job, const struct scenario_fields *scenario)
{
    memset(job, 0, sizeof *job);
    job->scenario = scenario;
    field_defaults(&job_table, job);
    field_defaults(scenario->params, job->params);
    const struct material_preset *preset = material_preset_find(scenario->material);
    memcpy(&job->material, material_preset_values(preset), material_preset_kind(preset)->table->size);
    if (scenario->defaults)
        scenario->defaults(job);
}

/* Records that only worlds of one kind have, and one that only its own scenario has. */
static enum scree_status check_kind(const struct job_spec *job, struct scree_error *err)
{
    static const char *const of_grains[] = {"profiles", "collisions", "connectivity", "spectrum", "forces"};
    static const char *const of_bodies[] = {"heap", "views"};
    char path[64];
    if (job->record.rolling.on && strcmp(job->scenario->name, "rolling") != 0)
        return scree_fail(err, SCREE_INVALID, "record.rolling",
                          "record.rolling: is for scenario rolling, of one sphere on a plane");
    for (size_t k = 0; k < COUNT(of_grains) && job->scenario->kind == SCENARIO_MPM; k++)
        if (record_find(job, of_grains[k]).on) {
            snprintf(path, sizeof path, "record.%s", of_grains[k]);
            return scree_fail(err, SCREE_INVALID, path, "%s: is for worlds of grains, and scenario %s is a continuum", path,
                              job->scenario->name);
        }
    if (job->record.surface.on && job->scenario->kind != SCENARIO_MPM)
        return scree_fail(err, SCREE_INVALID, "record.surface", "record.surface: is for continua, and scenario %s is none",
                          job->scenario->name);
    for (size_t k = 0; k < COUNT(of_bodies) && scenario_material(job->scenario)->table != &rigid_table; k++)
        if (record_find(job, of_bodies[k]).on) {
            snprintf(path, sizeof path, "record.%s", of_bodies[k]);
            return scree_fail(err, SCREE_INVALID, path, "%s: is for worlds of rigid bodies, and scenario %s has none", path,
                              job->scenario->name);
        }
    return SCREE_OK;
}

/* What is asked for at the end of a time must come before the run's. */
static enum scree_status check_within_run(const struct job_spec *job, double value, const char *path, struct scree_error *err)
{
    if (value <= job->time.end_s)
        return SCREE_OK;
    return scree_fail(err, SCREE_INVALID, path, "%s: %.9g s is longer than the run, which ends at %.9g s", path, value,
                      job->time.end_s);
}

/* Frames of profiles, and where the log of collisions begins. */
static enum scree_status check_frames(const struct job_spec *job, struct scree_error *err)
{
    const struct record_profiles *p = &job->record.profiles;
    static const char path[] = "record.profiles.frame_s";
    if (p->on && p->frame_s < p->every_s)
        return scree_fail(err, SCREE_INVALID, path, "%s: %.9g s is shorter than record.profiles.every_s = %.9g s", path, p->frame_s,
                          p->every_s);
    enum scree_status status = p->on ? check_within_run(job, p->frame_s, path, err) : SCREE_OK;
    if (!status && job->record.collisions.on)
        status = check_within_run(job, job->record.collisions.from_s, "record.collisions.from_s", err);
    return status;
}

/* A window must fit into the run, and hold enough blocks. */
static enum scree_status check_spectrum(const struct job_spec *job, struct scree_error *err)
{
    static const char path[] = "record.spectrum.window_s";
    const struct record_spectrum *s = &job->record.spectrum;
    if (!s->on)
        return SCREE_OK;
    double every = job->record.basal_force.every_s, blocks = s->window_s / every, need = 8 * (double)(s->segments + 1);
    enum scree_status status = check_within_run(job, s->window_s, path, err);
    if (status)
        return status;
    if (blocks + 0.5 < need)
        return scree_fail(
            err, SCREE_INVALID, path,
            "%s: %.9g s holds %.0f blocks of record.basal_force.every_s = %.9g s, and %lld segments need at least %.0f", path,
            s->window_s, blocks, every, (long long)s->segments, need);
    if (!(s->fit_from_hz < s->fit_to_hz))
        return scree_fail(err, SCREE_INVALID, "record.spectrum.fit_to_hz",
                          "record.spectrum.fit_to_hz: %.9g Hz is not above fit_from_hz = %.9g Hz", s->fit_to_hz, s->fit_from_hz);
    if (blocks > 1e8)
        return scree_fail(err, SCREE_INVALID, path, "%s: %.9g s holds %.3g blocks of the force; at most 1e8 fit", path, s->window_s,
                          blocks);
    return SCREE_OK;
}

/* Measured in worlds of some thousand (tests/results), the slow ones of each kind, as estimates are upper bounds: of a
 * continuum's points, the spheres that fragments are made of, rigid crosses (beads of that law are three times as fast),
 * beads in a bed at rest (flows of glass are five times as fast). */
static double rate_of(const struct job_spec *job)
{
    const struct field_table *material = scenario_material(job->scenario)->table;
    if (job->scenario->kind == SCENARIO_MPM)
        return 2e6;
    return material == &rigid_table ? 1e6 : material == &fragment_table ? 1e7 : 3e7;
}

struct job_cost job_cost(const struct job_spec *job)
{
    struct job_cost cost = job->scenario->cost(job);
    cost.rate = rate_of(job);
    return cost;
}

double job_cost_seconds(const struct job_cost *cost)
{
    return cost->rate > 0 ? cost->moving * cost->steps / cost->rate : 0;
}

enum scree_status job_check(const struct job_spec *job, double memory_limit, struct scree_error *err)
{
    enum scree_status status;
    if ((status = field_check(&job_table, job, "", err)) ||
        (status = field_check(job->scenario->params, job->params, "params", err)) ||
        (status = field_check(scenario_material(job->scenario)->table, &job->material, "material", err)))
        return status;
    struct job_cost cost = job->scenario->cost(job);
    if (memory_limit > 0 && cost.bytes > memory_limit) {
        scree_fail(err, SCREE_NO_MEMORY, "params", "this world needs %.3g GB of memory and %.3g GB are to be had", cost.bytes / 1e9,
                   memory_limit / 1e9);
        scree_hint(err, "%.4g grains at about %.3g bytes each: take fewer", cost.moving + cost.fixed, SPEC_BYTES_PER_GRAIN);
        return SCREE_NO_MEMORY;
    }
    if ((status = check_kind(job, err)) || (status = check_frames(job, err)) || (status = check_spectrum(job, err)))
        return status;
    return job->scenario->check(job, err);
}

struct record_choice record_find(const struct job_spec *job, const char *name)
{
    const struct field *row = field_find(&record_table, name);
    if (!row)
        return (struct record_choice){0};
    const char *spec = (const char *)&job->record + row->offset;
    const struct field *every = field_find(row->table, "every_s");
    return (struct record_choice){
        .on = *(const bool *)spec, .every_s = every ? *(const double *)(const void *)(spec + every->offset) : 0, .spec = spec};
}

enum scree_status job_steer_check(const struct job_spec *from, const struct job_spec *to, struct scree_error *err)
{
    if (from->scenario != to->scenario)
        return scree_fail(err, SCREE_INVALID, "scenario", "scenario: cannot be changed once a job has begun");
    enum scree_status status;
    if (from->record.spectrum.on && from->record.basal_force.every_s != to->record.basal_force.every_s)
        return scree_fail(err, SCREE_INVALID, "record.basal_force.every_s",
                          "record.basal_force.every_s: cannot be changed while record.spectrum is on, whose windows it fills");
    if ((status = field_steer_check(&job_table, from, to, "", err)) ||
        (status = field_steer_check(from->scenario->params, from->params, to->params, "params", err)))
        return status;
    return field_steer_check(scenario_material(from->scenario)->table, &from->material, &to->material, "material", err);
}

bool job_same(const struct job_spec *a, const struct job_spec *b)
{
    return a->scenario == b->scenario && field_same(&job_table, a, b) && field_same(a->scenario->params, a->params, b->params) &&
           field_same(scenario_material(a->scenario)->table, &a->material, &b->material);
}
