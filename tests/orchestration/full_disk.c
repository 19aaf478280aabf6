/* Preloaded, it lets the disk be full: from the write number fail_at on, whatever would write below
 * the folder FULL_DISK fails. Or it kills: at the change number kill_at (a write, or a file that is made,
 * renamed or removed there) that process and the one that is to be killed with it end by SIGKILL.
 * The counters are shared with all children. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static long *counters; /* writes so far, the first that fails, changes so far, that which kills, and whom */

__attribute__((constructor)) static void begin(void) {
    counters = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    counters[1] = counters[3] = 1L << 60;
}
long *full_disk_counters(void) { return counters; }

static int below(const char *path) {
    const char *folder = getenv("FULL_DISK");
    return folder && counters && path && !strncmp(path, folder, strlen(folder));
}
static int fd_below(int fd) {
    char link[64], path[4096];
    ssize_t length;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return below(path);
}
static void change(int here) {
    if (here && __sync_fetch_and_add(&counters[2], 1) == counters[3]) {
        kill((pid_t)counters[4], SIGKILL);
        kill(getpid(), SIGKILL);
    }
}
static int full(int fd) {
    if (!fd_below(fd)) return 0;
    change(1);
    return __sync_fetch_and_add(&counters[0], 1) >= counters[1];
}

#define REAL(name, ...) ((ssize_t (*)(__VA_ARGS__))dlsym(RTLD_NEXT, name))
#define REFUSE(fd) if (full(fd)) { errno = ENOSPC; return -1; }

ssize_t write(int fd, const void *data, size_t n) {
    REFUSE(fd) return REAL("write", int, const void *, size_t)(fd, data, n);
}
ssize_t writev(int fd, const struct iovec *data, int n) {
    REFUSE(fd) return REAL("writev", int, const struct iovec *, int)(fd, data, n);
}
ssize_t pwrite64(int fd, const void *data, size_t n, off_t at) {
    REFUSE(fd) return REAL("pwrite64", int, const void *, size_t, off_t)(fd, data, n, at);
}
int fsync(int fd) {
    REFUSE(fd) return (int)REAL("fsync", int)(fd);
}
int rename(const char *from, const char *to) {
    change(below(from) || below(to));
    return ((int (*)(const char *, const char *))dlsym(RTLD_NEXT, "rename"))(from, to);
}
int unlink(const char *path) {
    change(below(path));
    return ((int (*)(const char *))dlsym(RTLD_NEXT, "unlink"))(path);
}
int unlinkat(int fd, const char *path, int flags) {
    change(fd == AT_FDCWD ? below(path) : fd_below(fd));
    return ((int (*)(int, const char *, int))dlsym(RTLD_NEXT, "unlinkat"))(fd, path, flags);
}
int rmdir(const char *path) {
    change(below(path));
    return ((int (*)(const char *))dlsym(RTLD_NEXT, "rmdir"))(path);
}
int mkdir(const char *path, mode_t mode) {
    change(below(path));
    return ((int (*)(const char *, mode_t))dlsym(RTLD_NEXT, "mkdir"))(path, mode);
}
