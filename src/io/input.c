#include "input.h"

#include <errno.h>
#include <fcntl.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

static const char *kind_refused(mode_t mode) {
    if (S_ISDIR(mode)) return strerror(EISDIR);
    if (S_ISFIFO(mode)) return "a FIFO, which may never end: copy what comes out of it into a file";
    return "a device or a socket, which may never end: name a regular file";
}

int input_open(const char *path, const char **reason) {
    struct stat s;
    int file = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
    if (file >= 0 && !fstat(file, &s) && S_ISREG(s.st_mode)) return file;
    *reason = file < 0 ? strerror(errno) : kind_refused(s.st_mode);
    if (file >= 0) close(file);
    return -1;
}
