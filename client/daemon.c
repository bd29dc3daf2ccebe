/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See daemon.h.
 *
 * The child leaves our process group, so that Ctrl-C reaches this process alone,
 * which then cancels and tidies up; the kernel sends it SIGTERM when we die
 * (PR_SET_PDEATHSIG), so that even `kill -9` leaves no daemon behind. It says
 * that it listens through a pipe (--ready-fd). */
#include "daemon.h"

#include <errno.h>
#include <fcntl.h>
#include <ftw.h>
#include <poll.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include "output.h"
#include "signals.h"

enum { READY_FD = 3, READY_S = 30, STOP_S = 15 };

enum outcome daemon_program(char out[PATH_MAX], struct scree_error *err)
{
    ssize_t length = readlink("/proc/self/exe", out, PATH_MAX - 1);
    if (length < 0)
        return outcome_fail(err, OUTCOME_FAILED, "cannot find out where this program lies: %s", strerror(errno));
    out[length] = 0;
    char *slash = strrchr(out, '/');
    size_t room = slash ? (size_t)(PATH_MAX - (slash + 1 - out)) : 0;
    if (room < sizeof "screed")
        return outcome_fail(err, OUTCOME_FAILED, "the path of this program is too long");
    snprintf(slash + 1, room, "screed");
    if (access(out, X_OK) != 0) {
        outcome_fail(err, OUTCOME_UNREACHABLE, "no daemon runs, and there is none to start at %s: %s", out, strerror(errno));
        return OUTCOME_UNREACHABLE;
    }
    return OUTCOME_DONE;
}

static int remove_entry(const char *path, const struct stat *info, int kind, struct FTW *walk)
{
    (void)info;
    (void)kind;
    (void)walk;
    remove(path);
    return 0;
}

static void remove_folder(char *path)
{
    if (*path)
        nftw(path, remove_entry, 16, FTW_DEPTH | FTW_PHYS | FTW_MOUNT);
    *path = 0;
}

/* A new folder of ours, mode 0700. */
static enum outcome make_folder(const char *parent, const char *name, char out[PATH_MAX], struct scree_error *err)
{
    if (snprintf(out, PATH_MAX, "%s/%s-XXXXXX", parent, name) >= PATH_MAX || !mkdtemp(out)) {
        enum outcome outcome =
            outcome_fail(err, OUTCOME_REFUSED, "cannot make a folder for a private daemon in %s: %s", parent, strerror(errno));
        *out = 0;
        return outcome;
    }
    return OUTCOME_DONE;
}

/* The folder of its sockets: $TMPDIR, unless a socket's path would get too long there. */
static enum outcome make_runtime(struct daemon *daemon, struct scree_error *err)
{
    const char *temporary = getenv("TMPDIR");
    if (!temporary || *temporary != '/' || strlen(temporary) > 60)
        temporary = "/tmp";
    enum outcome outcome = make_folder(temporary, "scree", daemon->runtime, err);
    if (!outcome)
        snprintf(daemon->endpoint, sizeof daemon->endpoint, "ipc://%.120s/control", daemon->runtime);
    return outcome;
}

