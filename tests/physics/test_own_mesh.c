/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Scenario `chute` on a mesh out of a file: the built chute, written as a file and read back, is the same apparatus to the bit;
 * what is no apparatus is refused by its triangle. */
#include "unit.h"

#include <stdio.h>
#include <unistd.h>

#include "scenario/fragments.h"
#include "scenario/scenario.h"

static const char name[] = "00112233445566778899aabbccddeeff00112233445566778899aabbccddeeff";
static char folder[] = "/tmp/scree-mesh-XXXXXX", path[128];

static struct chute_params *params(struct job_spec *job)
{
    return (struct chute_params *)(void *)job->params;
}

static struct job_spec own_job(void)
{
    struct job_spec job;
    job_defaults(&job, scenario_find("chute"));
    params(&job)->mass_g = 3;
    params(&job)->size_m = 3e-3;
    params(&job)->accelerator = ACCELERATOR_GATE; // so that matter by triangle counts
    params(&job)->mesh = (struct mesh_spec){.on = true, .unit_m = 1, .closed = true};
    memcpy(params(&job)->mesh.sha256, name, sizeof name);
    job.fragments.softening = 1000;
    job.time.step_s = 0.2 * fragment_rayleigh_time(&job.fragments, 3e-3 / 4);
    return job;
}

/* As OBJ, every digit. */
static void write_obj(const struct trimesh *mesh, double scale)
{
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    for (size_t v = 0; v < mesh->vertices; v++)
        fprintf(file, "v %.17g %.17g %.17g\n", scale * mesh->vertex[v][0], scale * mesh->vertex[v][1], scale * mesh->vertex[v][2]);
    for (size_t t = 0; t < mesh->triangles; t++)
        fprintf(file, "f %u %u %u\n", mesh->corner[t][0] + 1, mesh->corner[t][1] + 1, mesh->corner[t][2] + 1);
    assert_int_equal(fclose(file), 0);
}

static void write_chute(const struct job_spec *job, double scale)
{
    const struct chute chute = fragments_chute(job);
    struct trimesh *mesh = NULL;
    uint8_t *upslope = NULL;
    assert_int_equal(chute_mesh(&chute, &mesh, &upslope, NULL), SCREE_OK);
    write_obj(mesh, scale);
    trimesh_free(mesh);
    free(upslope);
}

static enum scree_status build(const struct job_spec *job, struct dem **dem, struct scree_error *error)
{
    enum scree_status status = job_check(job, 0, error);
    const struct scenario_means means = {.threads = 1, .meshes = folder};
    return status ? status : scenario_implementation("chute")->build(job, &means, dem, error);
}

static uint64_t hash_after(const struct job_spec *job, uint64_t steps)
{
    struct scree_error error = {0};
    struct dem *dem = NULL;
    must(build(job, &dem, &error), &error);
    must(dem_advance(dem, steps, &error), &error);
    uint64_t hash = dem_hash(dem);
    dem_free(dem);
    return hash;
}

/* 12,000 steps: from the gate over the join into the curve. */
static void a_file_of_the_built_chute_is_that_chute(void **state)
{
    (void)state;
    struct job_spec own = own_job(), built = own;
    params(&own)->mesh.closed = false;
    params(&built)->mesh.on = false;
    write_chute(&built, 1);
    uint64_t hash = hash_after(&own, 12000);
    assert_true(hash == hash_after(&built, 12000));
    params(&own)->accelerator = ACCELERATOR_CHUTE;
    assert_true(hash != hash_after(&own, 12000));
}

static void refused(const struct job_spec *job, const char *at, const char *message, const char *hint)
{
    const struct scenario_means means = {.threads = 1, .meshes = folder};
    struct scree_error error = {0}, built = {0};
    struct dem *dem = NULL;
    enum scree_status status = job_check(job, 0, &error);
    if (!status)
        status = scenario_implementation("chute")->check(job, &means, &error);
    assert_int_equal(status, SCREE_INVALID);
    assert_int_equal(build(job, &dem, &built), SCREE_INVALID); // says the same
    assert_string_equal(error.message, built.message);
    assert_string_equal(error.path, at);
    if (!strstr(error.message, message) || !strstr(error.hint, hint))
        fail_msg("\"%s\" (%s)", error.message, error.hint);
}

static void what_is_no_apparatus_is_refused(void **state)
{
    (void)state;
    struct job_spec job = own_job();
    struct mesh_spec *mesh = &params(&job)->mesh;
    write_chute(&job, 1);
    refused(&job, "params.mesh", "params.mesh: the mesh is open: triangle ", "params.mesh.closed: false");
    mesh->closed = false;
    mesh->unit_m = 0.001;
    refused(&job, "params.mesh", "m: not below -0.1577, 0, 0.4577 m", "params.mesh.unit_m");
    write_chute(&job, 1e5);
    mesh->unit_m = 1;
    refused(&job, "params.mesh", "it reaches over x -2.07e+04..1.404e+05", "0.001 for millimetres");
    mesh->sha256[0] = 'f';
    refused(&job, "params.mesh.sha256", "there is no mesh f01122334455... here", "params.mesh.file");
    mesh->sha256[0] = 'F';
    refused(&job, "params.mesh.sha256", "64 digits 0..9, a..f are expected", "params.mesh.file");
    mesh->sha256[0] = 0;
    refused(&job, "params.mesh.sha256", "The name of one is missing", "params.mesh.file");
}

static int enter(void **state)
{
    (void)state;
    if (!mkdtemp(folder))
        return -1;
    snprintf(path, sizeof path, "%s/%s", folder, name);
    return 0;
}

static int leave(void **state)
{
    (void)state;
    return unlink(path) || rmdir(folder);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(a_file_of_the_built_chute_is_that_chute),
        cmocka_unit_test(what_is_no_apparatus_is_refused),
    };
    return cmocka_run_group_tests(tests, enter, leave);
}
