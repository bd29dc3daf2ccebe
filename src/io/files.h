/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Files that are whole or not there, and on disk when that is said. */
#ifndef SCREE_IO_FILES_H
#define SCREE_IO_FILES_H

#include <stddef.h>

#include "base/status.h"

/* Writes `bytes` to `part`, flushes it, and renames it to `path` on the same file system. SCREE_IO names the file. */
enum scree_status files_put(const char *part, const char *path, const void *bytes, size_t size, struct scree_error *err);

/* Brings to disk that `path` has its place in its folder. */
enum scree_status files_settle(const char *path, struct scree_error *err);

/* Brings the closed file `part` to disk, renames it to `path` on the same file system, and settles that. */
enum scree_status files_into_place(const char *part, const char *path, struct scree_error *err);

#endif
