#include "new_file.h"

#include <errno.h>
#include <stdbool.h>
#include <string.h>
#include <unistd.h>

FILE *new_file(const char *path, struct error *error) {
    FILE *file = fopen(path, "wxe");
    if (!file && errno == EEXIST) error_set(error, STATUS_IO, "%.250s: is there already and is not overwritten; name another file", path);
    else if (!file) error_set(error, STATUS_IO, "%.250s: cannot be written: %s", path, strerror(errno));
    return file;
}

int new_file_fail(const char *path, int failure, struct error *error) {
    bool full = failure == ENOSPC || failure == EDQUOT;
    unlink(path);
    return error_set(error, STATUS_IO, "%.250s: cannot be written: %s; %sno part of it is left", path, strerror(failure),
                     full ? "free some space or name another file, " : "");
}

int new_file_close(FILE *file, const char *path, int failure, struct error *error) {
    if (fclose(file) && !failure) failure = errno;
    return failure ? new_file_fail(path, failure, error) : STATUS_OK;
}
