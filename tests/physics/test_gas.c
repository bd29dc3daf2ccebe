/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A gas of grains against kinetic theory: the log of collisions by closed forms
 * of elastic spheres, and Haff's law of cooling (B-16), all through worlds. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <string.h>

#include "measure/spectrum.h"
#include "scree.h"

#define FRACTION    0.1
#define TEMPERATURE 0.01 // m2/s2

#define PLATEAU_FROM 20.0 // Hz: far above the crossing of the box by sound
#define PLATEAU_TO   0.1  // in 1 / tau: half of the corner

/* What a run tells: collisions, and the energies of its last sample. */
struct told {
    double power, shape; // of the force on the floor, summed over bands of the plateau; zeta there
    double tau;          // of an impact on the floor, s; 0: spectra are not looked at
    double collisions, dn2, dt2;
    double fast[2];              // collisions faster than 0.97 and 1.03 of what 99.9 % of those of Maxwell's gas stay below
    double first, last, elastic; // translation's energy at the first and last sample, the springs' at the last, J
};

static enum scree_status keep(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    struct told *told = context;
    size_t columns = chunk->stream->column_count;
    (void)err;
    for (size_t k = 0; k < chunk->rows; k++) {
        const double *row = chunk->values + k * columns;
        if (strcmp(chunk->stream->name, "spectrum") == 0 && row[0] > PLATEAU_FROM && row[0] * told->tau < PLATEAU_TO) {
            told->power += row[3];
            told->shape += zeta(row[0] * told->tau);
        } else if (strcmp(chunk->stream->name, "collisions") == 0) {
            told->collisions++;
            told->dn2 += row[4] * row[4];
            told->fast[0] += fabs(row[4]) > 0.97 * sqrt(4 * TEMPERATURE * log(1000));
            told->fast[1] += fabs(row[4]) > 1.03 * sqrt(4 * TEMPERATURE * log(1000));
            told->dt2 += row[5] * row[5];
        } else if (strcmp(chunk->stream->name, "energy") == 0) {
            told->first = told->first > 0 ? told->first : row[2];
            told->last = row[2];
            told->elastic = row[4];
        }
    }
    return SCREE_OK;
}

static struct scree_world *start(const struct job_spec *job, struct told *told)
{
    struct scree_error error = {0};
    struct scree_world *world = NULL;
    const struct scree_sink sink = {.put = keep, .context = told};
    const struct scree_options options = {0};
    if (job_check(job, 0, &error) || scree_world_create(job, &options, &sink, &world, &error))
        fail_msg("%s", error.message);
    return world;
}

static void run(const struct job_spec *job, struct told *told)
{
    struct scree_error error = {0};
    *told = (struct told){.tau = told->tau};
    struct scree_world *world = start(job, told);
    while (!scree_world_progress(world).finished)
        if (scree_world_advance(world, 10000, &error))
            fail_msg("%s", error.message);
    assert_int_equal(scree_world_close(world, &error), SCREE_OK);
    scree_world_free(world);
}

/* A thousand frictionless grains of one size. */
static struct gas_params *setup(struct job_spec *job)
{
    job_defaults(job, scenario_find("gas"));
    struct gas_params *p = (struct gas_params *)(void *)job->params;
    p->n = 10;
    p->solid_fraction = FRACTION;
    p->temperature_m2_s2 = TEMPERATURE;
    job->material.mu_t = job->material.mu_r = job->material.kappa = job->material.beta_s = 0;
    job->material.radius_spread = 0;
    job->record.energy.every_s = 1e-3;
    return p;
}

/* Radial distribution at contact, Carnahan and Starling (1969). */
static double at_contact(double fraction)
{
    return (1 - fraction / 2) / pow(1 - fraction, 3);
}

/* A hundredth of the glass's stiffness: steps are 6.3 times as long, and a grain still spends but 0.5 % of its time in contact. */
static void soften(struct job_spec *job)
{
    job->material.young_Pa /= 100;
    job->time.step_s *= pow(100, 0.4);
}

/* S0-31. Enskog's rate of collisions, and those of impact speeds: relative velocities are normal with variance 2T a
 * component, impacts weighted by the approach: <dn^2> = <dt^2> = 4T, and dn above sqrt(4T ln 1000) once in a thousand.
 * Of 45,000 collisions the means are known to 0.5 %, that quantile to 1 %. */
static void elastic_gas_collides_as_kinetic_theory_says(void **state)
{
    (void)state;
    struct job_spec job;
    struct told told = {0};
    setup(&job);
    soften(&job);
    job.time.end_s = 1.03;
    job.record.collisions.on = true;
    job.record.collisions.from_s = 0.03; // the lattice is forgotten after some 10 ms
    run(&job, &told);
    double d = 2 * job.material.radius_m;
    double rate = 24 * FRACTION * at_contact(FRACTION) * sqrt(TEMPERATURE / M_PI) / d; // of one grain, 1/s
    assert_true(fabs(told.collisions / (0.5 * 1000 * rate * 1) - 1) < 0.03);
    assert_true(fabs(told.dn2 / told.collisions / (4 * TEMPERATURE) - 1) < 0.01);
    assert_true(fabs(told.dt2 / told.collisions / (4 * TEMPERATURE) - 1) < 0.01);
    assert_true(told.fast[0] > 1e-3 * told.collisions && told.fast[1] < 1e-3 * told.collisions);
    assert_true(fabs((told.last + told.elastic) / told.first - 1) < 1e-3);
}

