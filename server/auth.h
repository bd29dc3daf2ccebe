/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Who may connect. So far only the owner of a 0700 directory, through ipc. */
#ifndef SCREE_SERVER_AUTH_H
#define SCREE_SERVER_AUTH_H

#include "base/status.h"

/* Refuses every endpoint that is not ipc://: TCP without encryption and
 * authentication lets anybody in and exhausts memory. */
enum scree_status auth_check_endpoint(const char *endpoint, struct scree_error *err);

/* Makes the runtime directory with mode 0700, or accepts one that is ours and has it. */
enum scree_status auth_runtime_dir(const char *path, struct scree_error *err);

#endif
