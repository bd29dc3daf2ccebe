/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See seal.h. The sum is a 64-bit multiply-xor hash over words: it finds any
 * damage by chance; it is no defence against a forger. */
#include "io/seal.h"

#include <errno.h>
#include <inttypes.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/memory.h"

struct seal {
    uint64_t bytes, hash;
};

/* Of what follows in the file. */
static enum scree_status seal_measure(FILE *file, struct seal *seal)
{
    enum { PIECE = 1 << 16 };
    uint64_t *words = memory_rows(PIECE / sizeof *words, sizeof *words);
    enum scree_status status = words ? SCREE_OK : SCREE_NO_MEMORY;
    *seal = (struct seal){0, 1};
    for (size_t read = PIECE; !status && read == PIECE;) {
        memset(words, 0, PIECE); // what a last piece lacks counts as zeros; its length is in the seal
        read = fread(words, 1, PIECE, file);
        for (size_t k = 0; k < (read + 7) / 8; k++) {
            seal->hash = (seal->hash ^ words[k]) * 0x9e3779b97f4a7c15u;
            seal->hash ^= seal->hash >> 29;
        }
        seal->bytes += read;
        if (ferror(file))
            status = SCREE_IO;
    }
    free(words);
    return status;
}

enum scree_status seal_write(const char *path, struct scree_error *err)
{
    char block[SEAL_BYTES] = "";
    struct seal seal = {0};
    FILE *file = fopen(path, "r+b");
    if (!file)
        return scree_fail(err, SCREE_IO, "", "cannot open %s: %s", path, strerror(errno));
    enum scree_status status = fseek(file, SEAL_BYTES, SEEK_SET) ? SCREE_IO : seal_measure(file, &seal);
    snprintf(block, sizeof block, "scree seal 1 %" PRIu64 " %016" PRIx64 "\n", seal.bytes, seal.hash);
    if (!status && (fseek(file, 0, SEEK_SET) != 0 || fwrite(block, 1, sizeof block, file) != sizeof block))
        status = SCREE_IO;
    if (fclose(file) != 0 && !status)
        status = SCREE_IO;
    return status ? scree_fail(err, status, "", "cannot seal %s: %s", path, strerror(errno)) : SCREE_OK;
}

enum scree_status seal_check_file(FILE *file, const char *path, struct scree_error *err)
{
    char block[SEAL_BYTES] = "", expect[SEAL_BYTES] = "";
    struct seal seal;
    bool whole = fread(block, 1, sizeof block, file) == sizeof block;
    enum scree_status status = seal_measure(file, &seal);
    if (status)
        return scree_fail(err, status, "", "cannot read %s: %s", path, strerror(errno));
    snprintf(expect, sizeof expect, "scree seal 1 %" PRIu64 " %016" PRIx64 "\n", seal.bytes, seal.hash);
    if (!whole || memcmp(block, expect, sizeof block) != 0)
        return scree_fail(err, SCREE_CORRUPT, "", "%s is cut short or damaged: its checksum is wrong", path);
    return SCREE_OK;
}

enum scree_status seal_check(const char *path, struct scree_error *err)
{
    FILE *file = fopen(path, "rb");
    if (!file)
        return scree_fail(err, SCREE_IO, "", "cannot open %s: %s", path, strerror(errno));
    enum scree_status status = seal_check_file(file, path, err);
    fclose(file);
    return status;
}
