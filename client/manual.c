/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See manual.h. */
#include "manual.h"

#include <ctype.h>
#include <stdio.h>
#include <string.h>

/* ---- scree(1) ---- */

/* Text as roff takes it: no minus sign becomes a hyphen, no line starts a request. */
static void put_roff(const char *text)
{
    for (bool fresh = true; *text; text++) {
        if (fresh && (*text == '.' || *text == '\''))
            fputs("\\&", stdout);
        fresh = *text == '\n';
        if (*text == '-')
            fputs("\\-", stdout);
        else if (*text == '\\')
            fputs("\\e", stdout);
        else
            putchar(*text);
    }
}

static void put_verb(const struct verb *verb)
{
    printf(".SS %s", verb->name);
    if (*verb->synopsis) {
        putchar(' ');
        put_roff(verb->synopsis);
    }
    putchar('\n');
    put_roff(verb->doc);
    fputs(".\n.PP\n.nf\n", stdout); // help is laid out for a terminal, with examples
    put_roff(verb->help);
    fputs(".fi\n", stdout);
}

void manual_print(const struct verb *const *verbs, const char *notes)
{
    fputs(".TH SCREE 1 \"\" \"scree\" \"User commands\"\n.SH NAME\nscree \\- run granular\\-flow simulations and follow them\n"
          ".SH SYNOPSIS\n.B scree\n[\\fB\\-\\-connect\\fR \\fIENDPOINT\\fR] [\\fB\\-\\-json\\fR] \\fIVERB\\fR ...\n"
          ".SH DESCRIPTION\n.nf\n",
          stdout);
    put_roff(notes);
    fputs(".fi\n.SH VERBS\n", stdout);
    for (; *verbs; verbs++)
        put_verb(*verbs);
    fputs(".SH SEE ALSO\n.BR screed (8)\n", stdout);
}

/* ---- bash ---- */

/* The words that an option's value may be, as the synopsis says them: "--format csv|ndjson|raw". */
static void put_choices(const struct verb *verb, const char *option)
{
    size_t length = strcspn(option, "=");
    for (const char *at = strstr(verb->synopsis, "--"); at; at = strstr(at + 2, "--")) {
        if (strncmp(at, option, length) != 0 || at[length] != ' ')
            continue;
        const char *value = at + length + 1;
        size_t size = strspn(value, "abcdefghijklmnopqrstuvwxyz0123456789|-");
        if (!memchr(value, '|', size) || isupper((unsigned char)value[size]))
            return;
        printf("        '%s %.*s') choices='", verb->name, (int)length, option);
        for (size_t k = 0; k < size; k++)
            putchar(value[k] == '|' ? ' ' : value[k]);
        puts("' ;;");
        return;
    }
}

static void put_options(const struct verb *verb)
{
    printf("        %s) options='", verb->name);
    for (const char *const *option = verb->options; option && *option; option++)
        printf("%s%.*s", option == verb->options ? "" : " ", (int)strcspn(*option, "="), *option);
    puts("' ;;");
}

/* What the words of a verb are: ids of jobs, names, or files. */
static void put_words(const struct verb *verb)
{
    if (strncmp(verb->synopsis, "ID", 2) == 0)
        printf("        %s) words=$(scree --json list 2>/dev/null | sed -n 's/^{\"id\":\"\\([a-z0-9]*\\)\".*/\\1/p') ;;\n",
               verb->name);
    else if (strcmp(verb->name, "scenarios") == 0 || strcmp(verb->name, "materials") == 0)
        printf("        %s) words=$(scree --json %s 2>/dev/null | sed -n 's/^{\"name\":\"\\([^\"]*\\)\".*/\\1/p') ;;\n", verb->name,
               verb->name);
}

void completion_print(const struct verb *const *verbs)
{
    fputs("# bash completion of scree, written by scree --completion\n"
          "_scree() {\n"
          "    local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} verb='' options='' words='' choices='' k\n"
          "    local verbs='",
          stdout);
    for (const struct verb *const *verb = verbs; *verb; verb++)
        printf("%s%s", verb == verbs ? "" : " ", (*verb)->name);
    fputs("'\n"
          "    for ((k = 1; k < COMP_CWORD; k++)); do\n"
          "        case ${COMP_WORDS[k]} in\n"
          "        --connect) ((k++)) ;;\n"
          "        -*) ;;\n"
          "        *) verb=${COMP_WORDS[k]}; break ;;\n"
          "        esac\n"
          "    done\n"
          "    if [ -z \"$verb\" ]; then\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$verbs --connect --json --help --version\" -- \"$word\")\n"
          "        return\n"
          "    fi\n"
          "    case \"$verb $before\" in\n",
          stdout);
    for (const struct verb *const *verb = verbs; *verb; verb++)
        for (const char *const *option = (*verb)->options; option && *option; option++)
            if (strchr(*option, '='))
                put_choices(*verb, *option);
    fputs("    esac\n"
          "    if [ -n \"$choices\" ]; then\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$choices\" -- \"$word\")\n"
          "        return\n"
          "    fi\n"
          "    if [[ $word == -* ]]; then\n"
          "        case $verb in\n",
          stdout);
    for (const struct verb *const *verb = verbs; *verb; verb++)
        put_options(*verb);
    fputs("        esac\n"
          "        mapfile -t COMPREPLY < <(compgen -W \"$options --connect --json --help\" -- \"$word\")\n"
          "        return\n"
          "    fi\n"
          "    case $verb in\n",
          stdout);
    for (const struct verb *const *verb = verbs; *verb; verb++)
        put_words(*verb);
    fputs("        *) mapfile -t COMPREPLY < <(compgen -f -- \"$word\"); return ;;\n"
          "    esac\n"
          "    mapfile -t COMPREPLY < <(compgen -W \"$words\" -- \"$word\")\n"
          "}\n"
          "complete -o filenames -F _scree scree\n",
          stdout);
}
