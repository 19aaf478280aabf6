/* Preloaded, it lets the disk be full: from the write number fail_at on, whatever would write below
 * the folder FULL_DISK fails. The counters are shared with all children. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static long *counters; /* writes so far, the first that fails */

__attribute__((constructor)) static void begin(void) {
    counters = mmap(NULL, 4096, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
    counters[1] = 1L << 60;
}
long *full_disk_counters(void) { return counters; }

static int full(int fd) {
    char link[64], path[4096];
    const char *folder = getenv("FULL_DISK");
    ssize_t length;
    if (!folder || !counters) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    length = readlink(link, path, sizeof path - 1);
    if (length < 0 || strncmp(path, folder, strlen(folder))) return 0;
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
