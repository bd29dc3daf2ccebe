/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The mesh that a spec names by its file. What runs is in the spec: the file is read here, the spec says the hash of its bytes,
 * and the daemon, which may be on another machine, is given the bytes before the spec. */
#ifndef SCREE_CLIENT_MESH_FILE_H
#define SCREE_CLIENT_MESH_FILE_H

#include "link.h"
#include "protocol/mesh_name.h"

struct mesh_file {
    char *bytes; // NULL: the spec names none; owned
    size_t size;
    char name[MESH_NAME_MAX];
};

/* Of a job's JSON, or a study's: reads params.mesh.file, seen from the folder of `spec` ("-": from here), and puts
 * params.mesh.sha256 beside it. A file that is too large or cannot be read is refused. */
enum scree_status mesh_file_read(cJSON *json, const char *spec, struct mesh_file *out, struct scree_error *err);
void mesh_file_free(struct mesh_file *file);

/* Gives it to the daemon, which refuses what is no mesh; nothing to do without one. */
enum outcome mesh_file_send(const struct mesh_file *file, struct link *link, struct scree_error *err);

#endif
