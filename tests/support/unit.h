/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What the unit tests of specs and messages share: cmocka, draws that are the
 * same in every run, and the look at an error. */
#ifndef TEST_SUPPORT_UNIT_H
#define TEST_SUPPORT_UNIT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <stdlib.h>
#include <string.h>

#include "base/status.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* Steele's splitmix64: short, and any seed will do. */
static inline uint64_t draw(uint64_t *state)
{
    uint64_t z = *state += 0x9e3779b97f4a7c15u;
    z = (z ^ z >> 30) * 0xbf58476d1ce4e5b9u;
    z = (z ^ z >> 27) * 0x94d049bb133111ebu;
    return z ^ z >> 31;
}

static inline size_t draw_below(uint64_t *state, size_t limit)
{
    return (size_t)(draw(state) % limit);
}

/* Fails unless `err` says exactly this. */
static inline void assert_error(const struct scree_error *err, enum scree_status status, const char *path, const char *message)
{
    assert_string_equal(err->message, message);
    assert_string_equal(err->path, path);
    assert_int_equal(err->status, status);
}

/* The folder of the sources, which ctest tells. */
static inline const char *source_folder(void)
{
    const char *folder = getenv("SCREE_SOURCE");
    if (!folder)
        fail_msg("SCREE_SOURCE is not set: run this test through ctest");
    return folder;
}

#endif
