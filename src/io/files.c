/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See files.h. */
#include "io/files.h"

#include <errno.h>
#include <fcntl.h>
#include <libgen.h>
#include <stdbool.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum scree_status files_put(const char *part, const char *path, const void *bytes, size_t size, struct scree_error *err)
{
    FILE *file = fopen(part, "we");
    if (!file)
        return scree_fail(err, SCREE_IO, "", "cannot write %s: %s", part, strerror(errno));
    bool whole = fwrite(bytes, 1, size, file) == size && fflush(file) == 0 && fsync(fileno(file)) == 0;
    if (fclose(file) != 0 || !whole || rename(part, path) != 0)
        return scree_fail(err, SCREE_IO, "", "cannot write %s: %s", path, strerror(errno));
    return SCREE_OK;
}

enum scree_status files_settle(const char *path, struct scree_error *err)
{
    char folder[4096];
    if (snprintf(folder, sizeof folder, "%s", path) >= (int)sizeof folder)
        return scree_fail(err, SCREE_IO, "", "the path %s is too long", path);
    int fd = open(dirname(folder), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    enum scree_status status = SCREE_OK;
    if (fd < 0 || (fsync(fd) != 0 && errno != EINVAL)) // EINVAL: a file system that flushes no folders
        status = scree_fail(err, SCREE_IO, "", "cannot bring %s to disk: %s", path, strerror(errno));
    if (fd >= 0)
        close(fd);
    return status;
}

enum scree_status files_into_place(const char *part, const char *path, struct scree_error *err)
{
    int file = open(part, O_RDONLY | O_CLOEXEC);
    enum scree_status status = SCREE_OK;
    if (file < 0 || fsync(file) != 0)
        status = scree_fail(err, SCREE_IO, "", "cannot bring %s to disk: %s", part, strerror(errno));
    if (file >= 0)
        close(file);
    if (status)
        return status;
    if (rename(part, path) != 0)
        return scree_fail(err, SCREE_IO, "", "cannot rename %s to %s: %s", part, path, strerror(errno));
    return files_settle(path, err);
}
