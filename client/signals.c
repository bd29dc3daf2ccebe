/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See signals.h. */
#include "signals.h"

#include <poll.h>
#include <signal.h>
#include <string.h>
#include <unistd.h>

#include "cli.h"

static volatile sig_atomic_t caught, last;

static const int interrupts[] = {SIGINT, SIGTERM, SIGHUP};

static void on_interrupt(int signal_number)
{
    last = signal_number;
    if (++caught >= 3)
        _exit(OUTCOME_CANCELLED);
}

static void set_handler(int signal_number, void (*handler)(int))
{
    struct sigaction action;
    memset(&action, 0, sizeof action);
    action.sa_handler = handler; // no SA_RESTART: a wait is to be cut short
    sigemptyset(&action.sa_mask);
    sigaction(signal_number, &action, NULL);
}

void signals_start(void)
{
    set_handler(SIGPIPE, SIG_IGN);
    set_handler(SIGXFSZ, SIG_IGN);
}

void signals_catch(void)
{
    for (int k = 0; k < 3; k++) {
        struct sigaction now;
        /* `nohup` and background jobs of a plain shell have them ignored; so they stay. */
        if (sigaction(interrupts[k], NULL, &now) == 0 && now.sa_handler == SIG_IGN)
            continue;
        set_handler(interrupts[k], on_interrupt);
    }
}

int signals_count(void)
{
    return caught;
}

void signals_die(void)
{
    int signal_number = last ? last : SIGINT;
    set_handler(signal_number, SIG_DFL);
    raise(signal_number);
}

void signals_reset(void)
{
    sigset_t none;
    for (int k = 0; k < 3; k++)
        set_handler(interrupts[k], SIG_DFL);
    set_handler(SIGPIPE, SIG_DFL);
    set_handler(SIGXFSZ, SIG_DFL);
    sigemptyset(&none);
    sigprocmask(SIG_SETMASK, &none, NULL);
}

void wait_ms(int milliseconds)
{
    for (int seen = caught; milliseconds > 0 && caught == seen; milliseconds -= WAIT_SLICE_MS)
        poll(NULL, 0, milliseconds < WAIT_SLICE_MS ? milliseconds : WAIT_SLICE_MS);
}
