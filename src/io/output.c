#include "output.h"

#include <errno.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/random.h>
#include <sys/syscall.h>
#include <sys/vfs.h>
#include <time.h>
#include <unistd.h>

#include "poll_any.h"
#include "recognise.h"

enum { PROC_MAGIC = 0x9fa0, LINKS_MAX = 40, READER_MS = 5000, TAKES_MS = 10000, STEP_MS = 10, LOCK_MS = 200, ASIDE_MAX = 99999 };

/* ---- paths ---- */

/* Returns the length of the path's directory including its slash; 0: there is none. */
static size_t folder_length(const char *path) {
    const char *slash = strrchr(path, '/');
    return slash ? (size_t)(slash - path) + 1 : 0;
}

static bool of_proc(const char *path) {
    struct statfs fs;
    int link = open(path, O_PATH | O_NOFOLLOW | O_CLOEXEC);
    bool is = link >= 0 && !fstatfs(link, &fs) && fs.f_type == PROC_MAGIC;
    if (link >= 0) close(link);
    return is;
}

int output_place(const char *name, char path[PATH_MAX], bool *in_place) {
    struct stat s;
    char link[PATH_MAX];
    *in_place = false;
    if (snprintf(path, PATH_MAX, "%s", name) >= PATH_MAX) return errno = ENAMETOOLONG, -1;
    for (int links = 0; !lstat(path, &s); links++) {
        if (!S_ISLNK(s.st_mode)) {
            *in_place = !S_ISREG(s.st_mode);
            return 0;
        }
        if (of_proc(path)) {
            *in_place = true;
            return 0;
        }
        ssize_t length = links < LINKS_MAX ? readlink(path, link, sizeof link - 1) : -1;
        if (length < 0) return errno = links < LINKS_MAX ? errno : ELOOP, -1;
        link[length] = '\0';
        size_t folder = *link == '/' ? 0 : folder_length(path);
        if (folder + (size_t)length >= PATH_MAX) return errno = ENAMETOOLONG, -1;
        memcpy(path + folder, link, (size_t)length + 1);
    }
    return errno == ENOENT ? 0 : -1;
}

/* Makes a unique name in the same directory, because a file can be renamed only within its file
 * system. */
static int name_beside(const char *path, char beside[PATH_MAX]) {
    size_t folder = folder_length(path);
    uint64_t number;
    if (getrandom(&number, sizeof number, 0) != sizeof number) return -1;
    int length = snprintf(beside, PATH_MAX, "%.*s.hexid-%016llx.part", (int)folder, path, (unsigned long long)number);
    return length < PATH_MAX ? 0 : (errno = ENAMETOOLONG, -1);
}

/* ---- output in place ---- */

static void wait_ms(int ms) { clock_nanosleep(CLOCK_MONOTONIC, 0, &(struct timespec){.tv_nsec = ms * 1000000L}, NULL); }

/* Opens a file without blocking. If it is a FIFO, it must have a reader, or get one in time. */
static int open_in_place(const char *path, int flags) {
    int file = open(path, O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | flags);
    struct stat s;
    for (int ms = 0; file < 0 && errno == ENXIO && ms < READER_MS && !stat(path, &s) && S_ISFIFO(s.st_mode); ms += STEP_MS) {
        wait_ms(STEP_MS);
        file = open(path, O_WRONLY | O_NONBLOCK | O_NOCTTY | O_CLOEXEC | flags);
    }
    return file;
}

static int refuse_place(const char *name, int reason, struct error *error) {
    struct stat s;
    if (reason == ENXIO && !stat(name, &s) && S_ISFIFO(s.st_mode))
        return error_set(error, STATUS_IO, "%.250s: cannot be written: a FIFO that nobody reads; start its reader first", name);
    return error_set(error, STATUS_IO, "%.250s: cannot be written: %s", name, strerror(reason));
}

/* Returns true if the file is standard output under another name. The output is then written
 * through stdout, after the text printed before. */
