/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Tables, materials, checks and errors, without any JSON. */
#include "unit.h"

#include <math.h>
#include <stdio.h>

#include "base/rng.h"
#include "base/text.h"
#include "spec/spec.h"

/* ---- errors and texts ---- */

/* Callers that do not care pass NULL; the status must come back all the same. */
static void errors_may_be_ignored(void **state)
{
    (void)state;
    assert_int_equal(scree_fail(NULL, SCREE_IO, "a", "b"), SCREE_IO);
    scree_hint(NULL, "c");
}

/* A hint belongs to one error and must not cling to the next. */
static void a_new_error_clears_the_hint(void **state)
{
    (void)state;
    struct scree_error err;
    scree_fail(&err, SCREE_IO, NULL, "first");
    scree_hint(&err, "hint %d", 1);
    assert_string_equal(err.hint, "hint 1");
    scree_fail(&err, SCREE_BUSY, "p", "second");
    assert_error(&err, SCREE_BUSY, "p", "second");
    assert_string_equal(err.hint, "");
}

/* Messages quote strangers: an escape sequence in a key must not reach a terminal,
 * and a character cut in half must not make the reply invalid JSON. */
static void errors_are_fit_to_print(void **state)
{
    (void)state;
    struct scree_error err;
    scree_fail(&err, SCREE_INVALID, "a\nb", "x\x1b[2J\x7f\xc2\x9b \xc3\xa9 %.1s|", "\xc3\xa9");
    assert_error(&err, SCREE_INVALID, "a?b", "x?[2J?? \xc3\xa9 ?|");
    for (size_t shift = 0; shift < 4; shift++) {
        char text[2 * SCREE_MESSAGE_MAX];
        size_t size = 0;
        memset(text, 'a', shift);
        for (size = shift; size + 4 < sizeof text; size += 3)
            memcpy(text + size, "\xe2\x82\xac", 3);
        text[size] = 0;
        scree_fail(&err, SCREE_INVALID, text, "%s", text);
        const char *end = err.message + strlen(err.message);
        for (const char *p = err.message; p < end; p += text_utf8_length(p, end))
            assert_int_not_equal(text_utf8_length(p, end), 0);
    }
}

/* Codes on the wire: one word each, and none twice. */
static void status_words_differ(void **state)
{
    (void)state;
    for (int a = SCREE_OK; a <= SCREE_INTERNAL; a++)
        for (int b = SCREE_OK; b < a; b++)
            assert_string_not_equal(scree_status_word((enum scree_status)a), scree_status_word((enum scree_status)b));
    assert_string_equal(scree_status_word(SCREE_NOT_FOUND), "not_found");
    assert_string_equal(scree_status_word(SCREE_NO_MEMORY), "no_memory");
}

/* Refusals show what the user wrote, not its seventeen digits. */
static void numbers_are_shortest(void **state)
{
    (void)state;
    char text[TEXT_REAL_MAX];
    assert_string_equal(text_real(0.1, text), "0.1");
    assert_string_equal(text_real(0.1 + 0.2, text), "0.30000000000000004");
    assert_string_equal(text_real(1e-5, text), "1e-05");
    assert_string_equal(text_real(123456789, text), "123456789");
    assert_string_equal(text_real(NAN, text), "nan");
    assert_string_equal(text_real(-INFINITY, text), "-inf");
    struct rng rng = rng_start(1, 2);
    for (int k = 0; k < 50000; k++) {
        uint64_t bits = rng_next(&rng);
        double value;
        memcpy(&value, &bits, sizeof value);
        if (!isfinite(value))
            continue;
        double back = strtod(text_real(value, text), NULL);
        assert_memory_equal(&back, &value, sizeof value);
    }
}

/* ---- tables ---- */

static void check_table(const struct field_table *table, int depth)
{
    assert_true(depth < 4);
    for (size_t k = 0; k < table->count; k++) {
        const struct field *row = &table->fields[k];
        bool number = row->type == FIELD_REAL || row->type == FIELD_INT || row->type == FIELD_VEC3;
        assert_non_null(row->unit);
        assert_non_null(row->doc);
        assert_non_null(row->source);
        assert_true(strlen(row->name) > 0 && row->offset < table->size);
        assert_ptr_equal(field_find(table, row->name), row); // else a name stands twice
        if (number && !(row->min <= row->preset && row->preset <= row->max && row->min < row->max))
            fail_msg("%s: default %g is outside %g..%g", row->name, row->preset, row->min, row->max);
        if (row->type == FIELD_INT)
            assert_true(fabs(row->min) <= 9007199254740992.0 && row->max <= 9007199254740992.0);
        assert_int_equal(row->type == FIELD_ENUM || row->type == FIELD_FLAGS, row->choices != NULL);
        assert_int_equal(row->type == FIELD_GROUP || row->type == FIELD_SWITCH, row->table != NULL);
        if (row->table)
            check_table(row->table, depth + 1);
    }
}

