/* SPDX-License-Identifier: GPL-3.0-or-later */
/* Options and config file share one table of names. */
#include "config.h"

#include <ctype.h>
#include <errno.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "auth.h"
#include "protocol/frame.h"
#include "protocol/keys.h"

#define AT(member) offsetof(struct config, member)

const struct config_option config_options[] = {
    {"listen", "ENDPOINT",
     "ipc://PATH: the control endpoint, in a folder of its own, where the stream and events sockets lie beside it (in place of "
     "runtime). tcp://ADDRESS:PORT: one for the network besides, encrypted and for trusted keys only; streams are on PORT + 1, "
     "events on PORT + 2; ADDRESS is one of this machine's, or 0.0.0.0 or [::] for all. May be given twice, once for each",
     "ipc://RUNTIME/control, no network", CONFIG_TEXT, AT(listen), 0, 0},
    {"runtime", "DIR", "folder of the sockets, mode 0700: whoever can enter it may do everything",
     "$SCREE_RUNTIME, $XDG_RUNTIME_DIR/scree, /tmp/scree-UID", CONFIG_TEXT, AT(runtime), 0, 0},
    {"data", "DIR", "journal and jobs", "$SCREE_DATA, $XDG_DATA_HOME/scree, ~/.local/share/scree", CONFIG_TEXT, AT(data), 0, 0},
    {"workers", "N", "jobs that run at once", "one a processor", CONFIG_NUMBER, AT(workers), 1, 1024},
    {"keys", "DIR", "folder with server.key and the list of trusted keys, mode 0700; read only with a network endpoint",
     "$SCREE_KEYS, $XDG_CONFIG_HOME/scree/keys, ~/.config/scree/keys", CONFIG_TEXT, AT(keys), 0, 0},
    {"max-jobs-per-user", "N", "jobs that a user from the network may have waiting or running", "64", CONFIG_NUMBER, AT(max_jobs),
     1, 1000000},
    {"max-fetches-per-user", "N", "results that a user from the network may have in the making", "8", CONFIG_NUMBER,
     AT(max_fetches), 1, 256},
    {"max-streams-per-user", "N", "streams that a user from the network may have open", "256", CONFIG_NUMBER, AT(max_streams), 1,
     4096},
    {"max-connections", "N", "connections from the network at once; a sixteenth of them, at least 8, may be new and unproven",
     "256", CONFIG_NUMBER, AT(max_connections), 16, 16384},
    {"handshake-s", "N", "seconds within which a connection must have proved who it is", "5", CONFIG_NUMBER, AT(handshake_s), 1,
     60},
    {"stall-s", "N", "seconds after which a running job that does not move stops the service manager's watchdog from being fed",
     "1800", CONFIG_NUMBER, AT(stall_s), 1, 1000000},
    {"checkpoint-s", "S", "wall time between checkpoints of a running job, s; 0: only when it is steered", "60", CONFIG_REAL,
     AT(checkpoint_s), 0, 1e6},
    {"disk-floor", "GB", "free disk space below which jobs are held, GB", "1, or a twentieth of a small disk", CONFIG_REAL,
     AT(disk_floor_gb), 0, 1e9},
    {"memory", "GB", "memory for all worlds together, GB; a job that does not fit is held", "what is free", CONFIG_REAL,
     AT(memory_gb), 0, 1e9},
    {"log", "FILE", "append the log to FILE, which SIGHUP opens anew", "stderr", CONFIG_TEXT, AT(log), 0, 0},
    {"ready-fd", "N", "write \"ready\" to file descriptor N once clients can connect", "none", CONFIG_NUMBER, AT(ready_fd), 0,
     1 << 20},
    {"parent", "PID", "end when process PID ends", "none", CONFIG_NUMBER, AT(parent), 1, 1 << 30},
    {.name = NULL},
};

static enum scree_status set_text(char *out, const char *value, const char *name, struct scree_error *err)
{
    if (snprintf(out, CONFIG_PATH_MAX, "%s", value) >= CONFIG_PATH_MAX)
        return scree_fail(err, SCREE_INVALID, name, "%s: more than %d characters", name, CONFIG_PATH_MAX - 1);
    return SCREE_OK;
}

static enum scree_status set_number(char *field, const char *value, const struct config_option *o, struct scree_error *err)
{
    char *end;
    errno = 0;
    double number = strtod(value, &end);
    bool whole = o->kind == CONFIG_NUMBER;
    if (errno || *end || end == value || !(number >= o->low && number <= o->high) || (whole && number != (double)(int)number))
        return scree_fail(err, SCREE_INVALID, o->name, "%s: \"%s\" is not a %snumber in %.10g..%.10g", o->name, value,
                          whole ? "whole " : "", o->low, o->high);
    if (whole)
        *(int *)(void *)field = (int)number;
    else
        *(double *)(void *)field = number;
    return SCREE_OK;
}

/* `listen` is two: what is reached from this machine and what from others. */
static enum scree_status set_listen(struct config *config, const char *value, struct scree_error *err)
{
    if (strncmp(value, "tcp://", 6) == 0)
        return set_text(config->network, value, "listen", err);
    return set_text(config->listen, value, "listen", err);
}

static enum scree_status set_option(struct config *config, const char *name, const char *value, struct scree_error *err)
{
    for (const struct config_option *o = config_options; o->name; o++) {
        if (strcmp(o->name, name) != 0)
            continue;
        if (o->offset == offsetof(struct config, listen))
            return set_listen(config, value, err);
        char *field = (char *)config + o->offset;
        return o->kind == CONFIG_TEXT ? set_text(field, value, name, err) : set_number(field, value, o, err);
    }
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
    if (*config->network) {
        if (!*config->keys && (status = keys_folder(config->keys, sizeof config->keys, err)))
            return status;
        if ((status = make_absolute(config->keys, "keys", err)) || (status = auth_check_network(config->network, err)))
            return status;
    }
    if ((status = protocol_endpoint(config->runtime, "stream", config->stream, sizeof config->stream, err)))
        return status;
    return protocol_endpoint(config->runtime, "events", config->events, sizeof config->events, err);
}

enum scree_status config_read(struct config *config, int argc, char **argv, struct scree_error *err)
{
    long processors = sysconf(_SC_NPROCESSORS_ONLN);
    *config = (struct config){.workers = processors > 0 ? (int)processors : 1,
                              .checkpoint_s = 60,
                              .disk_floor_gb = -1,
                              .memory_gb = -1,
                              .ready_fd = -1,
                              .max_jobs = 64,
                              .max_fetches = 8,
                              .max_streams = 256,
                              .max_connections = 256,
                              .stall_s = 1800,
                              .handshake_s = 5};
    enum scree_status status = SCREE_OK;
    /* The file first, so that options override it wherever it stands. */
    for (int pass = 0; pass < 2; pass++)
        for (int k = 1; k < argc && !status; k++) {
            const char *name = argv[k];
            if (strcmp(name, "--help") == 0 || strcmp(name, "-h") == 0) {
                config->help = true;
                return SCREE_OK;
            }
            if (strcmp(name, "--version") == 0 || strcmp(name, "--man") == 0) {
                *(name[2] == 'v' ? &config->version : &config->man) = true;
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
