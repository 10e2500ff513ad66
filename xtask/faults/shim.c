/* Fails or kills at the k-th call of one kind, among those that concern a folder.
 *
 *   FAULT_DIR    absolute path; calls about other files are let through and not counted
 *   FAULT_CALL   open, write, rename, link, fsync
 *   FAULT_K      which call, from 1
 *   FAULT_ERRNO  what it fails with; 0: the process is killed as soon as the call is done, and a
 *                write is only half done
 *   FAULT_ON     not empty: all later calls of that kind fail too, as on a full disk
 *   FAULT_COUNT  a file for the number of calls of each kind, when nothing is to fail
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/types.h>
#include <unistd.h>

enum call { OPEN, WRITE, RENAME, LINK, FSYNC, CALLS };
static const char *const names[CALLS] = {"open", "write", "rename", "link", "fsync"};
static long counts[CALLS];

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int concerns(const char *path)
{
    const char *folder = getenv("FAULT_DIR");
    if (!folder || !path) return 0;
    /* Commands run in the folder. */
    return path[0] != '/' || strncmp(path, folder, strlen(folder)) == 0;
}

static int concerns_fd(int fd)
{
    char link[64], path[PATH_MAX];
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0) return 0;
    path[length] = 0;
    return path[0] == '/' && concerns(path);
}

/* 0: let it through; below 0: kill once it is done; above: fail with this. */
static int fate(enum call call)
{
    long count = __atomic_add_fetch(&counts[call], 1, __ATOMIC_SEQ_CST);
    const char *wanted = getenv("FAULT_CALL"), *k = getenv("FAULT_K"), *on = getenv("FAULT_ON");
    if (!wanted || !k || strcmp(wanted, names[call]) != 0) return 0;
    long at = atol(k);
    if (count != at && !(on && *on && count > at)) return 0;
    const char *number = getenv("FAULT_ERRNO");
    int error = number ? atoi(number) : EIO;
    return error ? error : -1;
}

static long end(int fate, long result)
{
    if (fate < 0) kill(getpid(), SIGKILL);
    return result;
}

#define GUARD(call, about, real)                                        \
    do {                                                                \
        int fate_ = (about) ? fate(call) : 0;                           \
        if (fate_ > 0) { errno = fate_; return -1; }                    \
        return end(fate_, (real));                                      \
    } while (0)

static mode_t mode_of(int flags, va_list rest)
{
    return flags & (O_CREAT | O_TMPFILE) ? va_arg(rest, mode_t) : 0;
}

int open(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = mode_of(flags, rest);
    va_end(rest);
    GUARD(OPEN, concerns(path), REAL(open)(path, flags, mode));
}

int open64(const char *path, int flags, ...)
{
    va_list rest;
    va_start(rest, flags);
    mode_t mode = mode_of(flags, rest);
    va_end(rest);
    GUARD(OPEN, concerns(path), REAL(open64)(path, flags, mode));
}

ssize_t write(int fd, const void *bytes, size_t count)
{
    int fate_ = concerns_fd(fd) ? fate(WRITE) : 0;
    if (fate_ > 0) { errno = fate_; return -1; }
    return end(fate_, REAL(write)(fd, bytes, fate_ < 0 ? count / 2 : count));
}

int rename(const char *from, const char *to)
{
    GUARD(RENAME, concerns(from), REAL(rename)(from, to));
}

int linkat(int from_fd, const char *from, int to_fd, const char *to, int flags)
{
    GUARD(LINK, concerns(from), REAL(linkat)(from_fd, from, to_fd, to, flags));
}

int fsync(int fd)
{
    GUARD(FSYNC, concerns_fd(fd), REAL(fsync)(fd));
}

int fdatasync(int fd)
{
    GUARD(FSYNC, concerns_fd(fd), REAL(fdatasync)(fd));
}

__attribute__((destructor)) static void report(void)
{
    const char *path = getenv("FAULT_COUNT");
    if (!path) return;
    FILE *file = fopen(path, "w");
    if (!file) return;
    for (int call = 0; call < CALLS; call++) fprintf(file, "%s %ld\n", names[call], counts[call]);
    fclose(file);
}
