/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Key files and the list of trusted keys: whatever stands in them, a list that is
 * read is one that is written and read again the same, and a pair that is read
 * holds keys. The input is the file. */
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include "check.h"
#include "protocol/keys.h"

static char folder[64], trusted[96];

static void remove_folder(void)
{
    unlink(trusted);
    rmdir(folder);
}

/* In memory where there is such a folder: a file is written for every input. */
static void make_folder(void)
{
    struct stat info;
    snprintf(folder, sizeof folder, "%s/scree-fuzz-XXXXXX", stat("/dev/shm", &info) == 0 ? "/dev/shm" : "/tmp");
    CHECK(mkdtemp(folder) != NULL);
    snprintf(trusted, sizeof trusted, "%s/trusted", folder);
    atexit(remove_folder);
}

static void put(const uint8_t *data, size_t size)
{
    int fd = open(trusted, O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0600);
    CHECK(fd >= 0 && write(fd, data, size) == (ssize_t)size);
    close(fd);
}

static void check_denial(const struct scree_error *err)
{
    CHECK(err->status == SCREE_CORRUPT);
    check_text(err->message);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size)
{
    struct trusted *list, *again;
    struct key_pair pair;
    struct scree_error err = {0};
    size_t count, count_again;
    if (!*folder)
        make_folder();
    put(data, size);
    if (keys_read_pair(trusted, &pair, &err))
        check_denial(&err);
    else
        CHECK(key_valid(pair.public_key) && key_valid(pair.secret_key));
    if (keys_read_public(trusted, &pair, &err))
        check_denial(&err);
    else
        CHECK(key_valid(pair.public_key) && !*pair.secret_key);
    if (trusted_read(folder, &list, &count, &err)) {
        check_denial(&err);
        return 0;
    }
    CHECK(trusted_write(folder, list, count, &err) == SCREE_OK);
    CHECK(trusted_read(folder, &again, &count_again, &err) == SCREE_OK);
    CHECK(count == count_again && memcmp(list, again, count * sizeof *list) == 0);
    free(list);
    free(again);
    return 0;
}
