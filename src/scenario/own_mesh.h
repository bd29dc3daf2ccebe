/* SPDX-License-Identifier: GPL-3.0-or-later */
/* An apparatus of the user's own: the mesh that a job of scenario `chute` names, in place of the built chute. */
#ifndef SCREE_SCENARIO_OWN_MESH_H
#define SCREE_SCENARIO_OWN_MESH_H

#include "geom/trimesh.h"
#include "scenario/scenario.h"

/* The mesh out of the folder of meshes, in metres, and which of its triangles lie upslope of x = 0, where the accelerator is.
 * Refuses one that is not there, is open where it must not be, or lies elsewhere than the flow. Both are owned by the caller. */
enum scree_status own_mesh_read(const struct job_spec *job, const struct scenario_means *means, struct trimesh **out,
                                uint8_t **upslope, struct scree_error *err);

/* Whether own_mesh_read would; nothing to say of a job without such a mesh. */
enum scree_status own_mesh_check(const struct job_spec *job, const struct scenario_means *means, struct scree_error *err);

#endif
