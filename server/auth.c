/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See auth.h. */
#include "auth.h"

#include <errno.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

enum scree_status auth_check_endpoint(const char *endpoint, struct scree_error *err)
{
    if (strncmp(endpoint, "tcp://", 6) == 0) {
        scree_fail(err, SCREE_INVALID, "listen",
                   "listen: %s is refused: tcp is opened only encrypted and authenticated (CURVE), which this "
                   "version cannot do yet",
                   endpoint);
        scree_hint(err, "use ipc://PATH, and ssh to reach it from another machine");
        return SCREE_INVALID;
    }
    if (strncmp(endpoint, "ipc:///", 7) != 0)
        return scree_fail(err, SCREE_INVALID, "listen", "listen: %s is not of the form ipc:///absolute/path", endpoint);
    return SCREE_OK;
}

enum scree_status auth_runtime_dir(const char *path, struct scree_error *err)
{
    struct stat info;
    if (mkdir(path, 0700) == 0)
        return SCREE_OK;
    if (errno != EEXIST)
        return scree_fail(err, SCREE_IO, "runtime", "cannot make the runtime directory %s: %s", path, strerror(errno));
    if (lstat(path, &info) != 0 || !S_ISDIR(info.st_mode))
        return scree_fail(err, SCREE_IO, "runtime", "%s is not a directory", path);
    if (info.st_uid != geteuid())
        return scree_fail(err, SCREE_DENIED, "runtime", "the runtime directory %s belongs to user %u", path, (unsigned)info.st_uid);
    if ((info.st_mode & 0777) != 0700) {
        scree_fail(err, SCREE_DENIED, "runtime", "the runtime directory %s has mode %03o; others could reach the sockets", path,
                   (unsigned)(info.st_mode & 0777));
        scree_hint(err, "chmod 700 %s", path);
        return SCREE_DENIED;
    }
    return SCREE_OK;
}
