/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What must hold for any input, in every build: a breach ends the process. */
#ifndef TEST_FUZZ_CHECK_H
#define TEST_FUZZ_CHECK_H

#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/status.h"
#include "base/text.h"

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

#define CHECK(condition)                                                                                                           \
    do {                                                                                                                           \
        if (!(condition)) {                                                                                                        \
            fprintf(stderr, "%s:%d: %s does not hold\n", __FILE__, __LINE__, #condition);                                          \
            abort();                                                                                                               \
        }                                                                                                                          \
    } while (0)

/* A refusal says something, and nothing that a terminal or a JSON reader minds. */
static inline void check_text(const char *text)
{
    char clean[SCREE_MESSAGE_MAX];
    CHECK(strlen(text) < sizeof clean);
    memcpy(clean, text, strlen(text) + 1);
    text_clean(clean);
    CHECK(strcmp(clean, text) == 0);
}

static inline void check_refusal(const struct scree_error *err)
{
    CHECK(err->status == SCREE_INVALID);
    CHECK(err->message[0] != 0);
    check_text(err->path);
    check_text(err->message);
    check_text(err->hint);
}

#endif