static bool is_standard_output(const struct stat *s) {
    struct stat out;
    return !fstat(STDOUT_FILENO, &out) && out.st_dev == s->st_dev && out.st_ino == s->st_ino;
}

static int prepare_in_place(struct output *o, struct error *error) {
    struct stat s;
    if (!stat(o->name, &s) && is_standard_output(&s)) return STATUS_OK;
    if (!stat(o->name, &s) && S_ISBLK(s.st_mode))
        return error_set(error, STATUS_USAGE, "%.250s: is a disk, all of which would be overwritten; name a file", o->name);
    o->file = open_in_place(o->path, O_APPEND);
    return o->file < 0 ? refuse_place(o->name, errno, error) : STATUS_OK;
}

/* Writes all the data. Returns 0 or errno; ETIMEDOUT if the reader accepts nothing for TAKES_MS. */
static int write_all(int file, const char *data, size_t size) {
    while (size > 0) {
        ssize_t written = write(file, data, size);
        if (written < 0 && errno == EAGAIN) {
            if (poll_any(&(struct pollfd){.fd = file, .events = POLLOUT}, 1, TAKES_MS, NULL) == 0) return ETIMEDOUT;
        } else if (written < 0 && errno != EINTR) return errno;
        if (written > 0) data += written, size -= (size_t)written;
    }
    return 0;
}

/* ---- output that replaces a file ---- */

static int refuse_recording(const struct output *o, const char *kind, struct error *error) {
    return error_set(error, STATUS_USAGE, "%.250s: is %s, which would be overwritten; name another file", o->name, kind);
}

/* Removes the temporary file by exactly the call that the confined daemon may use (confine.h). */
static int remove_beside(const struct output *o) { return unlinkat(AT_FDCWD, o->beside, 0); }

/* Checks that the file can be replaced: one that is there must be writable, and it must be possible
 * to create the temporary file, which is tried and undone. */
static int try_beside(struct output *o, struct error *error) {
    bool there = o->before.st_ino != 0;
    int file = there && access(o->path, W_OK) ? -1 : open(o->beside, OUTPUT_FLAGS, 0600);
    if (file < 0)
        return error_set(error, STATUS_IO, "%.250s: cannot be written: %s%s", o->name, strerror(errno),
                         there && !access(o->path, W_OK) ? " in its directory, where it is replaced; name a file in another" : "");
    close(file);
    remove_beside(o);
    return STATUS_OK;
}

int output_prepare(struct output *o, const char *name, enum output_kind kind, struct error *error) {
    bool in_place;
    *o = (struct output){.name = name, .file = -1};
    if (!name) return STATUS_OK;
    o->path = o->path_text;
    if (kind == OUTPUT_NEW && !lstat(name, &o->before))
        return error_set(error, STATUS_IO, "%.250s: is there already and is not overwritten; name another file", name);
    const char *found = recognise(strcmp(name, "-") ? name : "/dev/stdout");
    if (found) return refuse_recording(o, found, error);
    if (!strcmp(name, "-")) return STATUS_OK;
    if (output_place(name, o->path_text, &in_place)) return refuse_place(name, errno, error);
    if (in_place) return prepare_in_place(o, error);
    if (stat(o->path, &o->before)) o->before = (struct stat){0}, o->rename_flags = RENAME_NOREPLACE;
    if (name_beside(o->path, o->beside_text)) return refuse_place(name, errno, error);
    o->beside = o->beside_text;
    return try_beside(o, error);
}

/* Returns true if another file has taken the place of the one to be replaced. */
static bool replaced(const struct output *o) {
    struct stat now;
    return o->before.st_ino && !lstat(o->path, &now) && (now.st_ino != o->before.st_ino || now.st_dev != o->before.st_dev);
}

static int failed(struct output *o, int failure, struct error *error) {
    bool full = failure == ENOSPC || failure == EDQUOT;
    remove_beside(o);
    return error_set(error, STATUS_IO, "%.250s: cannot be written: %s; %s%s", o->name, strerror(failure),
                     full ? "free some space or name another file, " : "",
                     o->before.st_ino ? "the earlier one is left" : "no part of it is left");
}

