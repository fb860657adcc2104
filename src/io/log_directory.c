#include "log_directory.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <time.h>
#include <unistd.h>

static const char shape[] = "0000-00-00T00-00-00Z"; /* 0: a digit; then ".lcm", or a letter and ".lcm" */

struct entry {
    char *name;
    struct timespec written;
    int64_t bytes;
};

static bool named_by_us(const char *name) {
    for (size_t i = 0; i < sizeof shape - 1; i++, name++)
        if (shape[i] == '0' ? *name < '0' || *name > '9' : *name != shape[i]) return false;
    if (*name >= 'b' && *name <= 'z') name++;
    return strcmp(name, ".lcm") == 0;
}

static int is_log(const struct dirent *entry) { return named_by_us(entry->d_name); }

static int by_age(const void *a, const void *b) {
    const struct entry *one = a, *other = b;
    if (one->written.tv_sec != other->written.tv_sec) return one->written.tv_sec < other->written.tv_sec ? -1 : 1;
    if (one->written.tv_nsec != other->written.tv_nsec) return one->written.tv_nsec < other->written.tv_nsec ? -1 : 1;
    return strcmp(one->name, other->name);
}

/* Ordinary files alone, oldest first. Returns their number; `entries` and `found` share it. */
static int look_at(int directory, struct dirent **found, int count, struct entry *entries) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        struct stat s;
        if (fstatat(directory, found[i]->d_name, &s, AT_SYMLINK_NOFOLLOW) || !S_ISREG(s.st_mode)) continue;
        entries[kept++] = (struct entry){.name = found[i]->d_name, .written = s.st_mtim, .bytes = (int64_t)s.st_blocks * 512};
    }
    qsort(entries, (size_t)kept, sizeof *entries, by_age);
    return kept;
}

/* 1: deleted; 0: a run is writing it; -1: errno. */
static int delete_unused(int directory, const char *name) {
    int file = openat(directory, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
    if (file < 0) return -1;
    int result = flock(file, LOCK_EX | LOCK_NB) ? 0 : unlinkat(directory, name, 0) ? -1 : 1;
    int reason = errno;
    close(file);
    errno = reason;
    return result;
}

static int prune(int directory, const char *path, const struct entry *entries, int count, int64_t quota_bytes, struct error *error) {
    int64_t bytes = 0;
    int status = STATUS_OK;
    for (int i = 0; i < count; i++) bytes += entries[i].bytes;
    for (int i = 0; i < count - 1 && bytes > quota_bytes; i++) { /* the last is the newest */
        int deleted = delete_unused(directory, entries[i].name);
        if (deleted > 0) bytes -= entries[i].bytes;
        if (deleted < 0) status = error_set(error, STATUS_IO, "%.200s/%.40s: cannot be deleted: %s", path, entries[i].name, strerror(errno));
    }
    return status;
}

int log_directory_prune(const char *path, int64_t quota_bytes, struct error *error) {
    struct dirent **found = NULL;
    int status = STATUS_OK;
    int directory = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int count = directory < 0 ? -1 : scandirat(directory, ".", &found, is_log, NULL);
    struct entry *entries = count > 0 ? calloc((size_t)count, sizeof *entries) : NULL;
    if (count < 0 || (count > 0 && !entries)) status = error_set(error, STATUS_IO, "%.250s: cannot be read: %s", path, strerror(errno));
    else if (count > 0) status = prune(directory, path, entries, look_at(directory, found, count, entries), quota_bytes, error);
    for (int i = 0; i < count; i++) free(found[i]);
    free(found);
    free(entries);
    if (directory >= 0) close(directory);
    return status;
}

int log_directory_create(const char *directory, char *path, size_t size, struct error *error) {
    char when[32], name[PATH_MAX];
    time_t now = time(NULL);
    struct tm utc;
    strftime(when, sizeof when, "%Y-%m-%dT%H-%M-%SZ", gmtime_r(&now, &utc));
    for (char letter = 'a'; letter <= 'z'; letter++) {
        char more[2] = {letter == 'a' ? '\0' : letter, '\0'};
        int length = snprintf(name, sizeof name, "%s/%s%s.lcm", directory, when, more);
        if (length >= (int)sizeof name || length >= (int)size)
            return error_set(error, STATUS_IO, "--log %.100s...: a path of %zu characters and more; name it from nearer by", directory,
                             size);
        memcpy(path, name, (size_t)length + 1);
        int file = open(path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (file >= 0) return close(file);
        if (errno != EEXIST) break;
    }
    return error_set(error, STATUS_IO, "%.250s: cannot be created: %s", path, strerror(errno));
}
