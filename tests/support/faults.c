/* SPDX-License-Identifier: GPL-3.0-or-later */
/* A library that is preloaded into screed and lets things go wrong on purpose.
 *
 *   SCREE_FAILPOINT=NAME[:N]    the process is killed at the N-th passage of that failpoint
 *   SCREE_FAULT=KIND:N[:M]      the N-th call of KIND (and the M-1 after it) fails, counted from
 *                               the first failpoint that is passed on, so that start-up does not count
 *   SCREE_FAULT_MARK=FILE       made when a fault has been injected
 *   SCREE_CLOCK=FILE            holds by how many seconds the time of day is ahead: eight bytes, which
 *                               the test may change at any time
 *
 * KIND is write (ENOSPC, regular files only), fsync (EIO), rename (EIO) or malloc
 * (calls from the daemon itself, SQLite, HDF5 and cJSON; libzmq ends the process
 * when memory is refused to it, which is for another test). */
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/time.h>
#include <sys/types.h>
#include <time.h>
#include <unistd.h>

void scree_failpoint(const char *name);

extern void *__libc_malloc(size_t size);
extern void *__libc_calloc(size_t count, size_t size);
extern void *__libc_realloc(void *old, size_t size);
extern void *__libc_memalign(size_t alignment, size_t size);

enum kind { WRITE, FSYNC, RENAME, MALLOC, KINDS };
static const char *const kind_words[KINDS] = {"write", "fsync", "rename", "malloc"};

static enum kind fault_kind = KINDS;
static unsigned long fault_first, fault_count = 1;
static atomic_ulong calls;
static atomic_bool armed, marked;

static struct range {
    uintptr_t from, to;
} ranges[64];
static int range_count;

/* Code of the daemon and of the libraries that must bear a refusal. */
static void read_ranges(void)
{
    static const char *const names[] = {"/screed", "libsqlite3", "libhdf5", "libcjson"};
    char line[512];
    FILE *maps = fopen("/proc/self/maps", "r");
    while (maps && fgets(line, sizeof line, maps)) {
        unsigned long from, to;
        char rights[8];
        bool wanted = false;
        for (size_t k = 0; k < sizeof names / sizeof *names; k++)
            wanted |= strstr(line, names[k]) != NULL;
        if (wanted && range_count < 64 && sscanf(line, "%lx-%lx %7s", &from, &to, rights) == 3 && rights[2] == 'x')
            ranges[range_count++] = (struct range){from, to};
    }
    if (maps)
        fclose(maps);
}

/* ---- the clock ---- */

static const volatile int64_t *clock_ahead;

static void open_clock(const char *path)
{
    int fd = path ? open(path, O_RDONLY | O_CLOEXEC) : -1;
    void *at = fd < 0 ? MAP_FAILED : mmap(NULL, sizeof *clock_ahead, PROT_READ, MAP_SHARED, fd, 0);
    if (at != MAP_FAILED)
        clock_ahead = at;
    if (fd >= 0)
        close(fd);
}

int clock_gettime(clockid_t clock, struct timespec *out)
{
    int failed = (int)syscall(SYS_clock_gettime, clock, out);
    if (!failed && clock_ahead && clock == CLOCK_REALTIME)
        out->tv_sec += *clock_ahead;
    return failed;
}

int gettimeofday(struct timeval *restrict out, void *restrict zone)
{
    struct timespec now;
    (void)zone;
    clock_gettime(CLOCK_REALTIME, &now);
    *out = (struct timeval){now.tv_sec, now.tv_nsec / 1000};
    return 0;
}

time_t time(time_t *out)
{
    struct timespec now;
    clock_gettime(CLOCK_REALTIME, &now);
    if (out)
        *out = now.tv_sec;
    return now.tv_sec;
}

/* ---- orders ---- */

__attribute__((constructor)) static void read_orders(void)
{
    open_clock(getenv("SCREE_CLOCK"));
    const char *fault = getenv("SCREE_FAULT");
    for (int k = 0; fault && k < KINDS; k++) {
        size_t length = strlen(kind_words[k]);
        if (strncmp(fault, kind_words[k], length) == 0 && fault[length] == ':' &&
            sscanf(fault + length + 1, "%lu:%lu", &fault_first, &fault_count) >= 1)
            fault_kind = (enum kind)k;
    }
}