/* Between fork and exec: only calls that are safe there. */
static void become_daemon(const char *program, const struct daemon *daemon, int log, int ready, pid_t parent)
{
    int nothing = open("/dev/null", O_RDWR | O_CLOEXEC);
    char fd_text[] = {'0' + READY_FD, 0};
    char *const arguments[] = {
        (char *)program, "--runtime", (char *)daemon->runtime, "--data", (char *)daemon->data, "--workers", "1", "--ready-fd",
        fd_text,         NULL};
    setpgid(0, 0);
    signals_reset();
    prctl(PR_SET_PDEATHSIG, SIGTERM);
    if (getppid() != parent) // it died before the kernel was told
        _exit(1);
    dup2(nothing, STDIN_FILENO);
    dup2(log, STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    if (ready == READY_FD) // last: it may take the place of `log`
        fcntl(ready, F_SETFD, 0);
    else
        dup2(ready, READY_FD);
    execv(program, arguments);
    _exit(127);
}

/* Waits for "ready" on the pipe; its end without it means that the daemon gave up. */
static enum outcome wait_ready(struct daemon *daemon, int pipe_end, struct scree_error *err)
{
    char text[16], last[SCREE_MESSAGE_MAX - 64];
    int interrupts = signals_count();
    for (double start = now_s(); now_s() - start < READY_S;) {
        struct pollfd item = {.fd = pipe_end, .events = POLLIN};
        if (signals_count() > interrupts)
            return outcome_fail(err, OUTCOME_CANCELLED, "interrupted");
        if (poll(&item, 1, WAIT_SLICE_MS) <= 0)
            continue;
        ssize_t got = read(pipe_end, text, sizeof text);
        if (got >= 5 && memcmp(text, "ready", 5) == 0)
            return OUTCOME_DONE;
        if (got < 0 && errno == EINTR)
            continue;
        daemon_last_words(daemon, last, sizeof last);
        return outcome_fail(err, OUTCOME_UNREACHABLE, "the private daemon did not start: %s", *last ? last : "it said nothing");
    }
    return outcome_fail(err, OUTCOME_UNREACHABLE, "the private daemon was not ready within %d s", READY_S);
}

enum outcome daemon_start(const char *folder, struct daemon *daemon, struct scree_error *err)
{
    char program[PATH_MAX], path[PATH_MAX + 16];
    int ready[2] = {-1, -1}, log = -1;
    *daemon = (struct daemon){.pid = 0};
    enum outcome outcome = daemon_program(program, err);
    if (outcome || (outcome = make_folder(folder, ".scree-run", daemon->data, err)) || (outcome = make_runtime(daemon, err)))
        goto out;
    snprintf(path, sizeof path, "%s/screed.log", daemon->data);
    log = open(path, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
    if (log < 0 || pipe2(ready, O_CLOEXEC) != 0) {
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot start a private daemon: %s", strerror(errno));
        goto out;
    }
    pid_t parent = getpid();
    daemon->pid = fork();
    if (daemon->pid == 0)
        become_daemon(program, daemon, log, ready[1], parent);
    if (daemon->pid < 0) {
        daemon->pid = 0;
        outcome = outcome_fail(err, OUTCOME_FAILED, "cannot start a private daemon: %s", strerror(errno));
        goto out;
    }
    close(ready[1]);
    ready[1] = -1;
    outcome = wait_ready(daemon, ready[0], err);
out:
    if (log >= 0)
        close(log);
    for (int k = 0; k < 2; k++)
        if (ready[k] >= 0)
            close(ready[k]);
    if (outcome)
        daemon_stop(daemon, NULL, true);
    return outcome;
}

bool daemon_alive(struct daemon *daemon)
{
    if (daemon->pid > 0 && waitpid(daemon->pid, NULL, WNOHANG) == daemon->pid)
        daemon->pid = 0;
    return daemon->pid > 0;
}

void daemon_last_words(const struct daemon *daemon, char *out, size_t size)
{
    char path[PATH_MAX + 16], line[512];
    *out = 0;
    snprintf(path, sizeof path, "%s/screed.log", daemon->data);
    FILE *file = fopen(path, "r");
    while (file && fgets(line, sizeof line, file)) {
        line[strcspn(line, "\n")] = 0;
        if (*line)
            snprintf(out, size, "%s", line);
    }
    if (file)
        fclose(file);
}

static bool ends_within(struct daemon *daemon, double seconds)
{
    int interrupts = signals_count();
    for (double start = now_s(); now_s() - start < seconds && signals_count() <= interrupts;) {
        if (!daemon_alive(daemon))
            return true;
        wait_ms(20);
    }
    return !daemon_alive(daemon);
}

void daemon_stop(struct daemon *daemon, struct link *link, bool at_once)
{
    if (!at_once && link && daemon_alive(daemon)) {
        struct scree_error ignored;
        cJSON *body = cJSON_CreateObject(), *result = NULL;
        if (body)
            json_put_bool(body, "now", true);
        link_request(link, "shutdown", body, &result, &ignored);
        cJSON_Delete(result);
        ends_within(daemon, STOP_S);
    }
    if (!at_once && daemon_alive(daemon)) {
        kill(daemon->pid, SIGTERM);
        ends_within(daemon, STOP_S);
    }
    if (daemon_alive(daemon)) {
        kill(daemon->pid, SIGKILL);
        waitpid(daemon->pid, NULL, 0);
        daemon->pid = 0;
    }
    remove_folder(daemon->data);
    remove_folder(daemon->runtime);
}
