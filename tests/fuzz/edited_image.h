/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Damaged images of worlds. An input says which world's image is taken (its first
 * byte) and how it is edited: nine bytes an edit, of an element, a bit, an array's
 * length, type or name. */
#ifndef TEST_FUZZ_EDITED_IMAGE_H
#define TEST_FUZZ_EDITED_IMAGE_H

#include "scree.h"
#include "world/image.h"

/* Streams go nowhere, one thread. */
extern const struct scree_sink image_sink;
extern const struct scree_options image_options;

/* To be released with world_image_free. */
void edited_image(const uint8_t *data, size_t size, struct world_image *out);
/* What a restore may say of it: SCREE_OK, or a refusal with words. */
void check_restore(enum scree_status status, const struct scree_error *err);

#endif