/* A slip in a table is a slip in decoding, help, messages and the schema at once. */
static void tables_are_sound(void **state)
{
    (void)state;
    check_table(&job_table, 0);
    check_table(&material_table, 0);
    for (size_t k = 0; k < scenario_count; k++) {
        check_table(scenario_list[k]->params, 0);
        assert_true(scenario_list[k]->params->size <= SPEC_PARAMS_MAX);
        assert_ptr_equal(scenario_find(scenario_list[k]->name), scenario_list[k]);
        assert_non_null(material_preset_find(scenario_list[k]->material));
    }
    assert_null(scenario_find("Incline"));
    assert_null(material_preset_find(""));
}

/* Nobody should have to repair what we hand out. */
static void defaults_pass_every_check(void **state)
{
    (void)state;
    for (size_t k = 0; k < scenario_count; k++)
        for (size_t m = 0; m < material_preset_count; m++) {
            struct job_spec job;
            struct scree_error err = {0};
            job_defaults(&job, scenario_list[k]);
            if (material_preset_kind(&material_presets[m]) != scenario_material(scenario_list[k]))
                continue;
            memcpy(&job.material, material_preset_values(&material_presets[m]), scenario_material(scenario_list[k])->table->size);
            assert_string_equal(job.material.preset, material_presets[m].name);
            if (job_check(&job, 1e9, &err))
                fail_msg("%s, %s: %s", scenario_list[k]->name, material_presets[m].name, err.message);
        }
}

/* What a typo meant, and that a stranger gets no silly guess. */
static void nearest_names_are_meant(void **state)
{
    (void)state;
    const struct field_table *params = scenario_find("incline")->params;
    assert_string_equal(field_nearest(params, "slop_deg"), "slope_deg");
    assert_string_equal(field_nearest(params, "Slope_deg"), "slope_deg");
    assert_string_equal(field_nearest(params, "slope"), "slope_deg");
    assert_string_equal(field_nearest(params, "gravity"), "gravity_m_s2");
    assert_string_equal(field_nearest(&material_table, "young_pa"), "young_Pa");
    assert_null(field_nearest(params, "temperature"));
    assert_null(field_nearest(params, ""));
    char longest[200];
    memset(longest, 's', sizeof longest);
    longest[sizeof longest - 1] = 0;
    assert_null(field_nearest(params, longest));
    const char *const words[] = {"rest", "steady", NULL};
    assert_string_equal(word_nearest(words, "stedy"), "steady");
    assert_null(word_nearest(words, "accelerating"));
}

/* Steering names one value by its path. */
static void paths_resolve_to_values(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    const struct field *row;
    void *address;
    job_defaults(&job, scenario_find("incline"));
    assert_int_equal(field_resolve(&job_table, &job, "record.basal_force.every_s", &row, &address, &err), SCREE_OK);
    assert_ptr_equal(address, &job.record.basal_force.every_s);
    assert_string_equal(row->name, "every_s");
    assert_true(row->steerable);
    assert_int_equal(field_resolve(&job_table, &job, "seed", &row, &address, &err), SCREE_OK);
    assert_ptr_equal(address, &job.seed);
    assert_false(row->steerable);
    const struct {
        const char *path, *message;
    } bad[] = {
        {"record.basal_farce.every_s", "record.basal_farce.every_s: unknown key; did you mean \"basal_force\"?"},
        {"seed.x", "seed.x: \"seed\" has no parts"},
        {"", ": unknown key"},
        {"time.", "time.: unknown key"},
        {".seed", ".seed: unknown key"},
    };
    for (size_t k = 0; k < COUNT(bad); k++) {
        assert_int_equal(field_resolve(&job_table, &job, bad[k].path, &row, &address, &err), SCREE_INVALID);
        assert_error(&err, SCREE_INVALID, bad[k].path, bad[k].message);
    }
}

static void refused(const struct job_spec *job, double memory, enum scree_status status, const char *path, const char *message)
{
    struct scree_error err = {0};
    assert_int_equal(job_check(job, memory, &err), status);
    assert_error(&err, status, path, message);
}

