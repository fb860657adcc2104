#include "machine_name.h"

#include "local_socket.h"

#include <dirent.h>
#include <errno.h>
#include <fcntl.h>
#include <glob.h>
#include <stdlib.h>
#include <string.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#define OF_THE_SYSTEM "/run/hexid"
#define VARIABLE "HEXID_RUNTIME_DIR"

enum { NAMES_TRIED = 99, PATH_SIZE = MACHINE_DIRECTORY_SIZE + MACHINE_NAME_SIZE + 8 };
static const char stop_suffix[] = ".stop";

bool machine_name_valid(const char *name) {
    static const char letters[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";
    size_t length = strlen(name);
    return length > 0 && length < MACHINE_NAME_SIZE && strspn(name, letters) == length;
}

bool machine_address(const struct machine_name *m, bool stop, struct sockaddr_un *address) {
    *address = (struct sockaddr_un){.sun_family = AF_UNIX};
    int length = snprintf(address->sun_path, sizeof address->sun_path, "%s/%s%s", m->directory, m->name, stop ? stop_suffix : "");
    return length < (int)sizeof address->sun_path;
}

/* ---- directories ---- */

struct places {
    char path[MACHINE_PLACES][MACHINE_DIRECTORY_SIZE];
    int count;
    bool more; /* there are further directories, which are not searched */
};

static void add_place(struct places *p, const char *folder, const char *below) {
    char path[MACHINE_DIRECTORY_SIZE];
    bool fits = snprintf(path, sizeof path, "%s%s", folder, below) < (int)sizeof path;
    for (int i = 0; fits && i < p->count; i++)
        if (!strcmp(p->path[i], path)) return;
    p->more |= !fits || p->count == MACHINE_PLACES;
    if (fits && p->count < MACHINE_PLACES) strcpy(p->path[p->count++], path);
}

static const char *chosen(void) {
    const char *path = getenv(VARIABLE);
    return path && *path ? path : NULL;
}

/* Adds the user's own directories, if any: hexid/ in the session's runtime directory, and in the
 * one that systemd makes for the user. */
static void add_own(struct places *p) {
    const char *session = getenv("XDG_RUNTIME_DIR");
    char usual[32];
    snprintf(usual, sizeof usual, "/run/user/%u", (unsigned)geteuid());
    if (session && *session == '/') add_place(p, session, "/hexid");
    if (!access(usual, F_OK)) add_place(p, usual, "/hexid");
}

/* SAFETY: adds the directories of all users for root. Root's stop finds all machines. */
static void add_all_users(struct places *p) {
    glob_t found;
    if (geteuid() != 0) return;
    if (!glob("/run/user/*/hexid", 0, NULL, &found))
        for (size_t i = 0; i < found.gl_pathc; i++) add_place(p, found.gl_pathv[i], "");
    globfree(&found);
}

static struct places where_to_look(void) {
    struct places p = {0};
    if (chosen()) {
        add_place(&p, chosen(), "");
        return p;
    }
    add_place(&p, OF_THE_SYSTEM, "");
    add_own(&p);
    add_all_users(&p);
    return p;
}

void machine_places(char *text, size_t size) {
    struct places p = where_to_look();
    size_t used = 0;
    *text = '\0';
    for (int i = 0; i < p.count && used < size; i++)
        used += (size_t)snprintf(text + used, size - used, "%s%s", used ? ", " : "", p.path[i]);
}

/* Checks that a directory may be used, and finds its owner. */
static int check_place(const char *path, uid_t *owner, struct error *error) {
    struct stat s;
    uid_t own = geteuid();
    if (lstat(path, &s)) return error_set(error, STATUS_IO, "%s: %s", path, strerror(errno));
    const char *wrong = !S_ISDIR(s.st_mode)                                                                ? "it is no directory"
                        : (s.st_mode & (S_IWGRP | S_IWOTH)) && !(s.st_mode & S_ISVTX)                      ? "others may write there"
                        : s.st_uid != 0 && s.st_uid != own && own != 0 && strcmp(path, OF_THE_SYSTEM) != 0 ? "it belongs to another user"
                                                                                                           : NULL;
    *owner = s.st_uid;
    if (!wrong) return STATUS_OK;
    return error_set(error, STATUS_UNSAFE,
                     "%s: %s: commands through it could be another program's; remove it, or name another with " VARIABLE, path, wrong);
}

/* ---- daemon ---- */

/* Creates the directory if it is missing and its parent exists. SAFETY: it is accessible to
 * everybody for stops, whatever the umask. */
static int take_place(const char *path, char directory[MACHINE_DIRECTORY_SIZE], struct error *error) {
    uid_t owner;
    bool made = !mkdir(path, 0755);
    if ((!made && errno != EEXIST) || (made && chmod(path, 0755)))
        return error_set(error, STATUS_IO, "%s: cannot be made: %s", path, strerror(errno));
    int status = check_place(path, &owner, error);
    if (!status && access(path, W_OK | X_OK)) status = error_set(error, STATUS_IO, "%s: %s", path, strerror(errno));
    if (!status) strcpy(directory, path);
    return status;
}

static int choose_place(char directory[MACHINE_DIRECTORY_SIZE], struct error *error) {
    struct places own = {0};
    struct error untrusted;
    uid_t owner;
    if (chosen()) {
        if (strlen(chosen()) >= MACHINE_DIRECTORY_SIZE)
            return error_set(error, STATUS_USAGE, VARIABLE " %.90s...: longer than %d characters", chosen(), MACHINE_DIRECTORY_SIZE - 1);
        return take_place(chosen(), directory, error);
    }
    bool usable = geteuid() == 0 || (!check_place(OF_THE_SYSTEM, &owner, &untrusted) && !access(OF_THE_SYSTEM, W_OK | X_OK));
    if (usable) return take_place(OF_THE_SYSTEM, directory, error);
    add_own(&own);
    error_set(error, STATUS_IO, "neither " OF_THE_SYSTEM " nor a runtime directory of this user is there");
    int status = STATUS_IO;
    for (int i = 0; status && i < own.count; i++) status = take_place(own.path[i], directory, error);
    return status;
}

/* Returns a descriptor that holds the name's lock, or -1 with errno: EWOULDBLOCK or EACCES if
 * another process has it. */
static int lock_name(const struct machine_name *m) {
    char path[PATH_SIZE], process[24];
    struct stat s;
    snprintf(path, sizeof path, "%s/%s.lock", m->directory, m->name);
    int file = open(path, O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (file < 0) return -1;
    bool ours = !fstat(file, &s) && S_ISREG(s.st_mode) && (s.st_uid == geteuid() || s.st_uid == 0 || geteuid() == 0);
    if (!ours) errno = EACCES;
    else fchmod(file, 0600); /* because a file of an older version is readable for everybody */
    if (!ours || flock(file, LOCK_EX | LOCK_NB)) {
        int why = errno;
        close(file);
        errno = why;
        return -1;
    }
    int length = snprintf(process, sizeof process, "%ld\n", (long)getpid());
    /* the process's number in the file is for people only */
    if (!ftruncate(file, 0) && pwrite(file, process, (size_t)length, 0) < 0) errno = 0;
    return file;
}

/* Removes a socket that was left behind: this daemon holds the name's lock, so nobody serves it.
 * Any other file is not hexid's to delete. */
static int clear_address(const struct machine_name *m, bool stop, struct error *error) {
    struct sockaddr_un address;
    struct stat s;
    if (!machine_address(m, stop, &address))
        return error_set(error, STATUS_USAGE, "%s/%s: too long a path for a socket; name another directory with " VARIABLE, m->directory,
                         m->name);
    if (lstat(address.sun_path, &s)) return STATUS_OK;
    if (!S_ISSOCK(s.st_mode))
        return error_set(error, STATUS_UNSAFE, "%s: it is no socket: move it away, or name another directory with " VARIABLE,
                         address.sun_path);
    if (!unlink(address.sun_path)) return STATUS_OK;
    return error_set(error, STATUS_IO, "%s: cannot be replaced: %s", address.sun_path, strerror(errno));
}

static bool others(int why) { return why == EWOULDBLOCK || why == EACCES; }

int machine_claim(const char *name, struct machine_name *m, int *lock, struct error *error) {
    int status = choose_place(m->directory, error);
    if (status) return status;
    snprintf(m->name, sizeof m->name, "%s", *name ? name : MACHINE_NAME_DEFAULT);
    *lock = lock_name(m);
    for (int i = 2; !*name && *lock < 0 && others(errno) && i <= NAMES_TRIED; i++) {
        snprintf(m->name, sizeof m->name, MACHINE_NAME_DEFAULT "-%d", i);
        *lock = lock_name(m);
    }
    if (*lock < 0 && others(errno))
        return error_set(error, STATUS_UNSAFE,
                         "machine.name %s: another hexid of this host has this name (%s/%s.lock): end that one, or give this one another "
                         "name with machine.name",
                         m->name, m->directory, m->name);
    if (*lock < 0) return error_set(error, STATUS_IO, "%s/%s.lock: cannot be made: %s", m->directory, m->name, strerror(errno));
    for (int stop = 0; !status && stop < 2; stop++) status = clear_address(m, stop, error);
    if (status) close(*lock), *lock = -1;
    return status;
}

/* ---- client ---- */

int machine_connect(const struct machine_name *m, bool stop) {
    struct sockaddr_un address;
    struct ucred peer;
    struct error untrusted;
    socklen_t length = sizeof peer;
    uid_t owner;
    errno = ENAMETOOLONG;
    if (!machine_address(m, stop, &address)) return -1;
    int fd = local_socket();
    if (fd < 0) return -1;
    int why = 0;
    if (connect(fd, (const struct sockaddr *)&address, sizeof address)) why = errno;
    else if (check_place(m->directory, &owner, &untrusted) || getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &peer, &length)) why = EPERM;
    else if (peer.uid != 0 && peer.uid != geteuid() && peer.uid != owner) why = EPERM;
    if (!why) return fd;
    close(fd);
    errno = why;
    return -1;
}

/* Returns true if the machine runs: its socket for stops, to which everybody may connect, then
 * accepts a connection or has a full queue. SAFETY: any failure to connect, except that the daemon
 * has ended, is reported as doubt, because the machine may run. */
static bool runs(const struct machine_name *m, struct error *doubt) {
    int fd = machine_connect(m, true), why = errno;
    if (fd >= 0) close(fd);
    if (fd >= 0 || why == EAGAIN) return true;
    if (why != ECONNREFUSED && why != ENOENT)
        error_set(doubt, STATUS_IO, "%s/%s.stop: %s", m->directory, m->name, why == EPERM ? "of another user's program" : strerror(why));
    return false;
}

/* Extracts the name of the machine from the file name of its socket for stops; false for other
 * files. */
static bool name_of(const char *file, char name[MACHINE_NAME_SIZE]) {
    size_t length = strlen(file), end = sizeof stop_suffix - 1;
    if (length <= end || length - end >= MACHINE_NAME_SIZE || strcmp(file + length - end, stop_suffix) != 0) return false;
    snprintf(name, MACHINE_NAME_SIZE, "%.*s", (int)(length - end), file);
    return machine_name_valid(name);
}

static int by_name(const void *a, const void *b) {
    return strcmp(((const struct machine_name *)a)->name, ((const struct machine_name *)b)->name);
}

static int look_in(const char *path, const char *name, struct machine_name list[MACHINES_EACH], struct error *doubt) {
    struct error wrong;
    uid_t owner;
    int count = 0;
    if (access(path, F_OK) && errno == ENOENT) return 0;
    if (check_place(path, &owner, &wrong)) return *doubt = wrong, 0;
    DIR *directory = opendir(path);
    if (!directory) return error_set(doubt, STATUS_IO, "%s: %s", path, strerror(errno)), 0;
    for (struct dirent *entry; (entry = readdir(directory));) {
        struct machine_name m = {0};
        strcpy(m.directory, path);
        if (!name_of(entry->d_name, m.name) || (*name && strcmp(m.name, name) != 0)) continue;
        if (count == MACHINES_EACH) {
            error_set(doubt, STATUS_IO, "%s: more than %d machines", path, MACHINES_EACH);
            break;
        }
        if (runs(&m, doubt)) list[count++] = m;
    }
    closedir(directory);
    qsort(list, (size_t)count, sizeof *list, by_name);
    return count;
}

int machine_find(const char *name, struct machine_name list[MACHINES_MAX], struct error *doubt) {
    struct places p = where_to_look();
    int count = 0;
    *doubt = (struct error){0};
    if (p.more) error_set(doubt, STATUS_IO, "more than %d directories may hold machines, or one has a path too long", MACHINE_PLACES);
    for (int i = 0; i < p.count; i++) count += look_in(p.path[i], name, list + count, doubt);
    return count;
}
