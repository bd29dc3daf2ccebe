/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Errors as values: see status.h.
 *
 * Messages quote what came from outside, and end up on terminals, in logs and in
 * JSON. They are cleaned here, once, rather than by each caller. */
#include "base/status.h"

#include <stdarg.h>
#include <stdio.h>

#include "base/text.h"

enum scree_status scree_fail(struct scree_error *err, enum scree_status status, const char *path, const char *format, ...)
{
    if (!err)
        return status;
    va_list arguments;
    err->status = status;
    snprintf(err->path, sizeof err->path, "%s", path ? path : "");
    va_start(arguments, format);
    vsnprintf(err->message, sizeof err->message, format, arguments);
    va_end(arguments);
    text_clean(err->path);
    text_clean(err->message);
    err->hint[0] = 0;
    return status;
}

void scree_hint(struct scree_error *err, const char *format, ...)
{
    if (!err)
        return;
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(err->hint, sizeof err->hint, format, arguments);
    va_end(arguments);
    text_clean(err->hint);
}

const char *scree_status_word(enum scree_status status)
{
    switch (status) {
    case SCREE_OK:
        return "ok";
    case SCREE_INVALID:
        return "invalid";
    case SCREE_NO_MEMORY:
        return "no_memory";
    case SCREE_IO:
        return "io";
    case SCREE_CORRUPT:
        return "corrupt";
    case SCREE_BLOWUP:
        return "blowup";
    case SCREE_NOT_FOUND:
        return "not_found";
    case SCREE_BUSY:
        return "busy";
    case SCREE_CANCELLED:
        return "cancelled";
    case SCREE_DENIED:
        return "denied";
    case SCREE_CONFLICT:
        return "conflict";
    case SCREE_INTERNAL:
        break;
    }
    return "internal";
}
