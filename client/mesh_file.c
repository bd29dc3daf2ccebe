/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See mesh_file.h. */
#include "mesh_file.h"

#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "protocol/frame.h"

/* params.mesh of a job, or of the job of a study; NULL where there is none that names a file and nothing else. */
static cJSON *named_mesh(cJSON *json)
{
    cJSON *job = cJSON_GetObjectItemCaseSensitive(json, "job");
    cJSON *params = cJSON_GetObjectItemCaseSensitive(job ? job : json, "params");
    cJSON *mesh = cJSON_GetObjectItemCaseSensitive(params, "mesh");
    return json_text(mesh, "file") && !json_get(mesh, "sha256") ? mesh : NULL;
}

static enum scree_status find_path(const char *file, const char *spec, char path[PATH_MAX], struct scree_error *err)
{
    const char *slash = *file == '/' ? NULL : strrchr(spec, '/');
    int folder = slash ? (int)(slash - spec) + 1 : 0;
    if (snprintf(path, PATH_MAX, "%.*s%s", folder, spec, file) < PATH_MAX)
        return SCREE_OK;
    return scree_fail(err, SCREE_INVALID, "params.mesh.file", "params.mesh.file: the path is too long");
}

enum scree_status mesh_file_read(cJSON *json, const char *spec, struct mesh_file *out, struct scree_error *err)
{
    cJSON *mesh = named_mesh(json);
    char path[PATH_MAX];
    *out = (struct mesh_file){.bytes = NULL};
    if (!mesh)
        return SCREE_OK;
    enum scree_status status = find_path(json_text(mesh, "file"), spec, path, err);
    if (status)
        return status;
    FILE *file = fopen(path, "rbe");
    if (!file)
        return scree_fail(err, SCREE_INVALID, "params.mesh.file", "params.mesh.file: cannot open %s: %s", path, strerror(errno));
    if (!(out->bytes = malloc(MESH_BYTES_MAX + 1)))
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory for the mesh %s", path);
    else if ((out->size = fread(out->bytes, 1, MESH_BYTES_MAX + 1, file)) > MESH_BYTES_MAX) {
        status = scree_fail(err, SCREE_INVALID, "params.mesh.file", "params.mesh.file: %s is above %d bytes", path, MESH_BYTES_MAX);
        scree_hint(err, "that is %d triangles of binary STL: a decimated mesh says as much to grains", (MESH_BYTES_MAX - 84) / 50);
    } else if (ferror(file))
        status = scree_fail(err, SCREE_INVALID, "params.mesh.file", "params.mesh.file: cannot read %s", path);
    fclose(file);
    if (status) {
        mesh_file_free(out);
        return status;
    }
    mesh_name(out->bytes, out->size, out->name);
    json_put_text(mesh, "sha256", out->name);
    return SCREE_OK;
}

void mesh_file_free(struct mesh_file *file)
{
    free(file->bytes);
    file->bytes = NULL;
}

enum outcome mesh_file_send(const struct mesh_file *file, struct link *link, struct scree_error *err)
{
    if (!file->bytes)
        return OUTCOME_DONE;
    char *text = malloc(4 * ((file->size + 2) / 3) + 1);
    cJSON *body = text ? cJSON_CreateObject() : NULL, *result = NULL;
    if (!body) {
        free(text);
        return outcome_fail(err, OUTCOME_FAILED, "no memory to send the mesh");
    }
    base64_encode(file->bytes, file->size, text);
    json_put_text(body, "data", text);
    free(text);
    enum outcome outcome = link_request(link, "mesh", body, &result, err);
    const char *name = outcome ? NULL : json_text(result, "sha256");
    if (!outcome && (!name || strcmp(name, file->name) != 0))
        outcome = outcome_fail(err, OUTCOME_FAILED, "the daemon calls the mesh by another name than its hash");
    cJSON_Delete(result);
    return outcome;
}
