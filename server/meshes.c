/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See meshes.h. */
#include "meshes.h"

#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "io/files.h"
#include "protocol/frame.h"
#include "protocol/mesh_name.h"

void meshes_folder(const struct config *config, char out[MESHES_PATH_MAX])
{
    snprintf(out, MESHES_PATH_MAX, "%s/meshes", config->data);
}

static size_t count_files(const char *folder)
{
    size_t count = 0;
    DIR *files = opendir(folder);
    for (const struct dirent *file; files && (file = readdir(files));)
        count += *file->d_name != '.';
    if (files)
        closedir(files);
    return count;
}

static enum scree_status keep(const struct config *config, const char *name, const char *bytes, size_t size,
                              struct scree_error *err)
{
    char folder[MESHES_PATH_MAX], path[MESHES_PATH_MAX + MESH_NAME_MAX], part[MESHES_PATH_MAX + 8];
    meshes_folder(config, folder);
    snprintf(path, sizeof path, "%s/%s", folder, name);
    snprintf(part, sizeof part, "%s/.part", folder);
    if (access(path, F_OK) == 0)
        return SCREE_OK;
    if (mkdir(folder, 0700) != 0 && errno != EEXIST)
        return scree_fail(err, SCREE_IO, "", "cannot make %s: %s", folder, strerror(errno));
    if (count_files(folder) >= MESHES_MAX)
        return scree_fail(err, SCREE_BUSY, "", "there are %d meshes here already, as many as are kept", MESHES_MAX);
    enum scree_status status = files_put(part, path, bytes, size, err);
    if (!status)
        status = files_settle(path, err);
    return status ? status : files_settle(folder, err); // which may be new
}

static cJSON *vector(const double x[3])
{
    cJSON *array = cJSON_CreateArray();
    for (int a = 0; a < 3; a++)
        cJSON_AddItemToArray(array, json_real(x[a]));
    return array;
}

enum scree_status meshes_keep(const struct config *config, const cJSON *body, cJSON **result, struct scree_error *err)
{
    const char *text = json_text(body, "data");
    size_t length = text ? strlen(text) : 0;
    char name[MESH_NAME_MAX], *bytes = malloc(length / 4 * 3 + 3);
    struct scree_mesh mesh;
    if (!bytes)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for a mesh");
    size_t size = text ? base64_decode(text, length, bytes) : SIZE_MAX;
    enum scree_status status;
    if (size == SIZE_MAX)
        status = scree_fail(err, SCREE_INVALID, "data", "data: the base64 of an STL or OBJ file is expected");
    else if (size > MESH_BYTES_MAX)
        status = scree_fail(err, SCREE_INVALID, "data", "data: %zu bytes are above %d", size, MESH_BYTES_MAX);
    else if (!(status = scree_mesh_look(bytes, size, &mesh, err))) {
        mesh_name(bytes, size, name);
        status = keep(config, name, bytes, size, err);
    }
    free(bytes);
    if (status)
        return status;
    *result = cJSON_CreateObject();
    json_put_text(*result, "sha256", name);
    json_put_int(*result, "vertices", (long long)mesh.vertices);
    json_put_int(*result, "triangles", (long long)mesh.triangles);
    json_put_bool(*result, "closed", mesh.closed);
    json_put(*result, "low", vector(mesh.low));
    json_put(*result, "high", vector(mesh.high));
    return SCREE_OK;
}

enum scree_status meshes_check_job(const struct job_spec *job, const void *config, struct scree_error *err)
{
    char folder[MESHES_PATH_MAX];
    meshes_folder(config, folder);
    return scree_job_check(job, &(struct scree_options){.meshes = folder}, err);
}
