/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The reader of a world's state, behind a checkpoint's seal and in a fork: whatever
 * an image's arrays hold, it is refused or it is a world. What steps make of such a
 * world is fuzz_steps. */
#include "check.h"
#include "edited_image.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct world_image image;
    struct scree_world *world = NULL;
    struct scree_error err = {0};
    edited_image(data, size, &image);
    check_restore(world_image_restore(&image, &image_options, &image_sink, &world, &err), &err);
    scree_world_free(world);
    world_image_free(&image);
    return 0;
}
