/* SPDX-License-Identifier: GPL-3.0-or-later */
/* See output.h. The only state is what a process has once: its terminals and its locale. */
#include "output.h"

#include <errno.h>
#include <langinfo.h>
#include <locale.h>
#include <math.h>
#include <poll.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ioctl.h>
#include <time.h>
#include <unistd.h>

#include "progress.h"
#include "protocol/json.h"

static struct {
    bool unicode, progress, colour_out, colour_err;
} screen;

void output_start(void)
{
    const char *term = getenv("TERM"), *no_colour = getenv("NO_COLOR");
    bool dumb = !term || !*term || strcmp(term, "dumb") == 0;
    bool colour = !dumb && !(no_colour && *no_colour);
    setlocale(LC_CTYPE, ""); // characters only: numbers keep their decimal point
    screen.unicode = strcmp(nl_langinfo(CODESET), "UTF-8") == 0;
    screen.progress = isatty(STDERR_FILENO) && !dumb;
    screen.colour_out = colour && isatty(STDOUT_FILENO);
    screen.colour_err = colour && isatty(STDERR_FILENO);
}

bool output_progress(void)
{
    return screen.progress;
}

bool output_unicode(void)
{
    return screen.unicode;
}

const char *colour_on(FILE *file, enum colour colour)
{
    static const char *const codes[] = {"", "\x1b[32m", "\x1b[31m", "\x1b[36m", "\x1b[2m", "\x1b[1m"};
    return (file == stderr ? screen.colour_err : screen.colour_out) ? codes[colour] : "";
}

const char *colour_off(FILE *file, enum colour colour)
{
    return *colour_on(file, colour) ? "\x1b[0m" : "";
}

enum colour colour_of_state(const char *state)
{
    if (!state)
        return COLOUR_NONE;
    if (strcmp(state, "done") == 0)
        return COLOUR_GOOD;
    if (strcmp(state, "failed") == 0 || strcmp(state, "held") == 0)
        return COLOUR_BAD;
    return strcmp(state, "running") == 0 ? COLOUR_BUSY : COLOUR_DIM;
}

void put_clean(FILE *file, const char *text)
{
    for (const unsigned char *p = (const unsigned char *)text; *p; p++) {
        if (*p < 0x20 || *p == 0x7f) {
            putc('?', file);
        } else if (*p == 0xc2 && p[1] >= 0x80 && p[1] <= 0x9f) { // the control characters of ISO 8859
            putc('?', file);
            p++;
        } else {
            putc(*p, file);
        }
    }
}

void say(const char *format, ...)
{
    char text[2048];
    va_list arguments;
    va_start(arguments, format);
    vsnprintf(text, sizeof text, format, arguments);
    va_end(arguments);
    progress_erase();
    fflush(stdout);
    fputs("scree: ", stderr);
    put_clean(stderr, text);
    putc('\n', stderr);
}

void say_error(const struct scree_error *err)
{
    say("%s", err->message);
    if (*err->hint)
        say("%s", err->hint);
}

static void put_json(const cJSON *tree, bool pretty)
{
    char *text = json_print(tree, pretty);
    if (!text) {
        say("no memory to print the answer");
        return;
    }
    fputs(text, stdout);
    putchar('\n');
    free(text);
}

void put_json_line(const cJSON *tree)
{
    put_json(tree, false);
    fflush(stdout); // whoever reads lines wants them now
}

void put_json_pretty(const cJSON *tree)
{
    put_json(tree, true);
}

int output_width(void)
{
    struct winsize size;
    if (ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0)
        return size.ws_col;
    return 80;
}

int text_width(const char *text)
{
    int width = 0;
    for (; *text; text++)
        width += ((unsigned char)*text & 0xc0) != 0x80;
    return width;
}

/* Three significant digits and a letter for the power of a thousand. */
static void scale(double value, const char *unit, char out[TEXT_MAX])
{
    static const char *const letters[] = {"", "k", "M", "G", "T"};
    int k = 0;
    for (; value >= 999.5 && k < 4; k++)
        value /= 1000;
    int digits = value < 9.995 ? 2 : value < 99.95 ? 1 : 0;
    snprintf(out, TEXT_MAX, "%.*f %s%s", k ? digits : 0, value, letters[k], unit);
}

char *text_rate(double grain_steps_per_s, char out[TEXT_MAX])
{
    if (!isfinite(grain_steps_per_s) || grain_steps_per_s <= 0) {
        snprintf(out, TEXT_MAX, "-");
        return out;
    }
    static const char *const letters[] = {"", "k ", "M ", "G "};
    int k = 0;
    for (; grain_steps_per_s >= 999.5 && k < 3; k++)
        grain_steps_per_s /= 1000;
    int digits = grain_steps_per_s < 9.995 ? 2 : grain_steps_per_s < 99.95 ? 1 : 0;
    snprintf(out, TEXT_MAX, "%.*f %sgrain-steps/s", digits, grain_steps_per_s, letters[k]);
    return out;
}

char *text_duration(double seconds, char out[TEXT_MAX])
{
    if (!isfinite(seconds) || seconds < 0)
        snprintf(out, TEXT_MAX, "-");
    else if (seconds < 9.95)
        snprintf(out, TEXT_MAX, "%.1f s", seconds);
    else if (seconds < 119.5)
        snprintf(out, TEXT_MAX, "%.0f s", seconds);
    else if (seconds < 600)
        snprintf(out, TEXT_MAX, "%d min %02d s", (int)seconds / 60, (int)seconds % 60);
    else if (seconds < 7200)
        snprintf(out, TEXT_MAX, "%.0f min", seconds / 60);
    else if (seconds < 36000)
        snprintf(out, TEXT_MAX, "%d h %02d min", (int)seconds / 3600, (int)seconds / 60 % 60);
    else if (seconds < 72 * 3600.0)
        snprintf(out, TEXT_MAX, "%.0f h", seconds / 3600);
    else
        snprintf(out, TEXT_MAX, "%.0f days", seconds / 86400);
    return out;
}

char *text_bytes(double bytes, char out[TEXT_MAX])
{
    scale(bytes, "B", out);
    return out;
}

char *text_count(double count, char out[TEXT_MAX])
{
    char digits[TEXT_MAX];
    if (!isfinite(count) || fabs(count) >= 1e15) {
        snprintf(out, TEXT_MAX, "%.4g", count);
        return out;
    }
    int length = snprintf(digits, sizeof digits, "%.0f", count), at = 0;
    for (int k = 0; k < length; k++) {
        if (k && (length - k) % 3 == 0 && digits[k - 1] != '-')
            out[at++] = ',';
        out[at++] = digits[k];
    }
    out[at] = 0;
    return out;
}

char *text_number(double value, char out[TEXT_MAX])
{
    snprintf(out, TEXT_MAX, "%.6g", value);
    return out;
}

double now_s(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

bool output_end(void)
{
    struct pollfd out = {.fd = STDOUT_FILENO};
    progress_erase();
    errno = 0;
    bool failed = fflush(stdout) != 0 || ferror(stdout);
    int why = errno;
    /* Which write failed is forgotten by now, but a pipe whose reader has gone says so again. */
    if (!failed || why == EPIPE || (poll(&out, 1, 0) == 1 && out.revents & (POLLERR | POLLHUP)))
        return true;
    say("cannot write to stdout: %s", why ? strerror(why) : "a write failed");
    return false;
}