static double restitution(const struct job_spec *gas, double speed)
{
    struct job_spec job;
    struct told told = {0};
    struct scree_error error = {0};
    struct scree_number numbers[SCREE_SUMMARY_MAX];
    job_defaults(&job, scenario_find("collision"));
    job.material = gas->material;
    ((struct collision_params *)(void *)job.params)->speed_m_s = speed;
    struct scree_world *world = start(&job, &told);
    while (!scree_world_progress(world).finished)
        if (scree_world_advance(world, 10000, &error))
            fail_msg("%s", error.message);
    size_t count = scree_world_summary(world, numbers);
    scree_world_free(world);
    for (size_t k = 0; k < count; k++)
        if (strcmp(numbers[k].name, "restitution") == 0)
            return numbers[k].value;
    fail_msg("no restitution");
    return 0;
}

/* B-16: T = T0 / (1 + t / t_e)^2, 1 / t_e = 4 (1 - e^2) phi g0 sqrt(T0) / (sqrt(pi) d),
 * with e at the speed that carries the loss: <dn^3> / <dn^2> = 3 sqrt(pi T) / 2. That is for an e that does not know
 * the speed. Here 1 - e^2 goes as its fifth root, and T as (1 + 1.2 t / t_e)^(-5/3) (Schwager and Poeschel 1998). */
static void inelastic_gas_cools_by_haffs_law(void **state)
{
    (void)state;
    struct job_spec job;
    struct told told = {0};
    setup(&job);
    job.time.end_s = 0.3;
    job.material.beta_s = 2.5e-7;
    run(&job, &told);
    double e = restitution(&job, 1.5 * sqrt(M_PI * TEMPERATURE)), d = 2 * job.material.radius_m;
    assert_true(e > 0.85 && e < 0.95);
    double rate = 4 * (1 - e * e) * FRACTION * at_contact(FRACTION) * sqrt(TEMPERATURE) / (sqrt(M_PI) * d);
    /* How much slower the grains are, by what is linear in time, against the law. */
    double slowed = (pow(told.first / told.last, 0.6) - 1) / 1.2;
    assert_true(told.last < 0.3 * told.first);
    assert_true(fabs(slowed / (rate * 0.3) - 1) < 0.02);
}

/* S0-32: impacts on a wall at rate A n sqrt(T / 2 pi), <J^2> = 8 m^2 T, so P_F = A n sqrt(T / 2 pi) 8 m^2 T zeta(f tau) with
 * tau of a sphere on a plane. n is that at the wall: centres have the box but for a radius at each wall, and the
 * pressure of a gas of spheres is 1 + 4 phi times that of points. Soft grains, for a long run in few steps. */
static void a_dilute_gas_drums_on_its_floor(void **state)
{
    (void)state;
    struct job_spec job;
    struct told told = {0};
    struct gas_params *p = setup(&job);
    p->box = GAS_WALLED;
    p->solid_fraction = 0.005;
    job.material.young_Pa = 7.4e4;
    job.time.step_s = 5e-5;
    job.time.end_s = 24;
    job.record.basal_force.on = job.record.spectrum.on = true;
    job.record.basal_force.every_s = 2e-4;
    job.record.spectrum.window_s = 2;
    job.record.spectrum.band_hz = 10;
    job.record.spectrum.fit_from_hz = PLATEAU_FROM;
    job.record.spectrum.fit_to_hz = 1000;
    job.record.energy.every_s = 1;
    double r = job.material.radius_m, mass = material_grain_mass(&job.material), speed = sqrt(M_PI * TEMPERATURE / 2);
    double stiff = 2.0 / 3 * job.material.young_Pa / (1 - job.material.poisson * job.material.poisson) * sqrt(r);
    told.tau = pow(mass / (stiff * sqrt(speed)), 0.4);
    run(&job, &told);
    double density = 1000 / (gas_edge(&job) - 2 * r) * (1 + 4 * p->solid_fraction); // times the area
    double plateau = density * sqrt(TEMPERATURE / (2 * M_PI)) * 8 * mass * mass * TEMPERATURE;
    assert_true(fabs(told.power / told.shape / plateau - 1) < 0.05);
    assert_true(fabs((told.last + told.elastic) / told.first - 1) < 1e-3);
}

/* The start: exactly the temperature asked for, no momentum, nothing overlaps even where it is crowded. */
static void starts_with_its_temperature(void **state)
{
    (void)state;
    struct job_spec job;
    struct told told = {0};
    struct gas_params *p = setup(&job);
    p->solid_fraction = 0.4;
    job.time.end_s = 1e-6;
    job.record.energy.every_s = 2.5e-7;
    job.material.radius_spread = 0.05;
    run(&job, &told);
    double r = job.material.radius_m, mass = 1000 * job.material.density_kg_m3 * 4.0 / 3.0 * M_PI * r * r * r * (1 + 0.05 * 0.05);
    assert_true(fabs(told.first / (1.5 * mass * TEMPERATURE) - 1) < 0.02); // heavy grains need not be as hot as light ones
}

/* Grains that their cells cannot hold. */
static void crowding_is_refused(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error error = {0};
    struct gas_params *p = setup(&job);
    p->solid_fraction = 0.45;
    job.material.radius_spread = 0.3;
    assert_int_equal(job_check(&job, 0, &error), SCREE_INVALID);
    assert_non_null(strstr(error.message, "params.solid_fraction"));
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(elastic_gas_collides_as_kinetic_theory_says),
        cmocka_unit_test(inelastic_gas_cools_by_haffs_law),
        cmocka_unit_test(a_dilute_gas_drums_on_its_floor),
        cmocka_unit_test(starts_with_its_temperature),
        cmocka_unit_test(crowding_is_refused),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
