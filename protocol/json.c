/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A strict grammar check in front of cJSON, and numbers that survive it.
 *
 * The checker walks the text once by RFC 8259 and builds nothing. Duplicate keys
 * are looked for in the tree that cJSON builds then, where escapes are resolved.
 * Printing goes through a copy whose numbers are text already. */
#include "protocol/json.h"

#include <ctype.h>
#include <errno.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/text.h"

struct scan {
    const unsigned char *text, *end, *at;
    const char *name;
    struct scree_error *err;
};

static enum scree_status refuse(struct scan *s, const char *what)
{
    size_t line = 1, column = 1;
    for (const unsigned char *p = s->text; p < s->at && p < s->end; p++) {
        if (*p == '\n') {
            line++;
            column = 1;
        } else if ((*p & 0xc0) != 0x80) { // columns count characters, not bytes
            column++;
        }
    }
    return scree_fail(s->err, SCREE_INVALID, "", "%s:%zu:%zu: %s", s->name, line, column, what);
}

static void skip_space(struct scan *s)
{
    while (s->at < s->end && (*s->at == ' ' || *s->at == '\t' || *s->at == '\n' || *s->at == '\r'))
        s->at++;
}

static int peek(const struct scan *s)
{
    return s->at < s->end ? *s->at : -1;
}

/* Four hexadecimal digits at p, or -1. */
static long hex4(const unsigned char *p, const unsigned char *end)
{
    long value = 0;
    if (end - p < 4)
        return -1;
    for (int k = 0; k < 4; k++) {
        int c = tolower(p[k]);
        if (!isxdigit(c))
            return -1;
        value = value * 16 + (c <= '9' ? c - '0' : c - 'a' + 10);
    }
    return value;
}

static enum scree_status scan_escape(struct scan *s)
{
    int c = s->at + 1 < s->end ? s->at[1] : -1;
    if (c != 'u') {
        if (c < 0 || !strchr("\"\\/bfnrt", c) || c == 0)
            return refuse(s, "unknown escape in a string");
        s->at += 2;
        return SCREE_OK;
    }
    long high = hex4(s->at + 2, s->end);
    if (high < 0)
        return refuse(s, "\\u wants four hexadecimal digits");
    if (high == 0)
        return refuse(s, "\\u0000 is not accepted in a string");
    if (high >= 0xdc00 && high <= 0xdfff)
        return refuse(s, "half of a surrogate pair in a string");
    s->at += 6;
    if (high < 0xd800 || high > 0xdbff)
        return SCREE_OK;
    long low = s->end - s->at >= 6 && s->at[0] == '\\' && s->at[1] == 'u' ? hex4(s->at + 2, s->end) : -1;
    if (low < 0xdc00 || low > 0xdfff)
        return refuse(s, "half of a surrogate pair in a string");
    s->at += 6;
    return SCREE_OK;
}

static enum scree_status scan_string(struct scan *s)
{
    for (s->at++;;) {
        int c = peek(s);
        if (c < 0)
            return refuse(s, "a string has no end");
        if (c == '"') {
            s->at++;
            return SCREE_OK;
        }
        if (c < 0x20)
            return refuse(s, "a control character in a string");
        if (c == '\\') {
            enum scree_status status = scan_escape(s);
            if (status)
                return status;
            continue;
        }
        size_t length = text_utf8_length((const char *)s->at, (const char *)s->end);
        if (length == 0)
            return refuse(s, "invalid UTF-8");
        s->at += length;
    }
}

static enum scree_status scan_digits(struct scan *s)
{
    if (!isdigit(peek(s)))
        return refuse(s, "a digit is missing in a number");
    while (isdigit(peek(s)))
        s->at++;
    return SCREE_OK;
}

static enum scree_status scan_number(struct scan *s)
{
    const unsigned char *start = s->at;
    enum scree_status status;
    if (peek(s) == '-')
        s->at++;
    if (peek(s) == '0') {
        s->at++;
        if (isdigit(peek(s)))
            return refuse(s, "a number starts with a superfluous 0");
    } else if ((status = scan_digits(s))) {
        return status;
    }
    if (peek(s) == '.') {
        s->at++;
        if ((status = scan_digits(s)))
            return status;
    }
    if (peek(s) == 'e' || peek(s) == 'E') {
        s->at++;
        if (peek(s) == '+' || peek(s) == '-')
            s->at++;
        if ((status = scan_digits(s)))
            return status;
    }
    size_t length = (size_t)(s->at - start);
    char copy[64];
    if (length >= sizeof copy) {
        s->at = start;
        return refuse(s, "a number of more than 63 characters");
    }
    memcpy(copy, start, length);
    copy[length] = 0;
    if (!isfinite(strtod(copy, NULL))) {
        s->at = start;
        return refuse(s, "a number beyond the range of double precision");
    }
    return SCREE_OK;
}

