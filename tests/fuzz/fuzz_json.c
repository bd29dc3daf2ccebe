/* SPDX-License-Identifier: GPL-3.0-or-later */
/* json_read: what it accepts prints as JSON that it accepts again, with the same
 * text; what it refuses it refuses with a message. */
#include "check.h"
#include "protocol/json.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct scree_error err = {0};
    cJSON *tree = NULL, *again = NULL;
    if (json_read((const char *)data, size, "fuzz", &tree, &err)) {
        CHECK(tree == NULL);
        check_refusal(&err);
        return 0;
    }
    char *first = json_print(tree, false);
    CHECK(first != NULL);
    /* Escapes may make a text longer than its source, so the limit may be met on the way back. */
    if (strlen(first) <= JSON_BYTES_MAX) {
        CHECK(json_read(first, strlen(first), "again", &again, &err) == SCREE_OK);
        char *second = json_print(again, false);
        CHECK(second && strcmp(first, second) == 0);
        free(second);
    }
    free(first);
    cJSON_Delete(tree);
    cJSON_Delete(again);
    return 0;
}
