/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world as named arrays: what a checkpoint stores and a fork copies. */
#ifndef SCREE_WORLD_IMAGE_H
#define SCREE_WORLD_IMAGE_H

#include "scree.h"

enum world_array_type { ARRAY_BYTES, ARRAY_U32, ARRAY_U64, ARRAY_REAL };

struct world_array {
    char name[40];
    enum world_array_type type;
    size_t count; // elements
    const void *data;
};
enum { WORLD_ARRAYS_MAX = 128 };

struct world_image {
    struct job_spec job;
    struct world_array arrays[WORLD_ARRAYS_MAX];
    size_t count;
    void *owned[WORLD_ARRAYS_MAX]; // released by world_image_free
    size_t owned_count;
};

size_t world_array_size(enum world_array_type type); // bytes an element

/* Arrays point into the world, which must not be advanced while the image is used. */
enum scree_status world_image_take(const struct scree_world *world, struct world_image *image, struct scree_error *err);
void world_image_free(struct world_image *image);

/* For those who fill images: an array that outlives it; a copy of `bytes` bytes that it owns. */
void world_image_add(struct world_image *image, const char *name, enum world_array_type type, size_t count, const void *data);
enum scree_status world_image_copy(struct world_image *image, const char *name, const void *data, size_t bytes,
                                   struct scree_error *err);

/* For those who read them: the array of that name, or NULL; the same if it has the type and so many elements, else NULL; the
 * refusal of an image in which `what` is not as it should be. */
const struct world_array *world_image_find(const struct world_image *image, const char *name);
void *world_image_need(const struct world_image *image, const char *name, enum world_array_type type, size_t count);
enum scree_status world_image_damaged(const char *what, struct scree_error *err);

/* The same with every array copied: the world may go on. */
struct scree_image {
    struct world_image image;
};

/* A world that goes on from the image, to the bit. */
enum scree_status world_image_restore(const struct world_image *image, const struct scree_options *options,
                                      const struct scree_sink *sink, struct scree_world **out, struct scree_error *err);

#endif
