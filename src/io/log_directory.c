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

/* run_mask is the pattern of a run's name; 0 stands for a digit. The run's number may precede it, a
 * letter (from earlier versions) and the part may follow it, and ".lcm" ends the name. */
enum { NUMBER_DIGITS = 9, NUMBER_MAX = 999999999, TRIES = 100 };
static const char run_mask[] = "0000-00-00T00-00-00Z", part_mask[] = ".0000", ending[] = ".lcm", first_part[] = ".0001.lcm";

struct entry {
    char *name;
    long number; /* number of the run in the file's name; 0: it has none */
    struct timespec written;
    int64_t bytes;
};

static bool fits(const char *name, const char *mask) {
    for (; *mask; mask++, name++)
        if (*mask == '0' ? *name < '0' || *name > '9' : *name != *mask) return false;
    return true;
}

/* Returns the length of the number with its "_"; 0 if there is none. */
static size_t number_length(const char *name, long *number) {
    size_t digits = strspn(name, "0123456789");
    bool has = digits && digits <= NUMBER_DIGITS && name[digits] == '_';
    *number = has ? strtol(name, NULL, 10) : 0;
    return has ? digits + 1 : 0;
}

/* Returns the length of the run's name with its number; 0: this is no log's name. */
static size_t run_length(const char *name) {
    long unused;
    size_t length = number_length(name, &unused);
    if (!fits(name + length, run_mask)) return 0;
    length += sizeof run_mask - 1;
    if (name[length] >= 'b' && name[length] <= 'z') length++;
    size_t part = fits(name + length, part_mask) ? sizeof part_mask - 1 : 0;
    return strcmp(name + length + part, ending) == 0 ? length : 0;
}

static int is_log(const struct dirent *entry) { return run_length(entry->d_name) > 0; }

static int by_age(const void *a, const void *b) {
    const struct entry *one = a, *other = b;
    if (one->number != other->number) return one->number < other->number ? -1 : 1;
    if (one->number) return strcmp(one->name, other->name);
    if (one->written.tv_sec != other->written.tv_sec) return one->written.tv_sec < other->written.tv_sec ? -1 : 1;
    if (one->written.tv_nsec != other->written.tv_nsec) return one->written.tv_nsec < other->written.tv_nsec ? -1 : 1;
    return strcmp(one->name, other->name);
}

/* Collects regular files with logs' names, oldest first. Returns their number. The entries' names
 * point into `found`, which must outlive the entries. */
static int look_at(int directory, struct dirent **found, int count, struct entry *entries) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        struct stat s;
        if (fstatat(directory, found[i]->d_name, &s, AT_SYMLINK_NOFOLLOW) || !S_ISREG(s.st_mode)) continue;
        entries[kept] = (struct entry){.name = found[i]->d_name, .written = s.st_mtim, .bytes = (int64_t)s.st_blocks * 512};
        number_length(entries[kept].name, &entries[kept].number);
        kept++;
    }
    qsort(entries, (size_t)kept, sizeof *entries, by_age);
    return kept;
}

static int open_log(int directory, const char *name) { return openat(directory, name, O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK); }

static bool being_written(int directory, const char *name) {
    int file = open_log(directory, name);
    bool written = file >= 0 && flock(file, LOCK_EX | LOCK_NB);
    if (file >= 0) close(file);
    return written;
}

static bool in_progress(int directory, const struct entry *entries, int count, const char *name) {
    size_t length = run_length(name);
    for (int i = 0; i < count; i++) {
        const char *other = entries[i].name;
        if (run_length(other) == length && !strncmp(other, name, length) && being_written(directory, other)) return true;
    }
    return false;
}

/* Deletes a log that no writer has locked. Returns 1: deleted; 0: being written; -1: errno. */
static int delete_unused(int directory, const char *name) {
    int file = open_log(directory, name);
    if (file < 0) return -1;
    int result = flock(file, LOCK_EX | LOCK_NB) ? 0 : unlinkat(directory, name, 0) ? -1 : 1;
    int reason = errno;
    close(file);
    errno = reason;
    return result;
}

static int prune(int directory, const char *path, const struct entry *entries, int count, int64_t quota_bytes, int64_t *left_bytes,
                 struct error *error) {
    int64_t bytes = 0;
    int status = STATUS_OK;
    for (int i = 0; i < count; i++) bytes += entries[i].bytes;
    /* never deletes the last entry, which is the newest */
    for (int i = 0; i < count - 1 && bytes > quota_bytes; i++) {
        if (in_progress(directory, entries, count, entries[i].name)) continue;
        int deleted = delete_unused(directory, entries[i].name);
        if (deleted > 0) bytes -= entries[i].bytes;
        if (deleted < 0)
            status = error_set(error, STATUS_IO, "%.200s/%.40s: cannot be deleted: %s", path, entries[i].name, strerror(errno));
    }
    *left_bytes = bytes;
    return status;
}

int log_directory_prune(const char *path, int64_t quota_bytes, int64_t *left_bytes, struct error *error) {
    struct dirent **found = NULL;
    int64_t bytes = 0;
    int status = STATUS_OK;
    int directory = open(path, O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    int count = directory < 0 ? -1 : scandirat(directory, ".", &found, is_log, NULL);
    struct entry *entries = count > 0 ? calloc((size_t)count, sizeof *entries) : NULL;
    if (count < 0 || (count > 0 && !entries)) status = error_set(error, STATUS_IO, "%.250s: cannot be read: %s", path, strerror(errno));
    else if (count > 0) status = prune(directory, path, entries, look_at(directory, found, count, entries), quota_bytes, &bytes, error);
    for (int i = 0; i < count; i++) free(found[i]);
    free(found);
    free(entries);
    if (directory >= 0) close(directory);
    if (left_bytes) *left_bytes = bytes;
    return status;
}

/* Returns the largest number of a run in the directory; 0: none; -1: the directory is
 * unreadable. */
static long largest_number(const char *directory) {
    long largest = 0, number;
    DIR *files = opendir(directory);
    if (!files) return -1;
    for (const struct dirent *d; (d = readdir(files));)
        if (is_log(d) && number_length(d->d_name, &number) && number > largest) largest = number;
    closedir(files);
    return largest;
}

int log_directory_create(const char *directory, bool in_parts, char *path, size_t size, struct error *error) {
    char when[32], name[PATH_MAX];
    time_t now = time(NULL);
    struct tm utc;
    strftime(when, sizeof when, "%Y-%m-%dT%H-%M-%SZ", gmtime_r(&now, &utc));
    for (int i = 0; i < TRIES; i++) { /* repeated, because another run may take the number first */
        long number = largest_number(directory);
        if (number < 0) return error_set(error, STATUS_IO, "%.250s: cannot be read: %s", directory, strerror(errno));
        if (number == NUMBER_MAX)
            return error_set(error, STATUS_IO, "%.250s: has a log of number %ld, the largest; rename it, or name another directory",
                             directory, number);
        int length = snprintf(name, sizeof name, "%s/%06ld_%s%s", directory, number + 1, when, in_parts ? first_part : ending);
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

int log_directory_part(const char *first, int number, char *path, size_t size, struct error *error) {
    size_t length = strlen(first) - (sizeof first_part - 1);
    if (number > LOG_PARTS_MAX)
        return error_set(error, STATUS_IO, "%.250s: %d parts are the most: make them larger (--log-part)", first, LOG_PARTS_MAX);
    snprintf(path, size, "%.*s.%04d%s", (int)length, first, number, ending);
    return STATUS_OK;
}
