/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Key files and the list of trusted keys: whatever stands in them, a list that is
 * read is one that is written and read again the same, and a pair that is read
 * holds keys. The input is the file. */
#include "check.h"
#include "protocol/keys.h"

static void check_denial(const struct scree_error *err)
{
    CHECK(err->status == SCREE_CORRUPT);
    check_text(err->message);
}

/* A file that lies in memory; none holds no byte, which fmemopen would refuse. */
static FILE *open_text(const void *data, size_t size)
{
    FILE *file = size ? fmemopen((void *)(uintptr_t)data, size, "r") : fopen("/dev/null", "r");
    CHECK(file != NULL);
    return file;
}

static void read_pair(const uint8_t *data, size_t size, bool secret)
{
    struct key_pair pair;
    struct scree_error err = {0};
    FILE *file = open_text(data, size);
    if (keys_parse(file, "a file", secret, &pair, &err))
        check_denial(&err);
    else
        CHECK(key_valid(pair.public_key) && (secret ? key_valid(pair.secret_key) : !*pair.secret_key));
    fclose(file);
}

static enum scree_status read_list(const void *data, size_t size, struct trusted **list, size_t *count, struct scree_error *err)
{
    FILE *file = open_text(data, size);
    enum scree_status status = trusted_parse(file, "a file", list, count, err);
    fclose(file);
    return status;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct trusted *list, *again;
    struct scree_error err = {0};
    size_t count, count_again;
    read_pair(data, size, true);
    read_pair(data, size, false);
    if (read_list(data, size, &list, &count, &err)) {
        check_denial(&err);
        return 0;
    }
    char *text = trusted_print(list, count);
    CHECK(text != NULL);
    CHECK(read_list(text, strlen(text), &again, &count_again, &err) == SCREE_OK);
    CHECK(count == count_again && (count == 0 || memcmp(list, again, count * sizeof *list) == 0));
    free(text);
    free(list);
    free(again);
    return 0;
}
