/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A checksum over a whole file, kept in HDF5's user block at its head, so that a
 * file that lost or changed a single bit is refused before it is parsed. */
#ifndef SCREE_IO_SEAL_H
#define SCREE_IO_SEAL_H

#include <stdio.h>

#include "base/status.h"

enum { SEAL_BYTES = 512 }; // of the user block

/* Writes the checksum of all that follows the block into it. */
enum scree_status seal_write(const char *path, struct scree_error *err);

/* SCREE_CORRUPT when length or checksum differ, SCREE_IO when the file cannot be read. */
enum scree_status seal_check(const char *path, struct scree_error *err);
/* The same of a file that is open, at its start; the path is for messages. */
enum scree_status seal_check_file(FILE *file, const char *path, struct scree_error *err);

#endif
