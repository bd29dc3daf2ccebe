/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Checkpoint files. Whatever bytes of one change, the seal must say so: it is all
 * that stands between a disk's faults and HDF5, which is no reader of broken files.
 * One input in sixteen, by its first byte, looks behind the seal, at files that are
 * sound as HDF5 and yet no checkpoints: arrays of other types, ranks, lengths and
 * names, another header. Those are refused, or they are worlds. An edit is five bytes. */
#include <hdf5.h>
#include <unistd.h>

#include "check.h"
#include "edited_image.h"
#include "io/checkpoint.h"
#include "io/seal.h"

enum { EDIT_BYTES = 5, EDITS_MAX = 64, BEHIND_THE_SEAL = 16 };

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

/* ---- behind the seal ---- */

/* Elements that checkpoints have, and others. */
static hid_t type_for(uint8_t choice)
{
    switch (choice % 8) {
    case 0:
        return H5Tcopy(H5T_NATIVE_DOUBLE);
    case 1:
        return H5Tcopy(H5T_NATIVE_UINT32);
    case 2:
        return H5Tcopy(H5T_NATIVE_UINT64);
    case 3:
        return H5Tcopy(H5T_NATIVE_UINT8);
    case 4:
        return H5Tcopy(H5T_NATIVE_FLOAT);
    case 5:
        return H5Tcopy(H5T_NATIVE_INT16);
    case 6:
        return H5Tcreate(H5T_COMPOUND, 8);
    default:
        return H5Tcopy(H5T_C_S1);
    }
}

static hid_t space_for(uint8_t choice, uint8_t size)
{
    const hsize_t one[] = {size}, two[] = {size, 3}, huge[] = {1ull << 40};
    switch (choice % 8) {
    case 0:
        return H5Screate(H5S_SCALAR);
    case 1:
        return H5Screate(H5S_NULL);
    case 2:
        return H5Screate_simple(2, two, NULL);
    case 3: // of elements that nobody has written, and that take no room in the file
        return H5Screate_simple(1, huge, NULL);
    default:
        return H5Screate_simple(1, one, NULL);
    }
}

static void replace_array(hid_t arrays, const uint8_t *edit)
{
    char name[64] = "";
    H5G_info_t info;
    if (H5Gget_info(arrays, &info) < 0 || info.nlinks == 0)
        return;
    H5Lget_name_by_idx(arrays, ".", H5_INDEX_NAME, H5_ITER_INC, edit[1] % info.nlinks, name, sizeof name, H5P_DEFAULT);
    H5Ldelete(arrays, name, H5P_DEFAULT);
    if (edit[2] % 4 == 0)
        name[edit[2] / 4 % 8] = edit[2] % 8 ? 'x' : 0;
    if (edit[2] % 32 == 1) // no array at all
        H5Gclose(H5Gcreate2(arrays, *name ? name : "g", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    if (edit[2] % 32 <= 2 || !*name)
        return;
    hid_t type = type_for(edit[3]), space = space_for(edit[3] / 8, edit[4]), list = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_alloc_time(list, H5D_ALLOC_TIME_LATE);
    H5Dclose(H5Dcreate2(arrays, name, type, space, H5P_DEFAULT, list, H5P_DEFAULT));
    H5Pclose(list);
    H5Sclose(space);
    H5Tclose(type);
}

static void replace_attribute(hid_t header, const uint8_t *edit)
{
    static const char *const names[] = {"version", "build", "job"};
    const char *name = names[edit[1] % 3], text[200] = "x";
    const int64_t number = edit[4];
    H5Adelete(header, name);
    if (edit[2] % 4 == 0)
        return;
    hid_t type = edit[2] % 4 == 1 ? H5Tcopy(H5T_NATIVE_INT64) : H5Tcopy(H5T_C_S1), space = space_for(edit[3] & 1, 1);
    if (edit[2] % 4 > 1)
        H5Tset_size(type, edit[2] % 4 == 2 ? H5T_VARIABLE : 1u + edit[4] % sizeof text);
    hid_t made = H5Acreate2(header, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
    if (edit[2] % 4 != 2)
        H5Awrite(made, type, edit[2] % 4 == 1 ? (const void *)&number : text);
    H5Aclose(made);
    H5Sclose(space);
    H5Tclose(type);
}

/* A sound file that lies in memory, with other things in it. */
static hid_t edited_checkpoint(const uint8_t *data, size_t size)
{
    hid_t access = H5Pcreate(H5P_FILE_ACCESS);
    H5Pset_fapl_core(access, 1 << 16, false);
    H5Pset_file_image(access, sound.bytes, sound.size);
    hid_t file = H5Fopen("checkpoint", H5F_ACC_RDWR, access);
    CHECK(file >= 0);
    H5Pclose(access);
    hid_t arrays = H5Gopen2(file, "/arrays", H5P_DEFAULT), header = H5Gopen2(file, "/checkpoint", H5P_DEFAULT);
    for (size_t at = 1, edits = 0; at + EDIT_BYTES <= size && edits < EDITS_MAX; at += EDIT_BYTES, edits++)
        if (data[at] % 8 == 0)
            replace_attribute(header, data + at);
        else
            replace_array(arrays, data + at);
    H5Gclose(header);
    H5Gclose(arrays);
    return file;
}

/* As scree_checkpoint_read does once the seal is sound. */
static void read_checkpoint(hid_t file)
{
    struct world_image image = {.job = sound.job};
    struct scree_world *world = NULL;
    struct scree_error err = {0};
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
    if (size > 0 && data[0] % BEHIND_THE_SEAL == 0) {
        read_checkpoint(edited_checkpoint(data, size));
        return 0;
    }
    uint8_t *file = edited_file(data, size, &length);
    check_seal(file, length);
    free(file);
    return 0;
}
