/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See keys.h. Files are checked through the open descriptor, so that what was
 * checked is what is read. */
#include "protocol/keys.h"

#include <ctype.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#include "base/memory.h"

static const char *const role_words[] = {"none", "view", "submit", "steer", "admin"};

const char *role_word(enum role role)
{
    return role_words[role];
}

enum role role_of(const char *word)
{
    for (int k = ROLE_VIEW; k <= ROLE_ADMIN; k++)
        if (word && strcmp(word, role_words[k]) == 0)
            return (enum role)k;
    return ROLE_NONE;
}

bool key_valid(const char *text)
{
    static const char alphabet[] = "0123456789abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ.-:+=^!/*?&<>()[]{}@%$#";
    if (!text || strlen(text) != KEY_TEXT_MAX - 1)
        return false;
    for (int group = 0; group < 8; group++) {
        uint64_t value = 0;
        for (int k = 0; k < 5; k++) {
            const char *found = strchr(alphabet, text[5 * group + k]);
            if (!found)
                return false;
            value = 85 * value + (uint64_t)(found - alphabet);
        }
        if (value > UINT32_MAX)
            return false;
    }
    return true;
}

bool key_name_valid(const char *name)
{
    if (!name || !*name || *name == '.' || *name == '-' || strlen(name) >= KEY_NAME_MAX)
        return false;
    for (; *name; name++)
        if (!isalnum((unsigned char)*name) && !strchr("._-", *name))
            return false;
    return true;
}

/* ---- the folder ---- */

enum scree_status keys_folder(char *out, size_t size, struct scree_error *err)
{
    const char *own = getenv("SCREE_KEYS"), *config = getenv("XDG_CONFIG_HOME"), *home = getenv("HOME");
    int length;
    if (own && *own)
        length = snprintf(out, size, "%s", own);
    else if (config && *config == '/')
        length = snprintf(out, size, "%s/scree/keys", config);
    else if (home && *home == '/')
        length = snprintf(out, size, "%s/.config/scree/keys", home);
    else
        return scree_fail(err, SCREE_INVALID, "keys", "no folder for keys: neither SCREE_KEYS nor HOME is set");
    if (length < 0 || (size_t)length >= size)
        return scree_fail(err, SCREE_INVALID, "keys", "the path of the folder of keys is too long");
    return SCREE_OK;
}

static enum scree_status check_private(const char *path, const struct stat *info, mode_t forbidden, struct scree_error *err)
{
    if (info->st_uid != geteuid() && info->st_uid != 0)
        return scree_fail(err, SCREE_DENIED, "keys", "%s belongs to user %u", path, (unsigned)info->st_uid);
    if (info->st_mode & forbidden) {
        scree_fail(err, SCREE_DENIED, "keys", "%s has mode %03o: others can %s it", path, (unsigned)(info->st_mode & 0777),
                   info->st_mode & 022 ? "change" : "read");
        scree_hint(err, "chmod go-rwx %s, and make new keys if somebody may have read it", path);
        return SCREE_DENIED;
    }
    return SCREE_OK;
}

enum scree_status keys_folder_check(const char *folder, struct scree_error *err)
{
    struct stat info;
    if (stat(folder, &info) != 0) {
        scree_fail(err, errno == ENOENT ? SCREE_NOT_FOUND : SCREE_IO, "keys", "no folder of keys at %s: %s", folder,
                   strerror(errno));
        scree_hint(err, "`scree keygen` makes keys");
        return errno == ENOENT ? SCREE_NOT_FOUND : SCREE_IO;
    }
    if (!S_ISDIR(info.st_mode))
        return scree_fail(err, SCREE_IO, "keys", "%s is not a folder", folder);
    return check_private(folder, &info, 077, err);
}

enum scree_status keys_folder_make(const char *folder, struct scree_error *err)
{
    char path[PATH_MAX];
    if (snprintf(path, sizeof path, "%s", folder) >= (int)sizeof path)
        return scree_fail(err, SCREE_INVALID, "keys", "the path of the folder of keys is too long");
    for (char *slash = strchr(path + 1, '/'); slash; slash = strchr(slash + 1, '/')) {
        *slash = 0;
        mkdir(path, 0700); // what fails here fails below with a reason
        *slash = '/';
    }
    if (mkdir(path, 0700) != 0 && errno != EEXIST)
        return scree_fail(err, SCREE_IO, "keys", "cannot make the folder %s: %s", folder, strerror(errno));
    return keys_folder_check(folder, err);
}

/* ---- files ---- */