static enum scree_status scan_word(struct scan *s)
{
    static const char *const words[] = {"true", "false", "null"};
    for (size_t k = 0; k < 3; k++) {
        size_t length = strlen(words[k]);
        if ((size_t)(s->end - s->at) >= length && memcmp(s->at, words[k], length) == 0) {
            s->at += length;
            return SCREE_OK;
        }
    }
    static const char *const not_numbers[] = {"NaN", "nan", "Infinity", "inf"};
    for (size_t k = 0; k < 4; k++)
        if ((size_t)(s->end - s->at) >= strlen(not_numbers[k]) && memcmp(s->at, not_numbers[k], strlen(not_numbers[k])) == 0)
            return refuse(s, "NaN and Infinity are not numbers in JSON");
    return refuse(s, peek(s) < 0 ? "a value is missing at the end" : "a value is expected");
}

static enum scree_status scan_value(struct scan *s, int depth);

/* Elements or members up to the closing bracket. */
static enum scree_status scan_inside(struct scan *s, int depth, int close)
{
    enum scree_status status;
    s->at++;
    skip_space(s);
    if (peek(s) == close) {
        s->at++;
        return SCREE_OK;
    }
    for (;;) {
        skip_space(s);
        if (close == '}') {
            if (peek(s) != '"')
                return refuse(s, "a key in double quotes is expected");
            if ((status = scan_string(s)))
                return status;
            skip_space(s);
            if (peek(s) != ':')
                return refuse(s, "\":\" is expected behind a key");
            s->at++;
        }
        if ((status = scan_value(s, depth + 1)))
            return status;
        skip_space(s);
        if (peek(s) == close) {
            s->at++;
            return SCREE_OK;
        }
        if (peek(s) != ',')
            return refuse(s, close == '}' ? "\",\" or \"}\" is expected" : "\",\" or \"]\" is expected");
        s->at++;
    }
}

static enum scree_status scan_value(struct scan *s, int depth)
{
    skip_space(s);
    int c = peek(s);
    if ((c == '{' || c == '[') && depth >= JSON_DEPTH_MAX)
        return refuse(s, "nested too deeply");
    if ((c == '{' || c == '[') && depth >= JSON_DEPTH_MAX)
        return refuse(s, "nested too deeply");
    if (c == '{' || c == '[')
        return scan_inside(s, depth, c == '{' ? '}' : ']');
    if (c == '"')
        return scan_string(s);
    if (c == '-' && s->end - s->at > 1 && !isdigit(s->at[1]))
        return refuse(s, strchr("INin", s->at[1]) && s->at[1] ? "NaN and Infinity are not numbers in JSON"
                                                              : "a digit is missing in a number");
    if (c == '-' || isdigit(c))
        return scan_number(s);
    return scan_word(s);
}

/* ---- duplicate keys ---- */

static int by_text(const void *a, const void *b)
{
    return strcmp(*(const char *const *)a, *(const char *const *)b);
}

static enum scree_status find_duplicates(const cJSON *tree, const char *path, const char *name, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    size_t count = 0, k = 0;
    for (const cJSON *item = tree->child; item; item = item->next)
        count++;
    const char **keys = NULL;
    if (cJSON_IsObject(tree) && count > 1) {
        keys = malloc(count * sizeof *keys);
        if (!keys)
            return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to read %s", name);
        for (const cJSON *item = tree->child; item; item = item->next)
            keys[k++] = item->string;
        qsort(keys, count, sizeof *keys, by_text);
        for (k = 1; k < count && !status; k++)
            if (strcmp(keys[k - 1], keys[k]) == 0) {
                char full[SCREE_PATH_MAX];
                snprintf(full, sizeof full, "%s%s%s", path, *path ? "." : "", keys[k]);
                status = scree_fail(err, SCREE_INVALID, full, "%s: the key \"%s\" stands twice", full, keys[k]);
            }
        free(keys);
    }
    size_t index = 0;
    for (const cJSON *item = tree->child; item && !status; item = item->next, index++) {
        char full[SCREE_PATH_MAX];
        if (cJSON_IsObject(tree))
            snprintf(full, sizeof full, "%s%s%s", path, *path ? "." : "", item->string);
        else
            snprintf(full, sizeof full, "%s[%zu]", path, index);
        if (item->child)
            status = find_duplicates(item, full, name, err);
    }
    return status;
}

enum scree_status json_read(const char *text, size_t size, const char *name, cJSON **out, struct scree_error *err)
{
    struct scan s = {.text = (const unsigned char *)text,
                     .end = (const unsigned char *)text + size,
                     .at = (const unsigned char *)text,
                     .name = name,
                     .err = err};
    *out = NULL;
    if (size > JSON_BYTES_MAX)
        return scree_fail(err, SCREE_INVALID, "", "%s: %zu bytes are more than the %d that are accepted", name, size,
                          JSON_BYTES_MAX);
    enum scree_status status = scan_value(&s, 0);
    if (status)
        return status;
    skip_space(&s);
    if (s.at < s.end)
        return refuse(&s, "text behind the end of the JSON value");
    cJSON *tree = cJSON_ParseWithLength(text, size);
    if (!tree)
        return scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to read %s", name);
    if ((status = find_duplicates(tree, "", name, err))) {
        cJSON_Delete(tree);
        return status;
    }
    *out = tree;
    return SCREE_OK;
}

