/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checkpoint files. The input is a list of edits of a sound one. Unless nothing was
 * changed, the seal must say so: it stands between what disks do and HDF5. One input
 * in sixteen, by its first byte, is read as if it had been sealed after the damage:
 * then it is refused, or it is a world. An edit is five bytes: what is done, where
 * (three bytes), and with what. */
#include <hdf5.h>
#include <unistd.h>

#include "check.h"
#include "edited_image.h"
#include "io/checkpoint.h"
#include "io/seal.h"

enum { EDIT_BYTES = 5, EDITS_MAX = 64, SEALED_AFTERWARDS = 16 };

static struct {
    struct job_spec job;
    uint8_t *bytes;
    size_t size;
} sound;

static void read_whole(const char *path)
{
    FILE *file = fopen(path, "rb");
    CHECK(file && fseek(file, 0, SEEK_END) == 0);
    sound.size = (size_t)ftell(file);
    rewind(file);
    sound.bytes = malloc(sound.size);
    CHECK(sound.bytes && fread(sound.bytes, 1, sound.size, file) == sound.size);
    fclose(file);
}

/* The checkpoint of a collision of two grains. */
static void make_sound(void)
{
    struct world_image image;
    struct scree_error err = {0};
    struct scree_world *world;
    char path[] = "/tmp/scree-fuzz-XXXXXX";
    int fd = mkstemp(path);
    CHECK(fd >= 0 && close(fd) == 0);
    edited_image(&(uint8_t){0x40}, 1, &image);
    sound.job = image.job;
    CHECK(world_image_restore(&image, &image_options, &image_sink, &world, &err) == SCREE_OK);
    CHECK(scree_checkpoint_write(world, path, &err) == SCREE_OK);
    scree_world_free(world);
    world_image_free(&image);
    read_whole(path);
    unlink(path);
    H5Eset_auto2(H5E_DEFAULT, NULL, NULL);
}

static uint8_t *edited_file(const uint8_t *data, size_t size, size_t *length)
{
    uint8_t *file = malloc(sound.size);
    CHECK(file != NULL);
    memcpy(file, sound.bytes, sound.size);
    *length = sound.size;
    for (size_t at = 1, edits = 0; at + EDIT_BYTES <= size && edits < EDITS_MAX; at += EDIT_BYTES, edits++) {
        size_t place = (size_t)(data[at + 1] | data[at + 2] << 8 | data[at + 3] << 16) % sound.size;
        switch (data[at] % 8) {
        case 0:
            *length = place + 1 < *length ? place + 1 : *length;
            break;
        case 1:
        case 2:
        case 3:
            file[place] ^= (uint8_t)(1u << data[at + 4] % 8);
            break;
        default:
            file[place] = data[at + 4];
        }
    }
    return file;
}

static void check_seal(uint8_t *bytes, size_t size)
{
    struct scree_error err = {0};
    FILE *file = fmemopen(bytes, size, "r");
    CHECK(file != NULL);
    enum scree_status status = seal_check_file(file, "a checkpoint", &err);
    bool same = size == sound.size && memcmp(bytes, sound.bytes, size) == 0;
    CHECK(status == (same ? SCREE_OK : SCREE_CORRUPT));
    fclose(file);
}

/* As scree_checkpoint_read does once the seal is sound, of a file that lies in memory. */
static void read_past_the_seal(uint8_t *bytes, size_t size)
{
    struct world_image image = {.job = sound.job};
    struct scree_world *world = NULL;
    struct scree_error err = {0};
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fapl_core(access, 1 << 16, false);
    H5Pset_file_image(access, bytes, size);
    hid_t file = H5Fopen("checkpoint", H5F_ACC_RDONLY, access);
    H5Pclose(access);
    if (file < 0)
        return;
    enum scree_status status = checkpoint_read_image(file, "a checkpoint", &sound.job, &image, &err);
    H5Fclose(file);
    if (!status)
        status = world_image_restore(&image, &image_options, &image_sink, &world, &err);
    check_restore(status, &err);
    scree_world_free(world);
    world_image_free(&image);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    size_t length;
    if (!sound.bytes)
        make_sound();
    uint8_t *file = edited_file(data, size, &length);
    if (size > 0 && data[0] % SEALED_AFTERWARDS == 0)
        read_past_the_seal(file, length);
    else
        check_seal(file, length);
    free(file);
    return 0;
}
