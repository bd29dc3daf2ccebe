/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What tests share: cmocka, the look at an error, numbers that are near. */
#ifndef TEST_SUPPORT_UNIT_H
#define TEST_SUPPORT_UNIT_H

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "base/status.h"

#define COUNT(array) (sizeof(array) / sizeof *(array))

/* Fails unless `err` says exactly this. */
static inline void assert_error(const struct scree_error *err, enum scree_status status, const char *path, const char *message)
{
    assert_string_equal(err->message, message);
    assert_string_equal(err->path, path);
    assert_int_equal(err->status, status);
}

/* Fails with what `error` says unless all went well. */
static inline void must(enum scree_status status, const struct scree_error *error)
{
    if (status)
        fail_msg("%s", error->message);
}

static inline void near(double value, double expect, double tolerance)
{
    if (!(fabs(value - expect) <= tolerance))
        fail_msg("%.17g is not %.17g +- %.3g", value, expect, tolerance);
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
