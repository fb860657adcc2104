#include "host_lock.h"

#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <unistd.h>

/* One lock a URL: what a file name cannot hold is replaced. */
static void lock_path(const char *url, char path[NAME_MAX]) {
    const char *folder = access("/run/lock", F_OK) ? "/tmp/" : "/run/lock/";
    int length = snprintf(path, NAME_MAX, "%shexid-%s", folder, url);
    if (length >= NAME_MAX) length = NAME_MAX - 1;
    for (int i = (int)strlen(folder); i < length; i++)
        if (!((path[i] >= 'a' && path[i] <= 'z') || (path[i] >= 'A' && path[i] <= 'Z') || (path[i] >= '0' && path[i] <= '9') ||
              path[i] == '.' || path[i] == '-'))
            path[i] = '_';
}

/* Another user's file is opened without O_CREAT: kernels refuse that in directories
 * that all may write. */
static int open_lock(const char *path) {
    int file = open(path, O_RDWR | O_CLOEXEC | O_NOFOLLOW);
    if (file < 0 && errno == ENOENT) file = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0666);
    return file < 0 && errno == EACCES ? open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW) : file;
}

static int refuse(const char *url, int file, struct error *error) {
    char holder[24] = "";
    ssize_t size = pread(file, holder, sizeof holder - 1, 0);
    holder[size > 0 ? strspn(holder, "0123456789") : 0] = '\0';
    return error_set(error, STATUS_UNSAFE,
                     "--hal %.100s: another hexid on this host drives this machine%s%s: end it first, a machine has "
                     "one master",
                     url, *holder ? ", process " : "", holder);
}

int host_lock(const char *url, struct error *error) {
    char path[NAME_MAX], own[24];
    lock_path(url, path);
    int file = open_lock(path);
    if (file < 0)
        return error_set(error, STATUS_IO, "%.200s: cannot be opened: %s; hexid locks a machine there against a second master", path,
                         strerror(errno));
    if (flock(file, LOCK_EX | LOCK_NB)) {
        int status = refuse(url, file, error);
        close(file);
        return status;
    }
    int length = snprintf(own, sizeof own, "%ld\n", (long)getpid());
    /* for people only */
    if (ftruncate(file, 0) == 0 && pwrite(file, own, (size_t)length, 0) < 0) errno = 0;
    return file;
}