enum scree_status json_read_file(const char *path, cJSON **out, struct scree_error *err)
{
    enum scree_status status = SCREE_OK;
    char *text = NULL;
    bool standard_input = strcmp(path, "-") == 0;
    FILE *file = standard_input ? stdin : fopen(path, "rb");
    *out = NULL;
    if (!file)
        return scree_fail(err, SCREE_IO, "", "cannot read %s: %s", path, strerror(errno));
    size_t room = (size_t)JSON_BYTES_MAX + 1;
    if (!(text = malloc(room))) {
        status = scree_fail(err, SCREE_NO_MEMORY, NULL, "no memory to read %s", path);
        goto out;
    }
    size_t size = fread(text, 1, room, file);
    if (ferror(file)) {
        status = scree_fail(err, SCREE_IO, "", "cannot read %s: %s", path, strerror(errno));
        goto out;
    }
    status = json_read(text, size, standard_input ? "stdin" : path, out, err);
out:
    free(text);
    if (!standard_input)
        fclose(file);
    return status;
}

cJSON *json_real(double value)
{
    char text[TEXT_REAL_MAX];
    if (!isfinite(value))
        return cJSON_CreateNull();
    if (fabs(value) <= 9007199254740992.0 && value == floor(value) && fabs(value) < 1e15)
        snprintf(text, sizeof text, "%s%.0f", signbit(value) && value == 0 ? "-" : "", fabs(value) == 0 ? 0.0 : value);
    else
        text_real(value, text);
    return cJSON_CreateRaw(text);
}

static _Thread_local unsigned long lacked, told; // failed requests; those that json_starved has told of

static void *watched_malloc(size_t size)
{
    void *memory = malloc(size);
    lacked += !memory;
    return memory;
}

/* cJSON leaves out what it has no memory for and does not say so. */
__attribute__((constructor)) static void watch_memory(void)
{
    cJSON_InitHooks(&(cJSON_Hooks){.malloc_fn = watched_malloc, .free_fn = free});
}

bool json_starved(void)
{
    bool was = lacked != told;
    told = lacked;
    return was;
}

unsigned long json_lacked(void)
{
    return lacked;
}

cJSON *json_whole(cJSON *json, unsigned long before)
{
    if (lacked == before)
        return json;
    cJSON_Delete(json);
    return NULL;
}

char *json_print_whole(cJSON *json, unsigned long before)
{
    json = json_whole(json, before);
    char *text = json ? json_print(json, false) : NULL;
    cJSON_Delete(json);
    return text;
}

void json_put(cJSON *object, const char *key, cJSON *item)
{
    if (item && !cJSON_AddItemToObject(object, key, item))
        cJSON_Delete(item);
}

void json_put_real(cJSON *object, const char *key, double value)
{
    json_put(object, key, json_real(value));
}

void json_put_int(cJSON *object, const char *key, long long value)
{
    char text[TEXT_REAL_MAX];
    snprintf(text, sizeof text, "%lld", value);
    json_put(object, key, cJSON_CreateRaw(text));
}

void json_put_text(cJSON *object, const char *key, const char *text)
{
    json_put(object, key, text ? cJSON_CreateString(text) : cJSON_CreateNull());
}

void json_put_bool(cJSON *object, const char *key, bool value)
{
    json_put(object, key, cJSON_CreateBool(value));
}

const cJSON *json_get(const cJSON *object, const char *key)
{
    return cJSON_GetObjectItemCaseSensitive(object, key);
}

const char *json_text(const cJSON *object, const char *key)
{
    return cJSON_GetStringValue(json_get(object, key));
}

double json_number(const cJSON *object, const char *key, double fallback)
{
    const cJSON *item = json_get(object, key);
    return cJSON_IsNumber(item) ? item->valuedouble : fallback;
}

bool json_bool(const cJSON *object, const char *key, bool fallback)
{
    const cJSON *item = json_get(object, key);
    return cJSON_IsBool(item) ? cJSON_IsTrue(item) : fallback;
}

/* cJSON prints the numbers of a tree that was read with 15 digits if 15 are nearly
 * enough; here every number becomes the text that reads back to its bits. */
static bool make_exact(cJSON *item)
{
    for (; item; item = item->next) {
        if (cJSON_IsNumber(item)) {
            cJSON *exact = json_real(item->valuedouble);
            if (!exact)
                return false;
            item->type = (item->type & ~0xff) | cJSON_Raw; // flags about the key stay
            item->valuestring = exact->valuestring;
            exact->valuestring = NULL; // its owner has changed
            cJSON_Delete(exact);
        } else if (item->child && !make_exact(item->child)) {
            return false;
        }
    }
    return true;
}

char *json_print(const cJSON *tree, bool pretty)
{
    cJSON *copy = cJSON_Duplicate(tree, true);
    char *text = NULL;
    if (copy && make_exact(copy))
        text = pretty ? cJSON_Print(copy) : cJSON_PrintUnformatted(copy);
    cJSON_Delete(copy);
    return text;
}
