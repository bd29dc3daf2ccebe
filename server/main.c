/* SPDX-License-Identifier: GPL-3.0-or-later */
/* screed: the daemon, and the bare engine's benchmark. */
#include <signal.h>
#include <stdio.h>
#include <string.h>
#include <sys/resource.h>

#include "bench.h"
#include "config.h"
#include "control.h"
#include "scree.h"

enum { EXIT_USAGE = 2, EXIT_AGAIN = 75, EXIT_DENIED = 77 };

static int exit_code(enum scree_status status)
{
    return status == SCREE_INVALID ? EXIT_USAGE : status == SCREE_BUSY ? EXIT_AGAIN : status == SCREE_DENIED ? EXIT_DENIED : 1;
}

static int complain(const struct scree_error *error)
{
    fprintf(stderr, "screed: %s\n", error->message);
    if (*error->hint)
        fprintf(stderr, "screed: %s\n", error->hint);
    return exit_code(error->status);
}

int main(int argc, char **argv)
{
    struct config config;
    struct scree_error error = {0};
    sigset_t signals;
    if (argc > 1 && strcmp(argv[1], "bench") == 0)
        return bench_main(argc - 1, argv + 1);
    if (config_read(&config, argc, argv, &error))
        return complain(&error);
    if (config.help || config.version || config.man) {
        if (config.help)
            config_print_help(stdout);
        else if (config.man)
            config_print_man(stdout);
        else
            printf("screed %s\n", scree_build());
        return 0;
    }
    /* Every client, stream and result takes descriptors, and libzmq aborts when there are none. */
    struct rlimit files;
    if (getrlimit(RLIMIT_NOFILE, &files) == 0) {
        files.rlim_cur = files.rlim_max;
        setrlimit(RLIMIT_NOFILE, &files);
    }
    /* Blocked before any thread starts: signals are read from a descriptor by the control thread. */
    sigemptyset(&signals);
    sigaddset(&signals, SIGTERM);
    sigaddset(&signals, SIGINT);
    sigaddset(&signals, SIGHUP);
    sigprocmask(SIG_BLOCK, &signals, NULL);
    signal(SIGPIPE, SIG_IGN);
    return control_run(&config, &error) ? complain(&error) : 0;
}
