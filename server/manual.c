/* SPDX-License-Identifier: GPL-3.0-or-later */
/* What screed says of itself: --help and screed(8), both out of the table of
 * options, so that neither can know an option that the other does not. */
#include <string.h>

#include "config.h"

static const char summary[] = "holds granular worlds in memory and runs them";

static const char life[] =
    "Runs in the foreground and logs to stderr. SIGTERM ends it after the current slices; a second one at once. "
    "Jobs that were running go on at the next start.";

/* Prints text broken at `width` columns, later lines indented. */
static void print_broken(FILE *file, const char *text, int indent, int width)
{
    int column = indent;
    while (*text) {
        int length = (int)strcspn(text, " ");
        if (column > indent && column + length >= width) {
            fprintf(file, "\n%*s", indent, "");
            column = indent;
        } else if (column > indent) {
            putc(' ', file);
            column++;
        }
        fprintf(file, "%.*s", length, text);
        column += length;
        text += length + (text[length] == ' ');
    }
    putc('\n', file);
}

void config_print_help(FILE *file)
{
    fprintf(file,
            "screed - %s\n\n"
            "usage: screed [--config FILE] [--OPTION VALUE]...\n"
            "       screed bench [--case flow|rest|big | --state FILE] ...   (screed bench --help)\n\n",
            summary);
    fprintf(file, "  %-26s read options from FILE: lines `name = value`, # starts a comment\n", "--config FILE");
    for (const struct config_option *o = config_options; o->name; o++) {
        char name[64], text[1024];
        snprintf(name, sizeof name, "--%s %s", o->name, o->argument);
        snprintf(text, sizeof text, "%s (default: %s)", o->doc, o->standard);
        fprintf(file, "  %-26s ", name);
        print_broken(file, text, 29, 110);
    }
    fputs("  --help, --version, --man   this text, the build, the manual page as roff\n\n", file);
    print_broken(file, life, 0, 110);
    fputs("\nexample: screed --data ./data --workers 2 &\n"
          "         scree submit client/examples/slidequake.json\n",
          file);
}

/* Text as roff takes it: no minus sign becomes a hyphen, no line starts a request. */
static void print_roff(FILE *file, const char *text)
{
    if (*text == '.' || *text == '\'')
        fputs("\\&", file);
    for (; *text; text++)
        if (*text == '-')
            fputs("\\-", file);
        else if (*text == '\\')
            fputs("\\e", file);
        else
            putc(*text, file);
}

void config_print_man(FILE *file)
{
    fprintf(file, ".TH SCREED 8 \"\" \"scree\" \"System manager's manual\"\n.SH NAME\nscreed \\- %s\n", summary);
    fputs(".SH SYNOPSIS\n.B screed\n[\\fB\\-\\-config\\fR \\fIFILE\\fR]", file);
    fputs(" [\\fB\\-\\-\\fIOPTION\\fR \\fIVALUE\\fR]...\n.SH DESCRIPTION\n", file);
    print_roff(file, life);
    fputs("\n.SH OPTIONS\nEach may stand in the file that \\fB\\-\\-config\\fR names, as a line\n.IR name \" = \" value .\n"
          "The command line has the last word.\n.TP\n.BI \\-\\-config \" FILE\"\nread options from FILE; # starts a comment\n",
          file);
    for (const struct config_option *o = config_options; o->name; o++) {
        fputs(".TP\n\\fB\\-\\-", file);
        print_roff(file, o->name);
        fprintf(file, "\\fR \\fI%s\\fR\n", o->argument);
        print_roff(file, o->doc);
        fputs(" (default: ", file);
        print_roff(file, o->standard);
        fputs(").\n", file);
    }
    fputs(".SH SIGNALS\nSIGTERM and SIGINT end it; see above.\n"
          ".SH FILES\n.TP\n.I RUNTIME/control, stream, events\nthe sockets\n"
          ".TP\n.I DATA/journal.db, jobs/\nevery job, its stream log and its result\n"
          ".TP\n.I KEYS/server.key, trusted\nthe daemon's secret key and whom it lets in; see\n.BR scree (1),\nkeygen and trust\n"
          ".SH EXIT STATUS\n0 ended as asked, 1 failed, 2 wrong options, 75 another daemon is there, 77 files or folders that "
          "others can reach.\n.SH SEE ALSO\n.BR scree (1)\n",
          file);
}
