/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What every verb of the client shares: outcomes, arguments, the descriptor of a verb.
 *
 * A verb is one file with one const descriptor; main.c lists them. A new verb
 * is a new file and a line there. */
#ifndef SCREE_CLIENT_CLI_H
#define SCREE_CLIENT_CLI_H

#include <stdbool.h>

#include "base/status.h"

/* How a call of the client ends: the process's exit code. Functions that can
 * fail return one and leave the message in a struct scree_error. */
enum outcome {
    OUTCOME_DONE = 0,
    OUTCOME_FAILED = 1,       // the job failed, or a file or the daemon did
    OUTCOME_REFUSED = 2,      // usage, a spec that is not accepted, an unknown job
    OUTCOME_CANCELLED = 3,    // the job was cancelled
    OUTCOME_UNREACHABLE = 69, // no daemon, or one that does not answer
    OUTCOME_TRY_AGAIN = 75,   // the queue is full
    OUTCOME_DENIED = 77       // not authorised
};

/* The outcome of a command that the daemon refused with this status. */
enum outcome outcome_of_status(enum scree_status status);

/* The outcome of a job in that state: done, failed, cancelled. */
enum outcome outcome_of_state(const char *state);

/* Fills *err and returns `outcome`. */
enum outcome outcome_fail(struct scree_error *err, enum outcome outcome, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

struct arguments;

struct verb {
    const char *name;
    const char *synopsis; // what follows the name: "FILE [--set path=value]... [-o DIR|FILE.h5]"
    const char *doc;      // one line for the list of verbs
    const char *help;     // paragraphs and examples for --help
    /* Options beside the global ones, NULL-terminated: "--again" is a flag,
     * "--from=" takes a value, "--set=*" takes one and may be repeated. */
    const char *const *options;
    int words_min, words_max; // words that are neither options nor their values; words_max -1: any number
    bool untouched;           // everything behind the verb is handed over as it stands
    enum outcome (*run)(const struct arguments *arguments);
};

struct given_option {
    const char *name;  // "--set"
    const char *value; // NULL for a flag
};

/* The command line, taken apart. Points into argv. */
struct arguments {
    const struct verb *verb;
    const char *connect; // --connect, or NULL
    bool json, help, version, man, completion;
    const char **words;
    int word_count;
    struct given_option *options;
    int option_count;
};

/* Takes argv apart; `verbs` is NULL-terminated. Release with arguments_free. */
enum outcome arguments_read(int argc, char **argv, const struct verb *const *verbs, struct arguments *out, struct scree_error *err);
void arguments_free(struct arguments *arguments);

/* Value of an option, NULL when it was not given. */
const char *arguments_value(const struct arguments *arguments, const char *name);
bool arguments_flag(const struct arguments *arguments, const char *name);

/* A whole number out of low..high, `fallback` when the option was not given. */
enum outcome arguments_integer(const struct arguments *arguments, const char *name, long long low, long long high,
                               long long fallback, long long *out, struct scree_error *err);

/* Prints a failure and returns its outcome, so that a verb can end with it. */
enum outcome give_up(enum outcome outcome, const struct scree_error *err);

#endif
