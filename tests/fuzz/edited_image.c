/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See edited_image.h. Worlds of every kind, as small as they come. */
#include "edited_image.h"

#include "check.h"
#include "protocol/job_json.h"

enum { EDIT_BYTES = 9, EDITS_MAX = 64, WORLDS = 6 };

static const struct {
    const char *spec;
    unsigned share; // of 256 values of the first byte: worlds that take long to restore come up less often
    uint64_t steps;
} worlds[WORLDS] = {
    {"{\"scenario\": \"incline\", \"params\": {\"nx\": 3, \"ny\": 3, \"nz\": 1}, \"stop\": {\"when\": []},"
     " \"record\": {\"basal_force\": {\"every_s\": 2.5e-5, \"chunk\": 16}}}",
     64, 2000},
    {"{\"scenario\": \"collision\"}", 64, 20},
    {"{\"scenario\": \"gas\", \"params\": {\"n\": 2, \"box\": \"walled\"}, \"record\": {\"collisions\": {\"chunk\": 16}, "
     "\"energy\": "
     "{}}}",
     48, 2000},
    {"{\"scenario\": \"settle\", \"params\": {\"count\": 2, \"length_m\": 0.03, \"width_m\": 0.03}, \"record\": {\"basal_force\": "
     "{\"chunk\": 16}}}",
     48, 20000},
    {"{\"scenario\": \"tilt\", \"params\": {\"cells_x\": 2, \"cells_y\": 1, \"cells_z\": 3, \"continuum\": {\"points\": 2}}}", 30,
     3},
    {"{\"scenario\": \"chute\", \"params\": {\"mass_g\": 0.05, \"space_mass_g\": 2, \"run_m\": 0.01, \"gate_m\": 0.02, "
     "\"flatness\": 0.1, \"accelerator\": "
     "\"gate\"}}",
     2, 2000},
};
static struct world_image images[WORLDS];

static enum scree_status swallow(void *context, const struct scree_chunk *chunk, struct scree_error *err)
{
    (void)context, (void)err;
    CHECK(chunk->rows < 1u << 20);
    return SCREE_OK;
}
const struct scree_sink image_sink = {.put = swallow};
const struct scree_options image_options = {.threads = 1};

static void *copy_of(const void *data, size_t bytes)
{
    void *copy = malloc(bytes ? bytes : 1);
    CHECK(copy != NULL);
    if (bytes)
        memcpy(copy, data, bytes);
    return copy;
}

/* Of a running world, with arrays of their exact size, so that a sanitizer sees the first byte read behind one. */
static void make_image(int k)
{
    struct scree_error err = {0};
    struct job_spec job;
    struct scree_world *world;
    struct world_image taken;
    cJSON *json;
    if (json_read(worlds[k].spec, strlen(worlds[k].spec), "spec", &json, &err) || job_decode(json, &job, &err) ||
        scree_world_create(&job, &image_options, &image_sink, &world, &err) || scree_world_advance(world, worlds[k].steps, &err) ||
        world_image_take(world, &taken, &err)) {
        fprintf(stderr, "world %d: %s\n", k, err.message);
        abort();
    }
    cJSON_Delete(json);
    images[k] = taken;
    for (size_t a = 0; a < taken.count; a++)
        images[k].arrays[a].data = copy_of(taken.arrays[a].data, taken.arrays[a].count * world_array_size(taken.arrays[a].type));
    images[k].owned_count = 0;
    world_image_free(&taken);
    scree_world_free(world);
}

/* The image's own elements of an array, which until now may be those of `images`. */
static unsigned char *own(struct world_image *image, struct world_array *array, size_t bytes)
{
    size_t held = array->count * world_array_size(array->type), o = 0;
    unsigned char *fresh = calloc(bytes ? bytes : 1, 1);
    CHECK(fresh != NULL);
    memcpy(fresh, array->data, held < bytes ? held : bytes);
    while (o < image->owned_count && image->owned[o] != array->data)
        o++;
    if (o == image->owned_count)
        image->owned_count++;
    else
        free(image->owned[o]);
    image->owned[o] = fresh;
    array->data = fresh;
    return fresh;
}

/* Gives an array another number of elements or another type, in a buffer that just holds it. */
static void reshape(struct world_image *image, struct world_array *array, enum world_array_type type, size_t count)
{
    own(image, array, count * world_array_size(type));
    array->type = type;
    array->count = count;
}

static void edit(struct world_image *image, const uint8_t *at)
{
    struct world_array *array = &image->arrays[at[1] % image->count];
    size_t size = world_array_size(array->type), place = (size_t)(at[2] | at[3] << 8), held = array->count * size;
    double real = (at[4] - 128.0) * (at[5] > 200 ? 1e300 : at[5] > 100 ? 1e-9 : 1);
    switch (at[0] % 6) {
    case 0: // an element, as a number of its type
        if (array->count == 0)
            break;
        if (array->type == ARRAY_REAL)
            memcpy(own(image, array, held) + place % array->count * size, &real, size);
        else
            memcpy(own(image, array, held) + place % array->count * size, at + 4, size < 4 ? size : 4);
        break;
    case 1: // a bit
        if (array->count > 0)
            own(image, array, held)[place % held] ^= (unsigned char)(1u << at[4] % 8);
        break;
    case 2: // shorter or longer
        reshape(image, array, array->type, array->count + at[4] > 128 ? array->count + at[4] - 128 : 0);
        break;
    case 3: // of another type, the same bytes
        reshape(image, array, (enum world_array_type)(at[4] % 4), held / world_array_size(at[4] % 4));
        break;
    case 4: // of another name
        array->name[place % 8] = (char)('a' + at[4] % 26);
        break;
    default: // gone
        image->arrays[at[1] % image->count] = image->arrays[image->count - 1];
        image->count -= image->count > 1;
    }
}

void edited_image(const uint8_t *data, size_t size, struct world_image *out)
{
    unsigned left = size ? data[0] : 0;
    int k = 0;
    for (; k < WORLDS - 1 && left >= worlds[k].share; k++)
        left -= worlds[k].share;
    if (!images[k].count)
        make_image(k);
    *out = images[k];
    for (size_t at = 1, edits = 0; at + EDIT_BYTES <= size && edits < EDITS_MAX; at += EDIT_BYTES, edits++)
        edit(out, data + at);
}

void check_restore(enum scree_status status, const struct scree_error *err)
{
    CHECK(!status || status == SCREE_CORRUPT || status == SCREE_NO_MEMORY || status == SCREE_INVALID || status == SCREE_BLOWUP);
    if (status)
        check_text(err->message);
}
