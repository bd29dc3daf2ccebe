/* SPDX-License-Identifier: GPL-3.0-or-later */
/* `scree keygen`: a pair of CURVE keys, for this user or for a daemon. */
#include <errno.h>
#include <limits.h>
#include <stdio.h>
#include <string.h>
#include <zmq.h>

#include "output.h"
#include "protocol/json.h"
#include "protocol/keys.h"
#include "verbs.h"

static enum outcome make_keys(const char *name, char folder[PATH_MAX], struct key_pair *pair, struct scree_error *err)
{
    enum scree_status status = keys_folder(folder, PATH_MAX, err);
    if (!status)
        status = keys_folder_make(folder, err);
    if (status)
        return outcome_of_status(status);
    if (zmq_curve_keypair(pair->public_key, pair->secret_key) != 0)
        return outcome_fail(err, OUTCOME_FAILED, "this libzmq makes no keys: %s", zmq_strerror(errno));
    return outcome_of_status(keys_write_pair(folder, name, pair, err));
}

static void report(const char *name, const char *folder, const struct key_pair *pair, bool json)
{
    char secret[PATH_MAX + 64], shared[PATH_MAX + 64];
    snprintf(secret, sizeof secret, "%s/%s.key", folder, name);
    snprintf(shared, sizeof shared, "%s/%s.pub", folder, name);
    if (!json) {
        puts(shared);
        say("the secret half is %s: it stays there", secret);
        return;
    }
    cJSON *line = cJSON_CreateObject();
    json_put_text(line, "name", name);
    json_put_text(line, "public", pair->public_key);
    json_put_text(line, "public_file", shared);
    json_put_text(line, "secret_file", secret);
    put_json_line(line);
    cJSON_Delete(line);
}

static enum outcome keygen_run(const struct arguments *arguments)
{
    struct scree_error err = {.status = SCREE_OK};
    struct key_pair pair = {0};
    char folder[PATH_MAX];
    const char *name = arguments->word_count > 0 ? arguments->words[0] : "client";
    enum outcome outcome = make_keys(name, folder, &pair, &err);
    if (!outcome)
        report(name, folder, &pair, arguments->json);
    explicit_bzero(&pair, sizeof pair);
    return give_up(outcome, &err);
}

const struct verb verb_keygen = {
    .name = "keygen",
    .synopsis = "[NAME]",
    .doc = "make a pair of keys for connections over the network",
    .help = "Writes NAME.key, which stays secret, and NAME.pub, which is given to the other side, into the folder of\n"
            "keys ($SCREE_KEYS, $XDG_CONFIG_HOME/scree/keys or ~/.config/scree/keys) and prints the path of the latter.\n"
            "A daemon uses `server`, a client `client` (the NAME that is taken without one) or what $SCREE_KEY names.\n"
            "Nothing is overwritten.\n"
            "\n"
            "  scree keygen server                        where the daemon runs, as its user\n"
            "  scree keygen                               where the client runs; then bring the one's server.pub\n"
            "  scree trust client.pub --role submit       here, and the other's client.pub there, and trust it\n",
    .words_max = 1,
    .run = keygen_run,
};