void scree_failpoint(const char *name)
{
    static atomic_ulong passages;
    const char *wanted = getenv("SCREE_FAILPOINT");
    if (fault_kind != KINDS && !atomic_load(&armed)) {
        read_ranges();
        atomic_store(&armed, true);
    }
    if (!wanted)
        return;
    size_t length = strcspn(wanted, ":");
    if (strlen(name) != length || strncmp(name, wanted, length) != 0)
        return;
    unsigned long at = wanted[length] ? strtoul(wanted + length + 1, NULL, 10) : 1;
    if (atomic_fetch_add(&passages, 1) + 1 == at)
        kill(getpid(), SIGKILL);
}

/* One more call of the kind; true if this one is to fail. */
static bool fails(enum kind kind)
{
    if (fault_kind != kind || !atomic_load(&armed))
        return false;
    unsigned long call = atomic_fetch_add(&calls, 1) + 1;
    if (call < fault_first || call >= fault_first + fault_count)
        return false;
    const char *mark = getenv("SCREE_FAULT_MARK");
    if (mark && !atomic_exchange(&marked, true))
        close(open(mark, O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
    return true;
}

static bool is_file(int fd)
{
    struct stat info;
    return fstat(fd, &info) == 0 && S_ISREG(info.st_mode);
}

static bool refused(const void *caller)
{
    uintptr_t at = (uintptr_t)caller;
    if (fault_kind != MALLOC || !atomic_load(&armed))
        return false;
    for (int k = 0; k < range_count; k++)
        if (at >= ranges[k].from && at < ranges[k].to) {
            bool now = fails(MALLOC);
            errno = now ? ENOMEM : errno;
            return now;
        }
    return false;
}

void *malloc(size_t size)
{
    return refused(__builtin_return_address(0)) ? NULL : __libc_malloc(size);
}

void *calloc(size_t count, size_t size)
{
    return refused(__builtin_return_address(0)) ? NULL : __libc_calloc(count, size);
}

void *realloc(void *old, size_t size)
{
    return refused(__builtin_return_address(0)) ? NULL : __libc_realloc(old, size);
}

void *aligned_alloc(size_t alignment, size_t size)
{
    return refused(__builtin_return_address(0)) ? NULL : __libc_memalign(alignment, size);
}

/* The next definition of a function, looked up once. */
#define NEXT(name)                                                                                                                 \
    static __typeof__(name) *next;                                                                                                 \
    if (!next) {                                                                                                                   \
        void *found = dlsym(RTLD_NEXT, #name);                                                                                     \
        memcpy(&next, &found, sizeof next);                                                                                        \
    }

ssize_t write(int fd, const void *data, size_t size)
{
    NEXT(write)
    if (fd > STDERR_FILENO && fault_kind == WRITE && is_file(fd) && fails(WRITE)) {
        errno = ENOSPC;
        return -1;
    }
    return next(fd, data, size);
}

ssize_t pwrite(int fd, const void *data, size_t size, off_t at)
{
    NEXT(pwrite)
    if (fault_kind == WRITE && is_file(fd) && fails(WRITE)) {
        errno = ENOSPC;
        return -1;
    }
    return next(fd, data, size, at);
}

ssize_t pwrite64(int fd, const void *data, size_t size, off64_t at)
{
    NEXT(pwrite64)
    if (fault_kind == WRITE && is_file(fd) && fails(WRITE)) {
        errno = ENOSPC;
        return -1;
    }
    return next(fd, data, size, at);
}

static int sync_fails(void)
{
    errno = EIO;
    return -1;
}

int fsync(int fd)
{
    NEXT(fsync)
    return fails(FSYNC) ? sync_fails() : next(fd);
}

int fdatasync(int fd)
{
    NEXT(fdatasync)
    return fails(FSYNC) ? sync_fails() : next(fd);
}

int rename(const char *from, const char *to)
{
    NEXT(rename)
    return fails(RENAME) ? sync_fails() : next(from, to);
}