/* Moves the temporary file into place. A file system without RENAME_NOREPLACE has hard links,
 * which do not replace a file either. Uses only calls that confine.h allows. */
static int put(const struct output *o) {
    if (!syscall(SYS_renameat2, AT_FDCWD, o->beside, AT_FDCWD, o->path, o->rename_flags)) return 0;
    if (errno != EINVAL || !o->rename_flags) return errno;
    return linkat(AT_FDCWD, o->beside, AT_FDCWD, o->path, 0) || remove_beside(o) ? errno : 0;
}

static int take_place(struct output *o, struct error *error) {
    if (replaced(o)) {
        remove_beside(o);
        return error_set(error, STATUS_IO, "%.250s: another file has come there meanwhile, and is not overwritten", o->name);
    }
    int reason = put(o);
    return reason ? failed(o, reason, error) : STATUS_OK;
}

static mode_t mode_of(const struct output *o) { return o->before.st_ino ? o->before.st_mode & 0777 : 0666; }

static int write_beside(struct output *o, const char *text, struct error *error) {
    int file = open(o->beside, OUTPUT_FLAGS, mode_of(o));
    if (file < 0) return refuse_place(o->name, errno, error);
    int failure = write_all(file, text, strlen(text));
    if (!failure && fsync(file)) failure = errno;
    if (close(file) && !failure) failure = errno;
    return failure ? failed(o, failure, error) : take_place(o, error);
}

int output_write(struct output *o, const char *text, struct error *error) {
    if (!o->name) return STATUS_OK;
    if (o->beside) return write_beside(o, text, error);
    if (o->file < 0) { /* standard output; the text follows what was printed before */
        bool bad = fputs(text, stdout) < 0 || fflush(stdout);
        return bad ? error_set(error, STATUS_IO, "%s: cannot be written: %s", o->name, strerror(errno)) : STATUS_OK;
    }
    int failure = write_all(o->file, text, strlen(text));
    output_discard(o);
    return failure ? error_set(error, STATUS_IO, "%.250s: cannot be written: %s", o->name, strerror(failure)) : STATUS_OK;
}

FILE *output_open(struct output *o, struct error *error) {
    if (!o->beside) {
        output_discard(o);
        error_set(error, STATUS_USAGE, "%.250s: such a file is written aside and then moved into place; name a file in a directory",
                  o->name);
        return NULL;
    }
    int file = open(o->beside, OUTPUT_FLAGS, mode_of(o));
    FILE *stream = file < 0 ? NULL : fdopen(file, "w");
    if (stream) return stream;
    refuse_place(o->name, errno, error);
    if (file >= 0) close(file), remove_beside(o);
    return NULL;
}

int output_close(struct output *o, FILE *stream, int failure, struct error *error) {
    if ((fflush(stream) || fsync(fileno(stream))) && !failure) failure = errno;
    if (fclose(stream) && !failure) failure = errno;
    return failure ? failed(o, failure, error) : take_place(o, error);
}

void output_discard(struct output *o) {
    if (o->file >= 0) close(o->file);
    o->file = -1;
}

int output_made(struct output *o, char *text, struct error *error) {
    int status = text ? output_write(o, text, error) : error_set(error, STATUS_IO, "out of memory");
    free(text);
    return status;
}

int output_page(struct output *o, int made, char *page, struct error *error) {
    struct error writing;
    int status = page ? output_write(o, page, &writing) : STATUS_OK;
    free(page);
    if (status) *error = writing;
    return status ? status : made;
}

int output_text(const char *name, const char *text, struct error *error) {
    struct output *o = malloc(sizeof *o);
    if (!o || !text) {
        free(o);
        return error_set(error, STATUS_IO, "out of memory");
    }
    int status = output_prepare(o, name, OUTPUT_RESULT, error);
    if (!status) status = output_write(o, text, error);
    free(o);
    return status;
}

/* ---- logs ---- */

