/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Worlds from damaged images that were not refused are stepped: they go on or blow
 * up, and say so. */
#include "check.h"
#include "edited_image.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct world_image image;
    struct scree_world *world = NULL;
    struct scree_error err = {0};
    edited_image(data, size, &image);
    check_restore(world_image_restore(&image, &image_options, &image_sink, &world, &err), &err);
    if (world) {
        enum scree_status status = scree_world_advance(world, 3, &err);
        CHECK(status != SCREE_INTERNAL);
        scree_world_free(world);
    }
    world_image_free(&image);
    return 0;
}
