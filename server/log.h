/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One line an event on stderr: time, level, key=value pairs. From any thread. */
#ifndef SCREE_SERVER_LOG_H
#define SCREE_SERVER_LOG_H

#include "base/status.h"

enum log_level { LOG_INFO, LOG_WARNING, LOG_ERROR };

/* From now on lines are appended to the file; called again (SIGHUP) it opens it anew, so that
 * a log that was moved away is let go. On failure lines go where they went before. */
enum scree_status log_open(const char *path, struct scree_error *err);

void log_line(enum log_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
