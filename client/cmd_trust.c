/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree trust`: whom the daemon of this folder of keys lets in, and what they may
 * do. The daemon looks at the list by itself. */
#include <limits.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "output.h"
#include "protocol/json.h"
#include "protocol/keys.h"
#include "verbs.h"

struct change {
    struct trusted entry; // role ROLE_NONE: takes it away
};

/* "keys/anna.pub" -> "anna" */
static enum outcome name_of(const char *path, char name[KEY_NAME_MAX], struct scree_error *err)
{
    const char *slash = strrchr(path, '/'), *base = slash ? slash + 1 : path;
    size_t length = strlen(base);
    if (length > 4 && strcmp(base + length - 4, ".pub") == 0)
        length -= 4;
    snprintf(name, KEY_NAME_MAX, "%.*s", length < KEY_NAME_MAX ? (int)length : 0, base);
    if (key_name_valid(name))
        return OUTCOME_DONE;
    outcome_fail(err, OUTCOME_REFUSED, "%s: the name of the file is to be the user's, 1 to %d of [A-Za-z0-9._-]", path,
                 KEY_NAME_MAX - 1);
    scree_hint(err, "or say it with --name");
    return OUTCOME_REFUSED;
}

/* What the command line asks for. */
static enum outcome read_change(const struct arguments *arguments, struct change *out, struct scree_error *err)
{
    const char *file = arguments->words[0], *role = arguments_value(arguments, "--role"),
               *name = arguments_value(arguments, "--name");
    bool remove = arguments_flag(arguments, "--remove");
    struct key_pair pair;
    enum outcome outcome = name_of(name ? name : file, out->entry.name, err);
    if (outcome)
        return outcome;
    if (remove == (role != NULL) || (role && role_of(role) == ROLE_NONE))
        return outcome_fail(err, OUTCOME_REFUSED, "one of --role view, submit, steer, admin, and --remove is to be given");
    out->entry.role = role_of(role);
    if (remove)
        return OUTCOME_DONE;
    enum scree_status status = keys_read_public(file, &pair, err);
    memcpy(out->entry.key, pair.public_key, sizeof out->entry.key);
    return status ? OUTCOME_REFUSED : OUTCOME_DONE;
}

/* A name stands for one key and a key for one name. */
static enum outcome apply(const struct change *change, struct trusted *list, size_t *count, struct scree_error *err)
{
    size_t kept = 0;
    bool found = false;
    for (size_t k = 0; k < *count; k++) {
        bool name = strcmp(list[k].name, change->entry.name) == 0, key = strcmp(list[k].key, change->entry.key) == 0;
        if (key && !name)
            return outcome_fail(err, OUTCOME_REFUSED, "this key is trusted as %s", list[k].name);
        found |= name;
        if (!name)
            list[kept++] = list[k];
    }
    *count = kept;
    if (change->entry.role == ROLE_NONE)
        return found ? OUTCOME_DONE : outcome_fail(err, OUTCOME_REFUSED, "%s is not trusted", change->entry.name);
    if (kept == TRUSTED_MAX)
        return outcome_fail(err, OUTCOME_REFUSED, "%d keys are trusted already, and no more fit", TRUSTED_MAX);
    list[(*count)++] = change->entry;
    return OUTCOME_DONE;
}

static void print_list(const struct trusted *list, size_t count, bool json)
{
    for (size_t k = 0; k < count; k++) {
        if (!json) {
            printf("%-6s %-20s %s\n", role_word(list[k].role), list[k].name, list[k].key);
            continue;
        }
        cJSON *line = cJSON_CreateObject();
        json_put_text(line, "name", list[k].name);
        json_put_text(line, "role", role_word(list[k].role));
        json_put_text(line, "public", list[k].key);
        put_json_line(line);
        cJSON_Delete(line);
    }
}

static enum outcome trust_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct change change = {0};
    struct trusted *list = NULL;
    size_t count = 0;
    char folder[PATH_MAX];
    enum outcome outcome = arguments->word_count > 0 ? read_change(arguments, &change, &err) : OUTCOME_DONE;
    enum scree_status status = SCREE_OK;
    if (outcome)
        return give_up(outcome, &err);
    if ((status = keys_folder(folder, sizeof folder, &err)) || (status = keys_folder_make(folder, &err)) ||
        (status = trusted_read(folder, &list, &count, &err)))
        return give_up(outcome_of_status(status), &err);
    if (arguments->word_count > 0) {
        struct trusted *grown = realloc(list, (count + 1) * sizeof *list);
        if (grown)
            list = grown;
        outcome = grown ? apply(&change, list, &count, &err) : outcome_fail(&err, OUTCOME_FAILED, "no memory");
        if (!outcome)
            outcome = outcome_of_status(trusted_write(folder, list, count, &err));
    }
    if (!outcome)
        print_list(list, count, arguments->json);
    free(list);
    return give_up(outcome, &err);
}

static const char *const options[] = {"--role=", "--name=", "--remove", NULL};

const struct verb verb_trust = {
    .name = "trust",
    .synopsis = "[NAME.pub --role view|submit|steer|admin | NAME --remove]",
    .doc = "let a key in over the network, or no longer; without a name, list who may",
    .help = "To be called by the user whose daemon it is, on its machine: changes `trusted` in the folder of keys\n"
            "($SCREE_KEYS, $XDG_CONFIG_HOME/scree/keys or ~/.config/scree/keys). A running daemon takes notice with the\n"
            "next request: nothing is restarted. --name calls the user otherwise than the file.\n"
            "\n"
            "  view     sees jobs, streams and results\n"
            "  submit   and puts jobs into the queue\n"
            "  steer    and pauses, changes, forks and cancels them\n"
            "  admin    and ends the daemon\n"
            "\n"
            "  scree trust anna.pub --role submit\n"
            "  scree trust anna --remove\n",
    .options = options,
    .words_max = 1,
    .run = trust_run,
};
