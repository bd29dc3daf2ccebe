/* SPDX-License-Identifier: GPL-3.0-or-later */
/* scree, the command-line client: finds the verb and lets it do its work.
 *
 * The list below is the order of `scree --help`; a verb's own words are in its
 * file. A new one is a file and a line. */
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

#include "manual.h"
#include "output.h"
#include "signals.h"
#include "verbs.h"

static const struct verb *const verbs[] = {&verb_run,    &verb_check,      &verb_submit,    &verb_list,      &verb_show,
                                           &verb_wait,   &verb_watch,      &verb_tail,      &verb_cancel,    &verb_pause,
                                           &verb_resume, &verb_checkpoint, &verb_set,       &verb_fork,      &verb_replay,
                                           &verb_fetch,  &verb_plot,       &verb_scenarios, &verb_materials, &verb_bench,
                                           &verb_keygen, &verb_trust,      &verb_ping,      &verb_shutdown,  NULL};

/* ---- outcomes (cli.h) ---- */

enum outcome outcome_of_status(enum scree_status status)
{
    switch (status) {
    case SCREE_OK:
        return OUTCOME_DONE;
    case SCREE_INVALID:
    case SCREE_NOT_FOUND:
    case SCREE_CONFLICT:  // a job that has ended cannot be steered
    case SCREE_NO_MEMORY: // a world too large for the machine is a spec that is refused
        return OUTCOME_REFUSED;
    case SCREE_BUSY:
        return OUTCOME_TRY_AGAIN;
    case SCREE_CANCELLED:
        return OUTCOME_CANCELLED;
    case SCREE_DENIED:
        return OUTCOME_DENIED;
    case SCREE_IO:
    case SCREE_CORRUPT:
    case SCREE_BLOWUP:
    case SCREE_INTERNAL:
        break;
    }
    return OUTCOME_FAILED;
}

enum outcome outcome_of_state(const char *state)
{
    if (state && strcmp(state, "done") == 0)
        return OUTCOME_DONE;
    return state && strcmp(state, "cancelled") == 0 ? OUTCOME_CANCELLED : OUTCOME_FAILED;
}

enum outcome outcome_fail(struct scree_error *err, enum outcome outcome, const char *format, ...)
{
    char text[SCREE_MESSAGE_MAX];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    scree_fail(err, SCREE_INTERNAL, NULL, "%s", text);
    return outcome;
}

enum outcome give_up(enum outcome outcome, const struct scree_error *err)
{
    if (outcome)
        say_error(err);
    return outcome;
}

/* ---- help ---- */

/* What --help and the manual page say beside the verbs. */
static const char notes[] =
    "ENDPOINT is that of a daemon's control socket, ipc://PATH or tcp://HOST:PORT (scree keygen --help); without\n"
    "--connect it is $SCREE_CONNECT, else ipc://RUNTIME/control with RUNTIME = $SCREE_RUNTIME, $XDG_RUNTIME_DIR/scree or "
    "/tmp/scree-UID.\n"
    "--json prints one JSON object a line. Data go to stdout, messages to stderr. NO_COLOR is honoured.\n\n"
    "exit codes: 0 done, 1 the job failed, 2 usage or a refused spec, 3 cancelled, 69 daemon unreachable,\n"
    "75 try again (queue full), 77 not authorised\n";

static void print_overview(FILE *file)
{
    fputs("scree runs granular-flow simulations and follows them.\n\n"
          "usage: scree [--connect ENDPOINT] [--json] VERB ...\n\n",
          file);
    for (const struct verb *const *verb = verbs; *verb; verb++)
        fprintf(file, "  %-10s %s\n", (*verb)->name, (*verb)->doc);
    fputs("\n  scree VERB --help   what a verb takes, with examples\n"
          "  scree --version, --man (this and all verbs as roff), --completion (for bash)\n\n",
          file);
    fputs(notes, file);
}

static void print_help(const struct verb *verb)
{
    printf("usage: scree %s%s%s\n\n%s\n\n%s", verb->name, *verb->synopsis ? " " : "", verb->synopsis, verb->doc, verb->help);
}

/* `scree help VERB` is `scree VERB --help`. */
static void turn_help_around(int argc, char **argv)
{
    static char help[] = "--help";
    if (argc > 1 && strcmp(argv[1], "help") == 0) {
        if (argc > 2)
            argv[1] = argv[2];
        argv[argc > 2 ? 2 : 1] = help;
    }
}

/* Called without its standard files, a program would take the next file it opens for one. */
static void fill_standard_files(void)
{
    int fd = open("/dev/null", O_RDWR);
    while (fd >= 0 && fd <= STDERR_FILENO)
        fd = dup(fd);
    if (fd > STDERR_FILENO)
        close(fd);
}

int main(int argc, char **argv)
{
    struct arguments arguments;
    struct scree_error err = {.status = SCREE_OK};
    fill_standard_files();
    signals_start();
    output_start();
    turn_help_around(argc, argv);
    enum outcome outcome = arguments_read(argc, argv, verbs, &arguments, &err);
    if (outcome) {
        say_error(&err);
    } else if (arguments.version) {
        printf("scree %s\n", SCREE_VERSION);
    } else if (arguments.man) {
        manual_print(verbs, notes);
    } else if (arguments.completion) {
        completion_print(verbs);
    } else if (arguments.help) {
        if (arguments.verb)
            print_help(arguments.verb);
        else
            print_overview(stdout);
    } else if (!arguments.verb) {
        print_overview(stderr);
        outcome = OUTCOME_REFUSED;
    } else {
        outcome = arguments.verb->run(&arguments);
    }
    arguments_free(&arguments);
    if (!output_end() && outcome == OUTCOME_DONE)
        outcome = OUTCOME_FAILED;
    return (int)outcome;
}
