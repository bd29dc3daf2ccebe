/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See destination.h. Whether one may write is found out by writing: access() does
 * not know about read-only file systems, quotas or root. */
#include "destination.h"

#include <errno.h>
#include <fcntl.h>
#include <stdio.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static enum outcome too_long(struct scree_error *err)
{
    return outcome_fail(err, OUTCOME_REFUSED, "the path of the result is too long");
}

/* Makes every missing folder of the path; notes how much of it was there. */
static enum outcome make_folders(struct destination *d, struct scree_error *err)
{
    char path[PATH_MAX];
    size_t length = strlen(d->folder);
    bool made = false;
    d->existing = length;
    for (size_t k = 1; k <= length; k++) {
        if (d->folder[k] != '/' && d->folder[k])
            continue;
        memcpy(path, d->folder, k);
        path[k] = 0;
        if (mkdir(path, 0777) == 0) {
            for (size_t parent = k - 1; !made; parent--) { // back to the folder that was there
                d->existing = parent;
                made = parent == 0 || path[parent] == '/';
            }
            continue;
        }
        struct stat info;
        int why = errno;
        if (stat(path, &info) == 0 && S_ISDIR(info.st_mode))
            continue;
        return outcome_fail(err, OUTCOME_REFUSED, "cannot make the folder %s for the result: %s", path,
                            strerror(why == EEXIST ? ENOTDIR : why));
    }
    return OUTCOME_DONE;
}

static enum outcome try_folder(const char *folder, struct scree_error *err)
{
    char path[PATH_MAX];
    if (snprintf(path, sizeof path, "%s/.scree-try-%ld", folder, (long)getpid()) >= (int)sizeof path)
        return too_long(err);
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
    if (fd < 0)
        return outcome_fail(err, OUTCOME_REFUSED, "cannot write the result into %s: %s", folder, strerror(errno));
    close(fd);
    unlink(path);
    return OUTCOME_DONE;
}

enum outcome destination_prepare(const char *out, struct destination *d, struct scree_error *err)
{
    size_t length = strlen(out);
    bool is_file = length > 3 && strcmp(out + length - 3, ".h5") == 0;
    struct stat info;
    *d = (struct destination){.existing = 0};
    if (length + sizeof "/result.h5.part" + 16 > PATH_MAX)
        return too_long(err);
    snprintf(d->file, sizeof d->file, is_file ? "%s" : "%s/result.h5", out);
    snprintf(d->folder, sizeof d->folder, "%s", out);
    char *slash = is_file ? strrchr(d->folder, '/') : NULL;
    if (slash == d->folder)
        slash[1] = 0;
    else if (slash)
        *slash = 0;
    else if (is_file)
        snprintf(d->folder, sizeof d->folder, ".");
    enum outcome outcome = make_folders(d, err);
    if (!outcome && stat(d->file, &info) == 0 && !S_ISREG(info.st_mode))
        outcome = outcome_fail(err, OUTCOME_REFUSED, "cannot write the result to %s: it exists and is no file", d->file);
    if (!outcome)
        outcome = try_folder(d->folder, err);
    if (outcome)
        destination_abandon(d);
    return outcome;
}

enum outcome destination_fresh(const char *stem, struct destination *d, struct scree_error *err)
{
    char name[PATH_MAX];
    struct stat info;
    for (int k = 1; k < 10000; k++) {
        int length = k == 1 ? snprintf(name, sizeof name, "%s", stem) : snprintf(name, sizeof name, "%s-%d", stem, k);
        if (length < 0 || (size_t)length >= sizeof name)
            return too_long(err);
        if (lstat(name, &info) != 0 && errno == ENOENT)
            return destination_prepare(name, d, err);
    }
    return outcome_fail(err, OUTCOME_REFUSED, "there are too many folders %s-N here; name one with -o", stem);
}

enum outcome destination_try_here(struct scree_error *err)
{
    return try_folder(".", err);
}

void destination_abandon(struct destination *d)
{
    for (size_t length = strlen(d->folder); length > d->existing;) {
        d->folder[length] = 0;
        if (rmdir(d->folder) != 0)
            return;
        while (length > d->existing && d->folder[length] != '/')
            length--;
    }
}
