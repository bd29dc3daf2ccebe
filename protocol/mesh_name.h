/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What a mesh is called by: SHA-256 of its file's bytes, so that client and daemon come to the same name, and nobody can put
 * another mesh in its place. */
#ifndef SCREE_PROTOCOL_MESH_NAME_H
#define SCREE_PROTOCOL_MESH_NAME_H

#include <stddef.h>

#include "spec/spec.h"

/* Bytes of a mesh's file: their base64 fits a frame. */
enum { MESH_BYTES_MAX = 768000 };

void mesh_name(const void *bytes, size_t size, char out[MESH_NAME_MAX]);

#endif
