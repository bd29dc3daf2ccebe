/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What goes into the frames of PROTOCOL.md: envelope, errors, chunk headers. No sockets here. */
#ifndef SCREE_PROTOCOL_FRAME_H
#define SCREE_PROTOCOL_FRAME_H

#include <stdint.h>

#include "protocol/json.h"

#define PROTOCOL_VERSION "SC1"
enum { PROTOCOL_ID_MAX = 64, PROTOCOL_FRAME_MAX = 1 << 20, PROTOCOL_CREDIT_MAX = 64 << 20 };

struct envelope {
    char id[PROTOCOL_ID_MAX + 1];
    char op[32];
};

/* True for 1..PROTOCOL_ID_MAX characters of [A-Za-z0-9._-]. */
bool protocol_id_valid(const char *id);

/* Reads a request header. */
enum scree_status envelope_read(const char *text, size_t size, struct envelope *out, struct scree_error *err);
cJSON *envelope_make(const char *id, const char *op);

/* Replies. `result` is taken over. */
cJSON *reply_ok(const char *id, cJSON *result);
cJSON *reply_error(const char *id, const char *code, const struct scree_error *error);
cJSON *error_json(const char *code, const struct scree_error *error);

/* Fills *error from the `error` object of a reply and returns its status. */
enum scree_status error_read(const cJSON *error_object, struct scree_error *error);

/* CRC-32C (Castagnoli), reflected, initial and final inversion: crc32c("123456789") is 0xe3069283. */
uint32_t crc32c(uint32_t crc, const void *data, size_t size);
/* The same without special instructions, for processors that lack them and for the test. */
uint32_t crc32c_plain(uint32_t crc, const void *data, size_t size);

/* A stream's running hash (PROTOCOL.md, "Streams"): up to and with a chunk, from that up to
 * the chunk before (0 before the first). */
uint64_t chunk_hash(uint64_t before, uint64_t seq, double t0_s, double dt_s, uint64_t rows, const void *payload, size_t bytes);

/* Text of the endpoints below a runtime directory, and the default directory
 * ($SCREE_RUNTIME, $XDG_RUNTIME_DIR/scree, /tmp/scree-UID). */
enum scree_status protocol_runtime_dir(char *out, size_t size, struct scree_error *err);
enum scree_status protocol_endpoint(const char *runtime_dir, const char *name, char *out, size_t size, struct scree_error *err);

/* Base64 of RFC 4648 for fetch_part. `out` holds 4 * ((size + 2) / 3) + 1; returns characters written. */
size_t base64_encode(const void *data, size_t size, char *out);
/* Returns bytes written, or SIZE_MAX if the text is not base64. */
size_t base64_decode(const char *text, size_t length, void *out);

#endif
