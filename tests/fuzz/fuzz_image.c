/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A world's image, as a checkpoint brings it back: whatever its arrays hold, it is
 * refused or it steps. (Behind the seal a file cannot change by accident; this is
 * for images that were sealed damaged, and for forks.) The input is a list of edits, nine
 * bytes each, to the arrays of an image that was taken of a running world. */
#include "check.h"
#include "protocol/job_json.h"
#include "scree.h"
#include "world/image.h"

enum { EDIT_BYTES = 9, EDITS_MAX = 64, WORLDS = 2 };

static const char *const specs[WORLDS] = {"{\"scenario\": \"incline\", \"params\": {\"nx\": 3, \"ny\": 3, \"nz\": 1}, \"time\": "
                                          "{\"end_s\": 0.5}, \"stop\": {\"when\": []},"
                                          " \"record\": {\"basal_force\": {\"every_s\": 2.5e-5, \"chunk\": 16}}}",
                                          "{\"scenario\": \"collision\"}"};
static struct world_image images[WORLDS];

static enum scree_status swallow(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    (void)context, (void)err;
    CHECK(chunk->rows < 1u << 20);
    return SCREE_OK;
}
static const struct scree_sink sink = {.put = swallow};
static const struct scree_options options = {.threads = 1};

/* A copy of the image with arrays of their exact size, so that a sanitizer sees the first byte read behind one. */
static void copy_image(const struct world_image *from, struct world_image *to)
{
    *to = *from;
    to->owned_count = 0;
    for (size_t k = 0; k < from->count; k++) {
        size_t bytes = from->arrays[k].count * world_array_size(from->arrays[k].type);
        void *copy = malloc(bytes ? bytes : 1);
        CHECK(copy != NULL);
        if (bytes)
            memcpy(copy, from->arrays[k].data, bytes);
        to->arrays[k].data = copy;
        to->owned[to->owned_count++] = copy;
    }
}

static void make_images(void)
{
    for (int k = 0; k < WORLDS; k++) {
        struct scree_error err = {0};
        struct job_spec job;
        struct scree_world *world;
        struct world_image taken;
        cJSON *json;
        CHECK(json_read(specs[k], strlen(specs[k]), "spec", &json, &err) == SCREE_OK);
        CHECK(job_decode(json, &job, &err) == SCREE_OK);
        cJSON_Delete(json);
        CHECK(scree_world_create(&job, &options, &sink, &world, &err) == SCREE_OK);
        CHECK(scree_world_advance(world, k == 0 ? 2000 : 20, &err) == SCREE_OK);
        CHECK(world_image_take(world, &taken, &err) == SCREE_OK);
        copy_image(&taken, &images[k]);
        world_image_free(&taken);
        scree_world_free(world);
    }
}

/* Gives an array another number of elements or another type, in a buffer that just holds it. */
static void reshape(struct world_image *image, struct world_array *array, enum world_array_type type, size_t count)
{
    size_t held = array->count * world_array_size(array->type), bytes = count * world_array_size(type);
    unsigned char *fresh = calloc(bytes ? bytes : 1, 1);
    CHECK(fresh != NULL);
    memcpy(fresh, array->data, held < bytes ? held : bytes);
    for (size_t k = 0; k < image->owned_count; k++)
        if (image->owned[k] == array->data) {
            free(image->owned[k]);
            image->owned[k] = fresh;
        }
    array->data = fresh;
    array->type = type;
    array->count = count;
}

static void edit(struct world_image *image, const uint8_t *at)
{
    struct world_array *array = &image->arrays[at[1] % image->count];
    size_t size = world_array_size(array->type), place = (size_t)(at[2] | at[3] << 8);
    double real = (at[4] - 128.0) * (at[5] > 200 ? 1e300 : at[5] > 100 ? 1e-9 : 1);
    unsigned char *bytes = (unsigned char *)array->data;
    switch (at[0] % 6) {
    case 0: // an element, as a number of its type
        if (array->count == 0)
            break;
        bytes += place % array->count * size;
        if (array->type == ARRAY_REAL)
            memcpy(bytes, &real, size);
        else
            memcpy(bytes, at + 4, size < 4 ? size : 4);
        break;
    case 1: // a bit
        if (array->count > 0)
            bytes[place % (array->count * size)] ^= (unsigned char)(1u << at[4] % 8);
        break;
    case 2: // shorter or longer
        reshape(image, array, array->type, array->count + at[4] > 128 ? array->count + at[4] - 128 : 0);
        break;
    case 3: // of another type, the same bytes
        reshape(image, array, (enum world_array_type)(at[4] % 4), array->count * size / world_array_size(at[4] % 4));
        break;
    case 4: // of another name
        array->name[place % 8] = (char)('a' + at[4] % 26);
        break;
    default: // gone
        image->arrays[at[1] % image->count] = image->arrays[image->count - 1];
        image->count -= image->count > 1;
    }
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct world_image image;
    struct scree_world *world = NULL;
    struct scree_error err = {0};
    if (!images[0].count)
        make_images();
    if (size < 1)
        return 0;
    copy_image(&images[data[0] % WORLDS], &image);
    for (size_t at = 1, edits = 0; at + EDIT_BYTES <= size && edits < EDITS_MAX; at += EDIT_BYTES, edits++)
        edit(&image, data + at);
    enum scree_status status = world_image_restore(&image, &options, &sink, &world, &err);
    if (status) {
        CHECK(status == SCREE_CORRUPT || status == SCREE_NO_MEMORY || status == SCREE_INVALID || status == SCREE_BLOWUP);
        check_text(err.message);
    } else {
        status = scree_world_advance(world, 3, &err);
        CHECK(status != SCREE_INTERNAL);
        scree_world_free(world);
    }
    world_image_free(&image);
    return 0;
}