/* Opens a regular file of which nobody else has the rights `forbidden`. */
static enum scree_status open_checked(const char *path, mode_t forbidden, FILE **out, struct scree_error *err)
{
    struct stat info;
    enum scree_status status = SCREE_OK;
    int fd = open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    *out = NULL;
    if (fd < 0) {
        status = errno == ENOENT ? SCREE_NOT_FOUND : errno == ELOOP || errno == EACCES ? SCREE_DENIED : SCREE_IO;
        return scree_fail(err, status, "keys", "cannot read %s: %s", path, strerror(errno));
    }
    if (fstat(fd, &info) != 0 || !S_ISREG(info.st_mode))
        status = scree_fail(err, SCREE_IO, "keys", "%s is not a regular file", path);
    else
        status = check_private(path, &info, forbidden, err);
    if (!status && !(*out = fdopen(fd, "r")))
        status = scree_fail(err, SCREE_NO_MEMORY, "keys", "no memory to read %s", path);
    if (status)
        close(fd);
    return status;
}

/* The words of the next line that has some; false at the end. A line too long or
 * with more words than fit has *count 0. */
static bool read_words(FILE *file, char *line, int size, char *words[4], int *count)
{
    while (fgets(line, size, file)) {
        char *rest = NULL, *start = line + strspn(line, " \t");
        bool whole = strchr(line, '\n') != NULL || feof(file);
        if (whole && (*start == '#' || *start == '\n' || !*start))
            continue;
        *count = 0;
        for (char *word = strtok_r(start, " \t\r\n", &rest); word && *count < 4; word = strtok_r(NULL, " \t\r\n", &rest))
            words[(*count)++] = word;
        if (!whole || *count == 4)
            *count = 0;
        return true;
    }
    return false;
}

enum scree_status keys_parse(FILE *file, const char *path, bool secret, struct key_pair *out, struct scree_error *err)
{
    char line[256], *words[4];
    int count;
    bool good = true;
    *out = (struct key_pair){0};
    while (good && read_words(file, line, sizeof line, words, &count)) {
        good = count == 2 && key_valid(words[1]);
        if (good && strcmp(words[0], "public") == 0)
            snprintf(out->public_key, KEY_TEXT_MAX, "%s", words[1]);
        else if (good && secret && strcmp(words[0], "secret") == 0)
            snprintf(out->secret_key, KEY_TEXT_MAX, "%s", words[1]);
        else
            good = false;
    }
    explicit_bzero(line, sizeof line);
    if (!good || !*out->public_key || (secret && !*out->secret_key)) {
        explicit_bzero(out, sizeof *out);
        return scree_fail(err, SCREE_CORRUPT, "keys", "%s is not a %s key as scree keygen writes it", path,
                          secret ? "secret" : "public");
    }
    return SCREE_OK;
}

static enum scree_status read_keys(const char *path, mode_t forbidden, bool secret, struct key_pair *out, struct scree_error *err)
{
    FILE *file;
    *out = (struct key_pair){0};
    enum scree_status status = open_checked(path, forbidden, &file, err);
    if (status)
        return status;
    status = keys_parse(file, path, secret, out, err);
    fclose(file);
    return status;
}

enum scree_status keys_read_pair(const char *path, struct key_pair *out, struct scree_error *err)
{
    return read_keys(path, 077, true, out, err);
}

enum scree_status keys_read_public(const char *path, struct key_pair *out, struct scree_error *err)
{
    return read_keys(path, 022, false, out, err);
}

/* Writes a new file and syncs it. */
static enum scree_status write_new(const char *path, mode_t mode, const char *text, struct scree_error *err)
{
    size_t length = strlen(text);
    int fd = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, mode);
    if (fd < 0 && errno == EEXIST)
        return scree_fail(err, SCREE_INVALID, "keys", "%s is there already; keys are not overwritten", path);
    bool good = fd >= 0 && fchmod(fd, mode) == 0 && write(fd, text, length) == (ssize_t)length && fsync(fd) == 0;
    int why = errno;
    if (fd >= 0 && close(fd) != 0 && good) {
        good = false;
        why = errno;
    }
    if (good)
        return SCREE_OK;
    if (fd >= 0)
        unlink(path);
    return scree_fail(err, SCREE_IO, "keys", "cannot write %s: %s", path, strerror(why));
}

