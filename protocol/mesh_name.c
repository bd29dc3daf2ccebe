/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See mesh_name.h. */
#include "protocol/mesh_name.h"

#include <sodium.h>

_Static_assert(MESH_NAME_MAX == 2 * crypto_hash_sha256_BYTES + 1, "a name holds the hash");

void mesh_name(const void *bytes, size_t size, char out[MESH_NAME_MAX])
{
    unsigned char hash[crypto_hash_sha256_BYTES];
    crypto_hash_sha256(hash, bytes, size);
    sodium_bin2hex(out, MESH_NAME_MAX, hash, sizeof hash);
}