/* What is taken at the end of a time is refused where the run is over before. */
static void records_must_fit_into_the_run(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, scenario_find("channel"));
    job.time.end_s = 0.4;
    job.record.profiles = (struct record_profiles){true, 1e-3, 0.5};
    refused(&job, 0, SCREE_INVALID, "record.profiles.frame_s",
            "record.profiles.frame_s: 0.5 s is longer than the run, which ends at 0.4 s");
    job.record.profiles.frame_s = 1e-4;
    refused(&job, 0, SCREE_INVALID, "record.profiles.frame_s",
            "record.profiles.frame_s: 0.0001 s is shorter than record.profiles.every_s = 0.001 s");
    job.record.profiles.frame_s = 0.4;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    job.record.collisions = (struct record_log){true, 4096, 0.5};
    refused(&job, 0, SCREE_INVALID, "record.collisions.from_s",
            "record.collisions.from_s: 0.5 s is longer than the run, which ends at 0.4 s");
    job.record.collisions.on = false;
    job.record.spectrum.on = true;
    job.record.spectrum.window_s = 0.5;
    refused(&job, 0, SCREE_INVALID, "record.spectrum.window_s",
            "record.spectrum.window_s: 0.5 s is longer than the run, which ends at 0.4 s");
    job.record.spectrum.window_s = 1e-4;
    refused(&job, 0, SCREE_INVALID, "record.spectrum.window_s",
            "record.spectrum.window_s: 0.0001 s holds 40 blocks of record.basal_force.every_s = 2.5e-06 s, and 8 segments need at "
            "least 72");
}

/* A job may be built or steered without JSON: its values are checked all the same. */
static void values_are_checked_in_place(void **state)
{
    (void)state;
    struct job_spec job;
    struct incline_params *p = (void *)job.params;
    struct collision_params *c = (void *)job.params;
    job_defaults(&job, scenario_find("incline"));
    p->slope_deg = NAN;
    refused(&job, 0, SCREE_INVALID, "params.slope_deg", "params.slope_deg: nan is outside 0..60 deg");
    p->slope_deg = nextafter(60, 61);
    refused(&job, 0, SCREE_INVALID, "params.slope_deg", "params.slope_deg: 60.00000000000001 is outside 0..60 deg");
    p->slope_deg = 60; // the range is closed
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    job.stop.when = 8;
    refused(&job, 0, SCREE_INVALID, "stop.when", "stop.when: there is no choice for the bits 0x8");
    job_defaults(&job, scenario_find("collision"));
    c->spin2_rad_s[1] = -2e6;
    refused(&job, 0, SCREE_INVALID, "params.spin2_rad_s[1]", "params.spin2_rad_s[1]: -2e+06 is outside -1e+06..1e+06 rad/s");
    c->spin2_rad_s[1] = 0;
    c->partner = 5;
    refused(&job, 0, SCREE_INVALID, "params.partner", "params.partner: there is no choice number 5");
}

/* The message for a domain of one grain says what the limit is about. */
static void a_tiny_domain_is_explained(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    job_defaults(&job, scenario_find("incline"));
    ((struct incline_params *)(void *)job.params)->ny = 1;
    assert_int_equal(job_check(&job, 0, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "params.ny", "params.ny: 1 is outside 2..4000 grain diameters");
    assert_string_equal(err.hint,
                        "ny: cross-slope length of the periodic domain: at least two grains, or a grain would touch itself");
}

/* ---- scenario checks ---- */

/* What ranges cannot say. */
static void scenarios_check_their_own_rules(void **state)
{
    (void)state;
    struct job_spec job;
    struct incline_params *p = (void *)job.params;
    struct collision_params *c = (void *)job.params;
    job_defaults(&job, scenario_find("incline"));
    job.record.contact.on = true;
    refused(&job, 0, SCREE_INVALID, "record.contact", "record.contact: is for scenario collision, where there is one contact");
    job_defaults(&job, scenario_find("incline"));
    p->nx = p->ny = 1000;
    p->nz = 31;
    refused(&job, 0, SCREE_INVALID, "params", "params: nx * ny * nz = 3.1e+07 grains are more than the 3e+07 that a world holds");
    refused(&job, 16e9, SCREE_NO_MEMORY, "params", "this world needs 32.5 GB of memory and 16 GB are to be had");
    job_defaults(&job, scenario_find("incline"));
    job.record.energy.every_s = 1e-9;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK); // it is off
    job.record.energy.on = true;
    refused(&job, 0, SCREE_INVALID, "record.energy.every_s", "record.energy.every_s: 1e-09 s is below the time step of 2.5e-07 s");
    job.record.energy.every_s = 0.5 * job.time.step_s; // rounds to one step
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    job_defaults(&job, scenario_find("collision"));
    c->tangential_m_s[2] = 0.25;
    refused(&job, 0, SCREE_INVALID, "params.tangential_m_s[2]",
            "params.tangential_m_s[2]: 0.25 m/s is not 0: z is the normal, and the velocity along it is speed_m_s");
}

