/* SPDX-License-Identifier: GPL-3.0-or-later */
/* The command line: global options anywhere, a verb, its own options and words.
 *
 * Not getopt, because global options may stand on both sides of the verb and
 * each verb has a table of its own, against which a wrong option is named. */
#include <errno.h>
#include <stdlib.h>
#include <string.h>

#include "cli.h"
#include "spec/field.h"

static const char *const global_options[] = {"--connect=", "--json", "--help", "--version", "--man", "--completion", NULL};

/* The option of the table that `text` (up to its '=') names, or NULL. */
static const char *find_option(const char *const *table, const char *text)
{
    size_t length = strcspn(text, "=");
    for (; table && *table; table++)
        if (strcspn(*table, "=") == length && strncmp(*table, text, length) == 0)
            return *table;
    return NULL;
}

/* The known option that a mistyped one probably means. */
static const char *nearest_option(const struct verb *verb, const char *text)
{
    const char *words[32];
    static char names[32][32];
    int count = 0;
    const char *const *tables[] = {global_options, verb ? verb->options : NULL};
    for (int t = 0; t < 2; t++)
        for (const char *const *row = tables[t]; row && *row && count < 31; row++) {
            size_t length = strcspn(*row, "=");
            length = length < sizeof names[0] ? length : sizeof names[0] - 1;
            memcpy(names[count], *row, length);
            names[count][length] = 0;
            words[count] = names[count];
            count++;
        }
    words[count] = NULL;
    return word_nearest(words, text);
}

static void keep_global(struct arguments *out, const char *name, const char *value)
{
    if (strncmp(name, "--connect", 9) == 0)
        out->connect = value;
    else if (strcmp(name, "--json") == 0)
        out->json = true;
    else if (strcmp(name, "--help") == 0)
        out->help = true;
    else if (strcmp(name, "--man") == 0)
        out->man = true;
    else if (strcmp(name, "--completion") == 0)
        out->completion = true;
    else
        out->version = true;
}

static enum outcome keep_own(struct arguments *out, const char *row, const char *value, struct scree_error *err)
{
    const char *equals = strchr(row, '=');
    bool repeats = equals && equals[1] == '*';
    static char names[64][32]; // a verb's option without its '=', for as long as the program runs
    if (out->option_count >= 64)
        return outcome_fail(err, OUTCOME_REFUSED, "too many options");
    char *name = names[out->option_count];
    size_t length = strcspn(row, "=");
    memcpy(name, row, length < 31 ? length : 31);
    if (!repeats && (arguments_value(out, name) || arguments_flag(out, name)))
        return outcome_fail(err, OUTCOME_REFUSED, "%s is given twice", name);
    out->options[out->option_count++] = (struct given_option){name, value};
    return OUTCOME_DONE;
}

/* The option at argv[*k]; takes the next argument for its value when it needs one. */
static enum outcome read_option(int argc, char **argv, int *k, struct arguments *out, struct scree_error *err)
{
    const char *text = strcmp(argv[*k], "-h") == 0 ? "--help" : argv[*k];
    const char *row = find_option(global_options, text);
    bool global = row != NULL;
    if (!row && out->verb)
        row = find_option(out->verb->options, text);
    if (!row) {
        const char *near = nearest_option(out->verb, text);
        outcome_fail(err, OUTCOME_REFUSED, "unknown option %s%s%s%s", text, near ? "; did you mean " : "", near ? near : "",
                     near ? "?" : "");
        if (!out->verb)
            scree_hint(err, "options of a verb stand behind it");
        return OUTCOME_REFUSED;
    }
    const char *value = NULL, *equals = strchr(text, '=');
    if (strchr(row, '=')) {
        if (!equals && *k + 1 >= argc)
            return outcome_fail(err, OUTCOME_REFUSED, "%s wants a value", text);
        value = equals ? equals + 1 : argv[++*k];
        if (!*value)
            return outcome_fail(err, OUTCOME_REFUSED, "%s wants a value that is not empty", argv[*k - !equals]);
    } else if (equals) {
        return outcome_fail(err, OUTCOME_REFUSED, "%s takes no value", row);
    }
    if (!global)
        return keep_own(out, row, value, err);
    keep_global(out, row, value);
    return OUTCOME_DONE;
}

