/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Envelopes, errors, checksums and endpoints of PROTOCOL.md. */
#include "protocol/frame.h"

#include <nmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

bool protocol_id_valid(const char *id)
{
    size_t length = id ? strlen(id) : 0;
    return length >= 1 && length <= PROTOCOL_ID_MAX &&
           strspn(id, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789._-") == length;
}

enum scree_status envelope_read(const char *text, size_t size, struct envelope *out, struct scree_error *err)
{
    cJSON *json = NULL;
    *out = (struct envelope){{0}, {0}};
    enum scree_status status = json_read(text, size, "header", &json, err);
    if (status)
        return status;
    const char *id = json_text(json, "id"), *op = json_text(json, "op");
    if (!protocol_id_valid(id))
        status = scree_fail(err, SCREE_INVALID, "id", "id: 1 to %d characters of [A-Za-z0-9._-] are expected", PROTOCOL_ID_MAX);
    else
        snprintf(out->id, sizeof out->id, "%s", id);
    if (!status && (!op || strlen(op) >= sizeof out->op))
        status = scree_fail(err, SCREE_INVALID, "op", "op: the name of an operation is expected");
    if (!status)
        snprintf(out->op, sizeof out->op, "%s", op);
    cJSON_Delete(json);
    return status;
}

cJSON *envelope_make(const char *id, const char *op)
{
    cJSON *json = cJSON_CreateObject();
    if (json) {
        json_put_text(json, "id", id);
        json_put_text(json, "op", op);
    }
    return json;
}

cJSON *reply_ok(const char *id, cJSON *result)
{
    cJSON *json = cJSON_CreateObject();
    if (!json) {
        cJSON_Delete(result);
        return NULL;
    }
    json_put_text(json, "id", id);
    json_put_bool(json, "ok", true);
    json_put(json, "result", result ? result : cJSON_CreateObject());
    return json;
}

cJSON *error_json(const char *code, const struct scree_error *error)
{
    cJSON *json = cJSON_CreateObject();
    if (json) {
        json_put_text(json, "code", code);
        json_put_text(json, "path", error->path);
        json_put_text(json, "message", error->message);
        json_put_text(json, "hint", error->hint);
    }
    return json;
}

cJSON *reply_error(const char *id, const char *code, const struct scree_error *error)
{
    json_starved(); // the failure itself may be one
    cJSON *json = cJSON_CreateObject();
    if (json) {
        json_put_text(json, "id", id);
        json_put_bool(json, "ok", false);
        json_put(json, "error", error_json(code, error));
    }
    return json;
}

enum scree_status error_read(const cJSON *error_object, struct scree_error *error)
{
    const char *code = json_text(error_object, "code"), *path = json_text(error_object, "path");
    const char *message = json_text(error_object, "message"), *hint = json_text(error_object, "hint");
    enum scree_status status = SCREE_INTERNAL;
    for (int s = SCREE_INVALID; s <= SCREE_INTERNAL; s++)
        if (code && strcmp(code, scree_status_word((enum scree_status)s)) == 0)
            status = (enum scree_status)s;
    if (code && strcmp(code, "bad_request") == 0)
        status = SCREE_INVALID;
    scree_fail(error, status, path, "%s", message ? message : "the daemon gave no reason");
    if (hint && *hint)
        scree_hint(error, "%s", hint);
    return status;
}

/* ---- CRC-32C ---- */

static uint32_t crc32c_table(uint32_t crc, const unsigned char *data, size_t size)
{
    static uint32_t table[256]; // filled alike by any thread that comes first
    if (!__atomic_load_n(&table[255], __ATOMIC_ACQUIRE)) {
        for (uint32_t k = 0; k < 256; k++) {
            uint32_t c = k;
            for (int bit = 0; bit < 8; bit++)
                c = c & 1 ? c >> 1 ^ 0x82f63b78u : c >> 1;
            __atomic_store_n(&table[k], c, __ATOMIC_RELEASE);
        }
    }
    while (size--)
        crc = __atomic_load_n(&table[(crc ^ *data++) & 0xff], __ATOMIC_RELAXED) ^ crc >> 8;
    return crc;
}

__attribute__((target("sse4.2"))) static uint32_t crc32c_sse(uint32_t crc, const unsigned char *data, size_t size)
{
    uint64_t wide = crc;
    for (; size >= 8; size -= 8, data += 8) {
        uint64_t word;
        memcpy(&word, data, sizeof word);
        wide = _mm_crc32_u64(wide, word);
    }
    crc = (uint32_t)wide;
    while (size--)
        crc = _mm_crc32_u8(crc, *data++);
    return crc;
}

uint32_t crc32c(uint32_t crc, const void *data, size_t size)
{
    return ~(__builtin_cpu_supports("sse4.2") ? crc32c_sse(~crc, data, size) : crc32c_table(~crc, data, size));
}

uint32_t crc32c_plain(uint32_t crc, const void *data, size_t size)
{
    return ~crc32c_table(~crc, data, size);
}

static uint64_t hash_word(uint64_t hash, uint64_t word)
{
    hash = (hash ^ word) * 0x9e3779b97f4a7c15u;
    return hash ^ hash >> 29;
}

static uint64_t bits_of(double value)
{
    uint64_t word;
    memcpy(&word, &value, sizeof word);
    return word;
}

uint64_t chunk_hash(uint64_t before, uint64_t seq, double t0_s, double dt_s, uint64_t rows, const void *payload, size_t bytes)
{
    uint64_t hash = hash_word(hash_word(before, seq), bits_of(t0_s)), word;
    hash = hash_word(hash_word(hash, bits_of(dt_s)), rows);
    for (const char *p = payload; bytes >= sizeof word; bytes -= sizeof word, p += sizeof word) {
        memcpy(&word, p, sizeof word);
        hash = hash_word(hash, word);
    }
    return hash;
}

/* ---- endpoints ---- */

enum scree_status protocol_runtime_dir(char *out, size_t size, struct scree_error *err)
{
    const char *own = getenv("SCREE_RUNTIME"), *session = getenv("XDG_RUNTIME_DIR");
    int length;
    if (own && *own)
        length = snprintf(out, size, "%s", own);
    else if (session && *session)
        length = snprintf(out, size, "%s/scree", session);
    else
        length = snprintf(out, size, "/tmp/scree-%u", (unsigned)getuid());
    if (length < 0 || (size_t)length >= size)
        return scree_fail(err, SCREE_INVALID, NULL, "the path of the runtime directory is too long");
    return SCREE_OK;
}

enum scree_status protocol_endpoint(const char *runtime_dir, const char *name, char *out, size_t size, struct scree_error *err)
{
    int length = snprintf(out, size, "ipc://%s/%s", runtime_dir, name);
    /* A Unix socket's path holds 107 characters. */
    if (length < 0 || (size_t)length >= size || length - 6 > 107)
        return scree_fail(err, SCREE_INVALID, NULL, "the path %s/%s is too long for a socket (107 characters)", runtime_dir, name);
    return SCREE_OK;
}

/* ---- base64 ---- */

static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";

size_t base64_encode(const void *data, size_t size, char *out)
{
    const unsigned char *in = data;
    char *p = out;
    for (size_t k = 0; k < size; k += 3) {
        size_t left = size - k;
        unsigned bits = (unsigned)in[k] << 16 | (left > 1 ? (unsigned)in[k + 1] << 8 : 0) | (left > 2 ? in[k + 2] : 0u);
        *p++ = digits[bits >> 18];
        *p++ = digits[bits >> 12 & 63];
        *p++ = left > 1 ? digits[bits >> 6 & 63] : '=';
        *p++ = left > 2 ? digits[bits & 63] : '=';
    }
    *p = 0;
    return (size_t)(p - out);
}

size_t base64_decode(const char *text, size_t length, void *out)
{
    unsigned char *p = out;
    if (length % 4)
        return SIZE_MAX;
    for (size_t k = 0; k < length; k += 4) {
        unsigned bits = 0;
        int padding = 0;
        for (size_t c = k; c < k + 4; c++) {
            const char *digit = text[c] ? strchr(digits, text[c]) : NULL;
            if (text[c] == '=' && k + 4 == length && c >= k + 2)
                padding++;
            else if (!digit || padding)
                return SIZE_MAX;
            bits = bits << 6 | (digit && !padding ? (unsigned)(digit - digits) : 0u);
        }
        if ((padding == 1 && bits & 0xff) || (padding == 2 && bits & 0xffff))
            return SIZE_MAX; // one text for one value: no bits may hide behind the last byte
        *p++ = (unsigned char)(bits >> 16);
        if (padding < 2)
            *p++ = (unsigned char)(bits >> 8);
        if (padding < 1)
            *p++ = (unsigned char)bits;
    }
    return (size_t)(p - (unsigned char *)out);
}