/* Sizes for the estimate and the refusal. */
static void cost_counts_grains_and_steps(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    struct job_cost cost = job.scenario->cost(&job);
    assert_true(cost.moving == 1000 && cost.fixed == 150 && cost.bytes == 1150 * SPEC_BYTES_PER_GRAIN);
    assert_true(fabs(cost.steps - 8e7) <= 1); // 20 s in steps of 2.5e-7 s
    job_defaults(&job, scenario_find("collision"));
    cost = job.scenario->cost(&job);
    assert_true(cost.moving == 2 && cost.fixed == 0);
    ((struct collision_params *)(void *)job.params)->partner = PARTNER_PLANE;
    cost = job.scenario->cost(&job);
    assert_true(cost.moving == 1 && cost.fixed == 0);
}

/* Estimates of time are of the order of what was measured (tests/results): grain-steps a second of one core. */
static void cost_assumes_a_rate_of_each_kind(void **state)
{
    (void)state;
    static const struct {
        const char *scenario;
        double rate;
    } kinds[] = {{"incline", 3e7}, {"channel", 3e7}, {"chute", 1e7},    {"dam_break", 1e6}, {"hopper", 1e6},
                 {"settle", 1e6},  {"tilt", 2e6},    {"collapse", 2e6}, {"layer", 2e6}};
    for (size_t k = 0; k < COUNT(kinds); k++) {
        struct job_spec job;
        job_defaults(&job, scenario_find(kinds[k].scenario));
        const struct job_cost cost = job_cost(&job), plain = job.scenario->cost(&job);
        assert_true(cost.rate == kinds[k].rate && cost.moving == plain.moving && cost.steps == plain.steps);
        assert_true(job_cost_seconds(&cost) == plain.moving * plain.steps / kinds[k].rate && plain.moving > 0);
    }
}

/* ---- materials ---- */

/* Contact times of two free beads against numbers of the paper's equations by
 * quadrature (they include damping, which lengthens a contact by some 0.2 %). */
static void contact_time_matches_the_paper(void **state)
{
    (void)state;
    const struct material_spec *glass = &material_preset_find("glass-beads-2mm")->values;
    const double speed[] = {0.01, 0.14, 0.362, 1.2}, expected[] = {14.86e-6, 8.774e-6, 7.259e-6, 5.715e-6};
    for (size_t k = 0; k < COUNT(speed); k++)
        if (fabs(material_contact_time(glass, speed[k]) / expected[k] - 1) > 5e-3)
            fail_msg("%g m/s: %g s, not %g s", speed[k], material_contact_time(glass, speed[k]), expected[k]);
    struct material_spec foerster = material_preset_find("foerster-3mm")->values;
    assert_true(fabs(material_contact_time(&foerster, 1.2) / (3.218065 * 2.6877e-6) - 1) < 1e-4); // tau_F = 2.6877 us
}

/* Eqs 15 and 18 by hand, and the mass of a 2 mm bead. */
static void material_constants_are_those_of_the_paper(void **state)
{
    (void)state;
    const struct material_spec *glass = &material_preset_find("glass-beads-2mm")->values;
    assert_true(fabs(material_shear_modulus(glass) / 30.3279e9 - 1) < 1e-5);
    assert_true(fabs(material_torsion_friction(glass) - 0.139604) < 1e-6);
    assert_true(fabs(material_grain_mass(glass) / 1.059764e-5 - 1) < 1e-6);
}

/* The published steps are accepted; what blows up is not. Two grains of 2 mm at
 * 1.5 us were seen to gain energy, at 2.5 us to fly apart. */