static enum outcome read_verb(const char *name, const struct verb *const *verbs, struct arguments *out, struct scree_error *err)
{
    const char *names[64];
    int count = 0;
    for (; verbs[count] && count < 63; count++) {
        if (strcmp(verbs[count]->name, name) == 0) {
            out->verb = verbs[count];
            return OUTCOME_DONE;
        }
        names[count] = verbs[count]->name;
    }
    names[count] = NULL;
    const char *near = word_nearest(names, name);
    outcome_fail(err, OUTCOME_REFUSED, "unknown verb \"%s\"%s%s%s", name, near ? "; did you mean \"" : "", near ? near : "",
                 near ? "\"?" : "");
    scree_hint(err, "scree --help lists the verbs");
    return OUTCOME_REFUSED;
}

static enum outcome check_words(const struct arguments *out, struct scree_error *err)
{
    const struct verb *verb = out->verb;
    if (!verb || out->help || (out->word_count >= verb->words_min && (verb->words_max < 0 || out->word_count <= verb->words_max)))
        return OUTCOME_DONE;
    if (out->word_count < verb->words_min)
        outcome_fail(err, OUTCOME_REFUSED, "%s: something is missing", verb->name);
    else
        outcome_fail(err, OUTCOME_REFUSED, "%s: \"%s\" is one word too many", verb->name, out->words[verb->words_max]);
    scree_hint(err, "usage: scree %s%s%s", verb->name, *verb->synopsis ? " " : "", verb->synopsis);
    return OUTCOME_REFUSED;
}

enum outcome arguments_read(int argc, char **argv, const struct verb *const *verbs, struct arguments *out, struct scree_error *err)
{
    size_t room = (size_t)(argc > 0 ? argc : 1);
    enum outcome outcome = OUTCOME_DONE;
    bool options_end = false;
    *out = (struct arguments){.words = calloc(room, sizeof *out->words), .options = calloc(room, sizeof *out->options)};
    if (!out->words || !out->options)
        return outcome_fail(err, OUTCOME_FAILED, "no memory");
    for (int k = 1; k < argc && !outcome; k++) {
        if (out->verb && out->verb->untouched)
            out->words[out->word_count++] = argv[k];
        else if (!options_end && strcmp(argv[k], "--") == 0)
            options_end = true;
        else if (!options_end && argv[k][0] == '-' && argv[k][1])
            outcome = read_option(argc, argv, &k, out, err);
        else if (!out->verb)
            outcome = read_verb(argv[k], verbs, out, err);
        else
            out->words[out->word_count++] = argv[k];
    }
    return outcome ? outcome : check_words(out, err);
}

void arguments_free(struct arguments *arguments)
{
    free(arguments->words);
    free(arguments->options);
    *arguments = (struct arguments){0};
}

const char *arguments_value(const struct arguments *arguments, const char *name)
{
    for (int k = 0; k < arguments->option_count; k++)
        if (strcmp(arguments->options[k].name, name) == 0)
            return arguments->options[k].value;
    return NULL;
}

bool arguments_flag(const struct arguments *arguments, const char *name)
{
    for (int k = 0; k < arguments->option_count; k++)
        if (strcmp(arguments->options[k].name, name) == 0)
            return true;
    return false;
}

enum outcome arguments_integer(const struct arguments *arguments, const char *name, long long low, long long high,
                               long long fallback, long long *out, struct scree_error *err)
{
    const char *text = arguments_value(arguments, name);
    *out = fallback;
    if (!text)
        return OUTCOME_DONE;
    char *end;
    errno = 0;
    *out = strtoll(text, &end, 10);
    if (errno || end == text || *end || *out < low || *out > high)
        return outcome_fail(err, OUTCOME_REFUSED, "%s: \"%s\" is not a whole number in %lld..%lld", name, text, low, high);
    return OUTCOME_DONE;
}
