/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Options and config file share one table of names. */
#include "config.h"

#include <ctype.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "auth.h"
#include "protocol/frame.h"

const char config_help[] =
    "screed - holds granular worlds in memory and runs them\n"
    "\n"
    "usage: screed [--config FILE] [--listen ENDPOINT] [--data DIR] [--workers N] [--runtime DIR]\n"
    "       screed bench [--case flow|rest|big | --state FILE] ...   (screed bench --help)\n"
    "\n"
    "  --config FILE      read options from FILE: lines `name = value`, # starts a comment\n"
    "  --listen ENDPOINT  control endpoint, ipc://PATH; stream and events sockets lie beside it\n"
    "                     (default: ipc://RUNTIME/control)\n"
    "  --runtime DIR      directory of the sockets, mode 0700\n"
    "                     (default: $SCREE_RUNTIME, $XDG_RUNTIME_DIR/scree, /tmp/scree-UID)\n"
    "  --data DIR         journal and jobs (default: $SCREE_DATA, $XDG_DATA_HOME/scree, ~/.local/share/scree)\n"
    "  --workers N        jobs that run at once (default: one a processor)\n"
    "  --checkpoint-s S   wall time between checkpoints of a running job (default: 60; 0: only when it is steered)\n"
    "  --disk-floor GB    free disk space below which jobs are held (default: 1, or a twentieth of a small disk)\n"
    "  --memory GB        memory for all worlds together; a job that does not fit is held (default: what is free)\n"
    "  --log FILE         append the log to FILE, opened again at SIGHUP (default: stderr)\n"
    "  --ready-fd N       write \"ready\" to file descriptor N once clients can connect\n"
    "  --parent PID       end when process PID ends\n"
    "  --help, --version\n"
    "\n"
    "Runs in the foreground and logs to stderr. SIGTERM ends it after the current slices and a checkpoint of each job,\n"
    "within ten seconds; a second one at once. Jobs that were running go on at the next start.\n"
    "\n"
    "example: screed --data ./data --workers 2 &\n"
    "         scree submit client/examples/slidequake.json\n";

static enum scree_status set_text(char *out, const char *value, const char *name, struct scree_error *err)
{
    if (snprintf(out, CONFIG_PATH_MAX, "%s", value) >= CONFIG_PATH_MAX)
        return scree_fail(err, SCREE_INVALID, name, "%s: more than %d characters", name, CONFIG_PATH_MAX - 1);
    return SCREE_OK;
}

static enum scree_status set_number(int *out, const char *value, const char *name, long low, long high, struct scree_error *err)
{
    char *end;
    errno = 0;
    long number = strtol(value, &end, 10);
    if (errno || *end || end == value || number < low || number > high)
        return scree_fail(err, SCREE_INVALID, name, "%s: \"%s\" is not a whole number in %ld..%ld", name, value, low, high);
    *out = (int)number;
    return SCREE_OK;
}

static enum scree_status set_real(double *out, const char *value, const char *name, double high, struct scree_error *err)
{
    char *end;
    double number = strtod(value, &end);
    if (*end || end == value || !(number >= 0 && number <= high))
        return scree_fail(err, SCREE_INVALID, name, "%s: \"%s\" is not a number in 0..%g", name, value, high);
    *out = number;
    return SCREE_OK;
}

static enum scree_status set_option(struct config *config, const char *name, const char *value, struct scree_error *err)
{
    if (strcmp(name, "checkpoint-s") == 0)
        return set_real(&config->checkpoint_s, value, name, 1e6, err);
    if (strcmp(name, "disk-floor") == 0)
        return set_real(&config->disk_floor_gb, value, name, 1e9, err);
    if (strcmp(name, "memory") == 0)
        return set_real(&config->memory_gb, value, name, 1e9, err);
    if (strcmp(name, "log") == 0)
        return set_text(config->log, value, name, err);
    if (strcmp(name, "listen") == 0)
        return set_text(config->listen, value, name, err);
    if (strcmp(name, "runtime") == 0)
        return set_text(config->runtime, value, name, err);
    if (strcmp(name, "data") == 0)
        return set_text(config->data, value, name, err);
    if (strcmp(name, "workers") == 0)
        return set_number(&config->workers, value, name, 1, 1024, err);
    if (strcmp(name, "ready-fd") == 0)
        return set_number(&config->ready_fd, value, name, 0, 1 << 20, err);
    if (strcmp(name, "parent") == 0)
        return set_number(&config->parent, value, name, 1, 1 << 30, err);
    return scree_fail(err, SCREE_INVALID, name, "unknown option \"%s\"; screed --help lists them", name);
}

static char *trimmed(char *text)
{
    while (isspace((unsigned char)*text))
        text++;
    for (size_t n = strlen(text); n > 0 && isspace((unsigned char)text[n - 1]);)
        text[--n] = 0;
    return text;
}

