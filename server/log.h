/* SPDX-License-Identifier: GPL-3.0-or-later */
/* One line an event on stderr: time, level, key=value pairs. From any thread. */
#ifndef SCREE_SERVER_LOG_H
#define SCREE_SERVER_LOG_H

enum log_level { LOG_INFO, LOG_WARNING, LOG_ERROR };

void log_line(enum log_level level, const char *format, ...) __attribute__((format(printf, 2, 3)));

#endif