static void the_step_is_bounded_by_the_stiffness(void **state)
{
    (void)state;
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    const double good[] = {5e-8, 2.5e-7, 3.377e-7, 5.75e-7, 1e-6};
    for (size_t k = 0; k < COUNT(good); k++) {
        job.time.step_s = good[k];
        assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    }
    job.time.step_s = 1e-5;
    struct scree_error err;
    assert_int_equal(job_check(&job, 0, &err), SCREE_INVALID);
    assert_error(&err, SCREE_INVALID, "time.step_s",
                 "time.step_s: 1e-05 s is above the largest stable step 1.03e-06 s for this material: a contact at 1 m/s lasts "
                 "5.61e-06 s and its stiffest motion needs 6 steps of it");
    assert_string_equal(err.hint, "shorten time.step_s, or soften material.young_Pa: the step grows as its power -2/5");
    job.time.step_s = 1.5e-6;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_INVALID);
}

/* How the bound moves: with E^(-2/5), with size, with speed^(-1/5), and it knows the smallest grains. */
static void the_step_scales_with_the_material(void **state)
{
    (void)state;
    struct material_spec glass = material_preset_find("glass-beads-2mm")->values, other = glass;
    glass.beta_s = other.beta_s = 0;
    double step = material_stable_step(&glass, 1);
    other.young_Pa = glass.young_Pa / 1000;
    assert_true(fabs(material_stable_step(&other, 1) / step / pow(1000, 0.4) - 1) < 1e-12);
    other = glass;
    other.radius_m *= 3;
    assert_true(fabs(material_stable_step(&other, 1) / step / 3 - 1) < 1e-12);
    assert_true(fabs(material_stable_step(&glass, 32) / step * 2 - 1) < 1e-12);
    struct job_spec job;
    job_defaults(&job, scenario_find("incline"));
    job.time.step_s = 1e-6;
    job.material.radius_spread = 0.5;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_INVALID);
}

/* Strong damping is integrated explicitly and has a bound of its own, 2 / (beta w^2). */
static void strong_damping_shortens_the_step(void **state)
{
    (void)state;
    struct job_spec job;
    struct scree_error err;
    job_defaults(&job, scenario_find("incline"));
    struct material_spec m = job.material, twice = m;
    m.beta_s = 1e-3;
    twice.beta_s = 2e-3;
    assert_true(material_stable_step(&m, 1) < 1e-2 * material_stable_step(&job.material, 1));
    assert_true(fabs(material_stable_step(&m, 1) / material_stable_step(&twice, 1) - 2) < 1e-4);
    job.material.beta_s = 1e-3;
    assert_int_equal(job_check(&job, 0, &err), SCREE_INVALID);
    assert_non_null(strstr(err.message, "for this material, whose damping beta_s = 0.001 s is stronger than its springs"));
}

/* In a collision the contact is that of the two radii in question, not of the material's. */
static void a_collision_goes_by_its_smaller_grain(void **state)
{
    (void)state;
    struct job_spec job;
    struct collision_params *c = (void *)job.params;
    job_defaults(&job, scenario_find("collision"));
    job.time.step_s = 1e-6;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    c->radius2_m = 1e-5;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_INVALID);
    c->partner = PARTNER_PLANE; // has no radius
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
    c->radius1_m = 1e-2; // a large one against one of the material's
    c->radius2_m = 0;
    c->partner = PARTNER_SPHERE;
    job.time.step_s = 5e-6;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_INVALID);
    c->radius2_m = 1e-2;
    assert_int_equal(job_check(&job, 0, NULL), SCREE_OK);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(errors_may_be_ignored),
        cmocka_unit_test(a_new_error_clears_the_hint),
        cmocka_unit_test(errors_are_fit_to_print),
        cmocka_unit_test(status_words_differ),
        cmocka_unit_test(numbers_are_shortest),
        cmocka_unit_test(tables_are_sound),
        cmocka_unit_test(defaults_pass_every_check),
        cmocka_unit_test(nearest_names_are_meant),
        cmocka_unit_test(paths_resolve_to_values),
        cmocka_unit_test(records_must_fit_into_the_run),
        cmocka_unit_test(values_are_checked_in_place),
        cmocka_unit_test(a_tiny_domain_is_explained),
        cmocka_unit_test(scenarios_check_their_own_rules),
        cmocka_unit_test(cost_counts_grains_and_steps),
        cmocka_unit_test(cost_assumes_a_rate_of_each_kind),
        cmocka_unit_test(contact_time_matches_the_paper),
        cmocka_unit_test(material_constants_are_those_of_the_paper),
        cmocka_unit_test(the_step_is_bounded_by_the_stiffness),
        cmocka_unit_test(the_step_scales_with_the_material),
        cmocka_unit_test(strong_damping_shortens_the_step),
        cmocka_unit_test(a_collision_goes_by_its_smaller_grain),
    };
    return cmocka_run_group_tests_name("spec", tests, NULL, NULL);
}
