/* SPDX-License-Identifier: GPL-3.0-or-later */
/* CURVE keys as files, for daemon and client alike. A key is 40 characters of Z85
 * (ZeroMQ RFC 32), 32 bytes.
 *
 * A folder of keys (mode 0700) holds NAME.key, a pair that nobody else may read
 * (mode 0600), NAME.pub, its public half that may be given away, and `trusted`, the list of
 * whom a daemon lets in. What others could read or change is refused, as ssh
 * does: a secret that was open once is none. */
#ifndef SCREE_PROTOCOL_KEYS_H
#define SCREE_PROTOCOL_KEYS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>

#include "base/status.h"

enum { KEY_TEXT_MAX = 41, KEY_NAME_MAX = 32 };

struct key_pair {
    char public_key[KEY_TEXT_MAX];
    char secret_key[KEY_TEXT_MAX]; // "" in what was read from a NAME.pub
};

/* What a user may do; each role may do what those before it may. */
enum role { ROLE_NONE, ROLE_VIEW, ROLE_SUBMIT, ROLE_STEER, ROLE_ADMIN };
const char *role_word(enum role role);
enum role role_of(const char *word); // ROLE_NONE if there is no such word

/* 40 characters of Z85 that stand for 32 bytes. */
bool key_valid(const char *text);
/* 1 to KEY_NAME_MAX - 1 of [A-Za-z0-9._-], not starting with a dot or a dash. */
bool key_name_valid(const char *name);

/* The folder: $SCREE_KEYS, $XDG_CONFIG_HOME/scree/keys, ~/.config/scree/keys. */
enum scree_status keys_folder(char *out, size_t size, struct scree_error *err);
/* Makes the folder (and its parents) with mode 0700, or accepts one that is ours and closed to others. */
enum scree_status keys_folder_make(const char *folder, struct scree_error *err);
enum scree_status keys_folder_check(const char *folder, struct scree_error *err);

/* Reads a NAME.key. SCREE_NOT_FOUND if there is none, SCREE_DENIED if others can
 * read or write it or it is not ours, SCREE_CORRUPT if it holds no pair. */
enum scree_status keys_read_pair(const char *path, struct key_pair *out, struct scree_error *err);
/* Reads a NAME.pub, the same failures but for who can read it. */
enum scree_status keys_read_public(const char *path, struct key_pair *out, struct scree_error *err);
/* What either does with an open file; the path is for messages. */
enum scree_status keys_parse(FILE *file, const char *path, bool secret, struct key_pair *out, struct scree_error *err);
/* Writes FOLDER/NAME.key (0600) and FOLDER/NAME.pub (0644); SCREE_INVALID if one is there. */
enum scree_status keys_write_pair(const char *folder, const char *name, const struct key_pair *pair, struct scree_error *err);

/* ---- the trusted ones ---- */

struct trusted {
    char key[KEY_TEXT_MAX];
    char name[KEY_NAME_MAX];
    enum role role;
};

enum { TRUSTED_MAX = 1024 };

/* Reads FOLDER/trusted: lines `ROLE NAME KEY`, # starts a comment line. *list is
 * the caller's (free), NULL if it is empty. No file is an empty list; others that could write it: SCREE_DENIED. */
enum scree_status trusted_read(const char *folder, struct trusted **list, size_t *count, struct scree_error *err);
/* The same of an open file, NULL: there is none. */
enum scree_status trusted_parse(FILE *file, const char *path, struct trusted **list, size_t *count, struct scree_error *err);
/* The file's text, the caller's (free); NULL without memory. */
char *trusted_print(const struct trusted *list, size_t count);
/* Replaces the file in one step. */
enum scree_status trusted_write(const char *folder, const struct trusted *list, size_t count, struct scree_error *err);

#endif