/* Returns true if the descriptor's file still has that name. */
static bool is_at(int file, const char *path) {
    struct stat here, there;
    return !fstat(file, &here) && !stat(path, &there) && here.st_dev == there.st_dev && here.st_ino == there.st_ino;
}

/* Renames without replacing anything. Uses a hard link on a file system without
 * RENAME_NOREPLACE. */
static int move(const char *from, const char *to) {
    if (!syscall(SYS_renameat2, AT_FDCWD, from, AT_FDCWD, to, RENAME_NOREPLACE)) return 0;
    if (errno != EINVAL && errno != ENOSYS) return -1;
    return link(from, to) || unlink(from) ? -1 : 0;
}

static int set_aside(const char *path, char aside[PATH_MAX]) {
    for (int number = 1; number <= ASIDE_MAX; number++) {
        char to[PATH_MAX];
        if (snprintf(to, sizeof to, "%s.%d", path, number) >= PATH_MAX) return errno = ENAMETOOLONG, -1;
        if (!move(path, to)) return strcpy(aside, to), 0;
        if (errno != EEXIST) break;
    }
    return -1;
}

static int refuse_log(int file, const char *path, int reason, struct error *error) {
    if (file >= 0) close(file);
    if (reason == EWOULDBLOCK)
        return error_set(error, STATUS_IO, "%.250s: another process writes this log; name another file, or end that one", path);
    return reason == ENXIO
               ? refuse_place(path, reason, error)
               : error_set(error, STATUS_IO, "%.250s: cannot write the log: %s; name a file that can be written", path, strerror(reason));
}

static int open_log_in_place(const char *path, struct error *error) {
    int file = open_in_place(path, O_APPEND), flags;
    if (file < 0) return refuse_log(file, path, errno, error);
    flags = fcntl(file, F_GETFL);
    fcntl(file, F_SETFL, flags & ~O_NONBLOCK);
    return file;
}

/* Locks a log. Pruning of a log directory keeps each lock only for a moment (log_directory.h); a
 * writer keeps it. Succeeds on a file system without locks, where no other writer can lock it
 * either. */
static bool lock(int file) {
    for (int ms = 0; flock(file, LOCK_EX | LOCK_NB) && errno == EWOULDBLOCK; ms += STEP_MS) {
        if (ms >= LOCK_MS) return false;
        wait_ms(STEP_MS);
    }
    return true;
}

/* Opens and locks the log; the holder of the lock may set an earlier log aside. If the file has
 * lost its name before it was locked, another process has set it aside, and this one tries
 * again. */
static int open_log_file(const char *path, char aside[PATH_MAX], struct error *error) {
    struct stat s;
    for (;;) {
        int file = open(path, O_WRONLY | O_CREAT | O_APPEND | O_NOFOLLOW | O_NONBLOCK | O_NOCTTY | O_CLOEXEC, 0666);
        if (file < 0) return refuse_log(file, path, errno, error);
        if (!lock(file)) return refuse_log(file, path, EWOULDBLOCK, error);
        bool ours = !fstat(file, &s) && is_at(file, path);
        if (ours && !s.st_size) return file;
        if (ours && set_aside(path, aside)) return refuse_log(file, path, errno, error);
        close(file);
    }
}

int output_log(const char *name, char aside[PATH_MAX], struct error *error) {
    char path[PATH_MAX];
    bool in_place;
    struct stat s;
    *aside = '\0';
    if (output_place(name, path, &in_place)) return refuse_log(-1, name, errno, error);
    if (!stat(name, &s) && S_ISDIR(s.st_mode)) return refuse_log(-1, name, EISDIR, error);
    if (!stat(name, &s) && S_ISBLK(s.st_mode))
        return error_set(error, STATUS_USAGE, "%.250s: is a disk, all of which would be overwritten; name a file", name);
    const char *kind = in_place ? NULL : recognise(path);
    if (kind && strcmp(kind, recognise_log))
        return error_set(error, STATUS_USAGE, "%.250s: is %s, which would be moved for a log; name another file", name, kind);
    return in_place ? open_log_in_place(path, error) : open_log_file(path, aside, error);
}
