/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A line is written by one call, so that lines of threads do not mix. */
#include "log.h"

#include <stdarg.h>
#include <stdio.h>
#include <time.h>
#include <unistd.h>

void log_line(enum log_level level, const char *format, ...)
{
    static const char *const words[] = {"info", "warning", "error"};
    char line[2048], stamp[32];
    struct timespec now;
    struct tm utc;
    clock_gettime(CLOCK_REALTIME, &now);
    gmtime_r(&now.tv_sec, &utc);
    strftime(stamp, sizeof stamp, "%Y-%m-%dT%H:%M:%S", &utc);
    int length = snprintf(line, sizeof line, "%s.%03ldZ %s ", stamp, now.tv_nsec / 1000000, words[level]);
    va_list arguments;
    va_start(arguments, format);
    int more = vsnprintf(line + length, sizeof line - (size_t)length - 1, format, arguments);
    va_end(arguments);
    length += more < (int)sizeof line - length - 1 ? more : (int)sizeof line - length - 2;
    for (char *p = line; p < line + length; p++)
        if (*p == '\n' || *p == '\r')
            *p = ' ';
    line[length++] = '\n';
    if (write(STDERR_FILENO, line, (size_t)length) < 0)
        return; // nobody reads the log: the daemon goes on
}
