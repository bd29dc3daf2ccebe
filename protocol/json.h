/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Strict JSON in, exact JSON out, around cJSON.
 *
 * cJSON 1.7.15 accepts duplicate keys, `01`, `1e400`, invalid UTF-8 and trailing
 * text, and prints 0.30000000000000004 as 0.3. json_read therefore checks the
 * grammar of RFC 8259 itself before cJSON builds the tree; json_real writes 17
 * significant digits. */
#ifndef SCREE_PROTOCOL_JSON_H
#define SCREE_PROTOCOL_JSON_H

#include <cjson/cJSON.h>
#include <stdbool.h>
#include <stddef.h>

#include "base/status.h"

enum { JSON_DEPTH_MAX = 32, JSON_BYTES_MAX = 1 << 20 };

/* Parses `size` bytes that must be one JSON value and nothing else. Refused, with
 * line and column in the message: bad grammar, invalid UTF-8, a duplicate key
 * (with its path), a number that is not finite as a double, depth above
 * JSON_DEPTH_MAX, more than JSON_BYTES_MAX bytes. The caller frees *out with
 * cJSON_Delete. `name` is what the message calls the text ("job.json"). */
enum scree_status json_read(const char *text, size_t size, const char *name, cJSON **out, struct scree_error *err);

/* The same from a file; SCREE_IO says why it could not be read. */
enum scree_status json_read_file(const char *path, cJSON **out, struct scree_error *err);

/* A number that reads back to the same bits; integers up to 2^53 without fraction. */
cJSON *json_real(double value);

/* Whether a tree of this thread has lacked memory since the last call: it is valid then, but not whole. */
bool json_starved(void);
/* How often trees of this thread have lacked memory. What will be read again must be whole, since a key that is not there
 * has its default then: */
unsigned long json_lacked(void);
/* `json`; NULL, and `json` freed, if memory has lacked since json_lacked() was `before`. */
cJSON *json_whole(cJSON *json, unsigned long before);
/* Such a tree as text on one line, and freed; the text is the caller's, NULL where memory lacked. */
char *json_print_whole(cJSON *json, unsigned long before);

/* Adds under a key; on lack of memory the tree stays valid without it. */
void json_put(cJSON *object, const char *key, cJSON *item);
void json_put_real(cJSON *object, const char *key, double value);
void json_put_int(cJSON *object, const char *key, long long value);
void json_put_text(cJSON *object, const char *key, const char *text);
void json_put_bool(cJSON *object, const char *key, bool value);

/* Case-sensitive look-ups; NULL, the fallback or false when absent or of another type. */
const cJSON *json_get(const cJSON *object, const char *key);
const char *json_text(const cJSON *object, const char *key);
double json_number(const cJSON *object, const char *key, double fallback);
bool json_bool(const cJSON *object, const char *key, bool fallback);

/* The tree as text, on one line or indented; freed with free(). Every number reads
 * back to the same bits, those of a tree from json_read too. NULL on lack of memory. */
char *json_print(const cJSON *tree, bool pretty);

#endif