enum scree_status keys_write_pair(const char *folder, const char *name, const struct key_pair *pair, struct scree_error *err)
{
    char secret_path[PATH_MAX], public_path[PATH_MAX], text[512];
    if (!key_name_valid(name))
        return scree_fail(err, SCREE_INVALID, "name",
                          "\"%s\" is no name for a key: 1 to %d of [A-Za-z0-9._-], the first a letter or a digit", name,
                          KEY_NAME_MAX - 1);
    if (snprintf(public_path, sizeof public_path, "%s/%s.pub", folder, name) >= (int)sizeof public_path ||
        snprintf(secret_path, sizeof secret_path, "%s/%s.key", folder, name) >= (int)sizeof secret_path)
        return scree_fail(err, SCREE_INVALID, "keys", "the path of the folder of keys is too long");
    if (access(public_path, F_OK) == 0)
        return scree_fail(err, SCREE_INVALID, "keys", "%s is there already; keys are not overwritten", public_path);
    snprintf(text, sizeof text, "# scree: secret key of %s. Whoever reads it is %s.\npublic %s\nsecret %s\n", name, name,
             pair->public_key, pair->secret_key);
    enum scree_status status = write_new(secret_path, 0600, text, err);
    explicit_bzero(text, sizeof text);
    if (status)
        return status;
    snprintf(text, sizeof text, "# scree: public key of %s\npublic %s\n", name, pair->public_key);
    status = write_new(public_path, 0644, text, err);
    if (status)
        unlink(secret_path);
    return status;
}

/* ---- the trusted ones ---- */

static enum scree_status trusted_path(const char *folder, const char *ending, char out[PATH_MAX], struct scree_error *err)
{
    if (snprintf(out, PATH_MAX, "%s/trusted%s", folder, ending) >= PATH_MAX)
        return scree_fail(err, SCREE_INVALID, "keys", "the path of the folder of keys is too long");
    return SCREE_OK;
}

enum scree_status trusted_parse(FILE *file, const char *path, struct trusted **list, size_t *count, struct scree_error *err)
{
    char line[256], *words[4];
    int found;
    size_t room = 0;
    enum scree_status status = SCREE_OK;
    *list = NULL;
    *count = 0;
    while (!status && file && read_words(file, line, sizeof line, words, &found)) {
        if ((status = memory_grow((void **)list, &room, *count + 1, sizeof **list, err)))
            break;
        struct trusted *t = &(*list)[*count];
        if (*count == TRUSTED_MAX)
            status = scree_fail(err, SCREE_CORRUPT, "keys", "%s has more than %d keys", path, TRUSTED_MAX);
        else if (found != 3 || role_of(words[0]) == ROLE_NONE || !key_name_valid(words[1]) || !key_valid(words[2]))
            status =
                scree_fail(err, SCREE_CORRUPT, "keys", "%s: key %zu is not `view|submit|steer|admin NAME KEY`", path, *count + 1);
        if (status)
            break;
        memset(t, 0, sizeof *t);
        t->role = role_of(words[0]);
        snprintf(t->name, sizeof t->name, "%s", words[1]);
        snprintf(t->key, sizeof t->key, "%s", words[2]);
        ++*count;
    }
    if (status) {
        free(*list);
        *list = NULL;
        *count = 0;
    }
    return status;
}

char *trusted_print(const struct trusted *list, size_t count)
{
    size_t room = 128 * (count + 2), length;
    char *text = malloc(room);
    if (!text)
        return NULL;
    length = (size_t)snprintf(text, room, "# scree: whom the daemon lets in, `ROLE NAME KEY`. Written by scree trust.\n");
    for (size_t k = 0; k < count; k++)
        length += (size_t)snprintf(text + length, room - length, "%s %s %s\n", role_word(list[k].role), list[k].name, list[k].key);
    return text;
}

enum scree_status trusted_read(const char *folder, struct trusted **list, size_t *count, struct scree_error *err)
{
    char path[PATH_MAX];
    FILE *file = NULL;
    *list = NULL;
    *count = 0;
    enum scree_status status = trusted_path(folder, "", path, err);
    if (!status && (status = open_checked(path, 022, &file, err)) == SCREE_NOT_FOUND)
        status = SCREE_OK; // nobody is trusted yet
    if (!status)
        status = trusted_parse(file, path, list, count, err);
    if (file)
        fclose(file);
    return status;
}

enum scree_status trusted_write(const char *folder, const struct trusted *list, size_t count, struct scree_error *err)
{
    char path[PATH_MAX], beside[PATH_MAX];
    enum scree_status status;
    if ((status = trusted_path(folder, "", path, err)) || (status = trusted_path(folder, ".new", beside, err)))
        return status;
    char *text = trusted_print(list, count);
    if (!text)
        return scree_fail(err, SCREE_NO_MEMORY, "keys", "no memory for the trusted keys");
    unlink(beside); // left by a call that was killed
    status = write_new(beside, 0600, text, err);
    free(text);
    if (!status && rename(beside, path) != 0) {
        status = scree_fail(err, SCREE_IO, "keys", "cannot write %s: %s", path, strerror(errno));
        unlink(beside);
    }
    int fd = status ? -1 : open(folder, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (fd >= 0) {
        fsync(fd);
        close(fd);
    }
    return status;
}
