/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A line is written by one call, so that lines of threads do not mix. */
#include "log.h"

#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

static atomic_int log_fd = STDERR_FILENO;

enum scree_status log_open(const char *path, struct scree_error *err)
{
    int fd = open(path, O_WRONLY | O_APPEND | O_CREAT | O_CLOEXEC, 0600);
    if (fd < 0)
        return scree_fail(err, SCREE_IO, "log", "cannot write the log %s: %s", path, strerror(errno));
    int now = atomic_load(&log_fd);
    if (now == STDERR_FILENO) {
        atomic_store(&log_fd, fd);
        return SCREE_OK;
    }
    /* The number stays, so that no thread writes to a file that was just closed. */
    int moved = dup3(fd, now, O_CLOEXEC);
    close(fd);
    return moved >= 0 ? SCREE_OK : scree_fail(err, SCREE_IO, "log", "cannot write the log %s: %s", path, strerror(errno));
}

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
    if (write(atomic_load(&log_fd), line, (size_t)length) < 0)
        return; // nobody reads the log: the daemon goes on
}
