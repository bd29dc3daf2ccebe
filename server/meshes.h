/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Meshes that users bring: files of the data folder's `meshes`, called by the SHA-256 of what is in them.
 *
 * A mesh is kept before it is acknowledged and never changes or goes, so that a job which names it can be run, replayed and
 * begun anew for as long as its journal lives. The same file brought again is the same mesh. */
#ifndef SCREE_SERVER_MESHES_H
#define SCREE_SERVER_MESHES_H

#include "config.h"
#include "protocol/json.h"
#include "scree.h"

enum { MESHES_MAX = 1024, MESHES_PATH_MAX = CONFIG_PATH_MAX + 16 };

void meshes_folder(const struct config *config, char out[MESHES_PATH_MAX]);

/* Keeps the mesh of `data`, the base64 of an STL or OBJ file, and answers with its name and what it is. What is not strictly
 * such a file, or no surface, is refused with its line or triangle. */
enum scree_status meshes_keep(const struct config *config, const cJSON *body, cJSON **result, struct scree_error *err);

/* scree_job_check by the meshes that are kept; `config` is a struct config. */
enum scree_status meshes_check_job(const struct job_spec *job, const void *config, struct scree_error *err);

#endif
