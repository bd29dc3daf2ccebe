/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What stands behind scree_checkpoint_read, once the seal is sound. */
#ifndef SCREE_IO_CHECKPOINT_H
#define SCREE_IO_CHECKPOINT_H

#include <hdf5.h>

#include "world/image.h"

/* The image in an open file, of that job, by this build; SCREE_CORRUPT otherwise. `path` is for messages.
 * To be released with world_image_free whatever is returned. */
enum scree_status checkpoint_read_image(hid_t file, const char *path, const struct job_spec *job, struct world_image *image,
                                        struct scree_error *err);

#endif