static enum scree_status read_file(struct config *config, const char *path, struct scree_error *err)
{
    FILE *file = fopen(path, "r");
    if (!file)
        return scree_fail(err, SCREE_INVALID, "config", "cannot read %s: %s", path, strerror(errno));
    char line[CONFIG_PATH_MAX + 64];
    enum scree_status status = SCREE_OK;
    for (int number = 1; !status && fgets(line, sizeof line, file); number++) {
        char *comment = strchr(line, '#');
        if (comment)
            *comment = 0;
        char *name = trimmed(line), *equals = strchr(name, '=');
        if (!*name)
            continue;
        struct scree_error inner = {0};
        if (!equals) {
            status = scree_fail(err, SCREE_INVALID, "config", "%s:%d: `name = value` is expected", path, number);
            break;
        }
        *equals = 0;
        if (set_option(config, trimmed(name), trimmed(equals + 1), &inner))
            status = scree_fail(err, SCREE_INVALID, "config", "%s:%d: %s", path, number, inner.message);
    }
    fclose(file);
    return status;
}

static enum scree_status default_data(struct config *config, struct scree_error *err)
{
    const char *own = getenv("SCREE_DATA"), *data = getenv("XDG_DATA_HOME"), *home = getenv("HOME");
    char path[CONFIG_PATH_MAX];
    if (own && *own)
        return set_text(config->data, own, "data", err);
    if (data && *data)
        snprintf(path, sizeof path, "%s/scree", data);
    else
        snprintf(path, sizeof path, "%s/.local/share/scree", home && *home ? home : "/tmp");
    return set_text(config->data, path, "data", err);
}

/* Clients are told these paths, and work in other directories. */
static enum scree_status make_absolute(char *path, const char *name, struct scree_error *err)
{
    char here[CONFIG_PATH_MAX], whole[2 * CONFIG_PATH_MAX];
    if (*path == '/')
        return SCREE_OK;
    if (!getcwd(here, sizeof here))
        return scree_fail(err, SCREE_IO, name, "cannot tell the working directory: %s", strerror(errno));
    snprintf(whole, sizeof whole, "%s/%s", here, path);
    return set_text(path, whole, name, err);
}

/* Endpoints that were not named, and what is refused. */
static enum scree_status finish(struct config *config, struct scree_error *err)
{
    enum scree_status status;
    if ((!*config->data && (status = default_data(config, err))) || (status = make_absolute(config->data, "data", err)))
        return status;
    if (*config->listen) {
        if ((status = auth_check_endpoint(config->listen, err)))
            return status;
        const char *path = config->listen + strlen("ipc://"), *slash = strrchr(path, '/');
        if (*config->runtime)
            return scree_fail(err, SCREE_INVALID, "listen", "listen: takes the place of runtime; give one of them");
        if (!slash || slash == path)
            return scree_fail(err, SCREE_INVALID, "listen", "listen: %s must name a socket in a directory of its own",
                              config->listen);
        snprintf(config->runtime, sizeof config->runtime, "%.*s", (int)(slash - path), path);
        if (strlen(path) > 107)
            return scree_fail(err, SCREE_INVALID, "listen", "listen: the path has more than the 107 characters of a socket's");
    } else {
        if ((!*config->runtime && (status = protocol_runtime_dir(config->runtime, sizeof config->runtime, err))) ||
            (status = make_absolute(config->runtime, "runtime", err)))
            return status;
        if ((status = protocol_endpoint(config->runtime, "control", config->listen, sizeof config->listen, err)))
            return status;
    }
    if ((status = protocol_endpoint(config->runtime, "stream", config->stream, sizeof config->stream, err)))
        return status;
    return protocol_endpoint(config->runtime, "events", config->events, sizeof config->events, err);
}

enum scree_status config_read(struct config *config, int argc, char **argv, struct scree_error *err)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    *config = (struct config){
        .workers = processors > 0 ? (int)processors : 1, .checkpoint_s = 60, .disk_floor_gb = -1, .memory_gb = -1, .ready_fd = -1};
    enum scree_status status = SCREE_OK;
    /* The file first, so that options override it wherever it stands. */
    for (int pass = 0; pass < 2; pass++)
        for (int k = 1; k < argc && !status; k++) {
            const char *name = argv[k];
            if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
                config->help = true;
                return SCREE_OK;
            }
            if (strcmp(name, "--version") == 0) {
                config->version = true;
                return SCREE_OK;
            }
            if (strncmp(name, "--", 2) != 0)
                return scree_fail(err, SCREE_INVALID, "", "unknown argument \"%s\"; screed --help lists what there is", name);
            char key[64];
            size_t length = strcspn(name + 2, "=");
            snprintf(key, sizeof key, "%.*s", (int)length, name + 2);
            const char *value = name[2 + length] == '=' ? name + 3 + length : k + 1 < argc ? argv[++k] : NULL;
            if (!value)
                return scree_fail(err, SCREE_INVALID, key, "--%s wants a value", key);
            bool file = strcmp(key, "config") == 0;
            if (file == (pass == 0))
                status = file ? read_file(config, value, err) : set_option(config, key, value, err);
        }
    return status ? status : finish(config, err);
}
