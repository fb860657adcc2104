#include "log_keeper.h"

#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <string.h>
#include <sys/file.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include "confine.h"
#include "log_directory.h"
#include "poll_any.h"

enum { PATIENCE_MS = 5000 };

struct answer {
    struct error error;    /* error of the request; status 0: a descriptor comes with the answer */
    bool over;
    char path[PATH_MAX];
};

/* ---- the keeper's process ---- */

static int send_answer(int socket, const struct answer *a, int file) {
    _Alignas(struct cmsghdr) char control[CMSG_SPACE(sizeof file)] = {0};
    struct iovec data = {.iov_base = (void *)(uintptr_t)a, .iov_len = sizeof *a};
    struct msghdr message = {.msg_iov = &data, .msg_iovlen = 1};
    if (file >= 0) {
        message.msg_control = control, message.msg_controllen = sizeof control;
        struct cmsghdr *c = CMSG_FIRSTHDR(&message);
        c->cmsg_level = SOL_SOCKET, c->cmsg_type = SCM_RIGHTS, c->cmsg_len = CMSG_LEN(sizeof file);
        memcpy(CMSG_DATA(c), &file, sizeof file);
    }
    return sendmsg(socket, &message, MSG_NOSIGNAL) < 0 ? -1 : 0;
}

/* Creates the next part that does not exist yet; -1 with the error in the answer. */
static int create(const char *first, int *number, struct answer *a) {
    int file;
    do {
        if (log_directory_part(first, *number, a->path, sizeof a->path, &a->error)) return -1;
        file = open(a->path, O_WRONLY | O_CREAT | O_EXCL | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
    } while (file < 0 && errno == EEXIST && ++*number);
    if (file < 0) error_set(&a->error, STATUS_IO, "%.250s: cannot be created: %s", a->path, strerror(errno));
    return file;
}

/* Makes the next part. The file is created before room is made for it, because its lock then shows
 * that the run is in progress. */
static int make_part(const char *first, int *number, int64_t quota_bytes, struct answer *a) {
    char directory[PATH_MAX];
    int64_t left_bytes = 0;
    struct error ignored; /* not reported: files that cannot be deleted count as over the quota */
    *a = (struct answer){0};
    int file = create(first, number, a);
    if (file >= 0) flock(file, LOCK_EX | LOCK_NB);
    const char *slash = strrchr(first, '/');
    snprintf(directory, sizeof directory, "%.*s", slash ? (int)(slash - first) : 1, slash ? first : ".");
    if (quota_bytes > 0) log_directory_prune(*directory ? directory : "/", quota_bytes, &left_bytes, &ignored);
    a->over = quota_bytes > 0 && left_bytes > quota_bytes;
    if (file < 0 && quota_bytes > 0) { /* deleting logs may have made room */
        a->error = (struct error){0};
        file = create(first, number, a);
        if (file >= 0) flock(file, LOCK_EX | LOCK_NB);
    }
    if (file >= 0) ++*number;
    return file;
}

/* Removes a part made in advance that the run did not use. */
static void remove_unused(const char *path) {
    struct stat s;
    if (*path && !stat(path, &s) && !s.st_size) unlink(path);
}

static void serve(int socket, const char *first, int64_t quota_bytes) {
    static struct answer a;
    char question, last[PATH_MAX] = "";
    for (int number = 2;;) {
        ssize_t size = recv(socket, &question, sizeof question, 0);
        if (size < 0 && errno == EINTR) continue;
        if (size <= 0) break;
        int file = make_part(first, &number, quota_bytes, &a);
        int refused = send_answer(socket, &a, file);
        if (file >= 0) memcpy(last, a.path, sizeof last), close(file);
        if (refused) break;
    }
    remove_unused(last);
}

/* Turns the child into the keeper. It closes the descriptors inherited from the daemon, so that a
 * daemon that ends leaves no bus open, and blocks all signals, which are for the daemon. */
static void become_keeper(int socket, const char *first, int64_t quota_bytes) {
    sigset_t all;
    sigfillset(&all);
    sigprocmask(SIG_SETMASK, &all, NULL);
    int nothing = open("/dev/null", O_RDWR);
    for (int i = 0; i < 3 && nothing >= 0; i++) dup2(nothing, i);
    if (dup2(socket, 3) != 3 || close_range(4, ~0u, 0)) _exit(1);
    prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
    confine_thread();
    if (send(3, "r", 1, MSG_NOSIGNAL) == 1) serve(3, first, quota_bytes);
    _exit(0);
}

/* ---- the recorder's end ---- */

/* Waits for an answer and drops it. Returns its size, 0 if the process has ended, -1 if nothing
 * came in time. */
static ssize_t hear(int socket, int wait_ms) {
    static struct answer a;
    struct pollfd p = {.fd = socket, .events = POLLIN};
    return poll_any(&p, 1, wait_ms, NULL) > 0 ? recv(socket, &a, sizeof a, MSG_DONTWAIT) : -1;
}

int log_keeper_start(struct log_keeper *k, const char *first, int64_t quota_bytes, struct error *error) {
    int ends[2];
    *k = (struct log_keeper){.socket = -1};
    if (socketpair(AF_UNIX, SOCK_SEQPACKET | SOCK_CLOEXEC, 0, ends))
        return error_set(error, STATUS_IO, "--log-part: no socket: %s", strerror(errno));
    pid_t process = fork();
    if (process == 0) become_keeper(ends[1], first, quota_bytes);
    int reason = errno;
    close(ends[1]);
    if (process < 0) {
        close(ends[0]);
        return error_set(error, STATUS_IO, "--log-part: no process for it: %s", strerror(reason));
    }
    k->socket = ends[0];
    if (hear(k->socket, PATIENCE_MS) > 0) return STATUS_OK;
    log_keeper_stop(k);
    return error_set(error, STATUS_IO, "--log-part: the process that makes the parts does not begin");
}

void log_keeper_stop(struct log_keeper *k) {
    if (k->socket < 0) return;
    shutdown(k->socket, SHUT_WR);
    while (hear(k->socket, PATIENCE_MS) > 0) continue;
    close(k->socket);
    k->socket = -1;
}

void log_keeper_ask(struct log_keeper *k) {
    if (k->asked) return;
    /* a failure is ignored here: if the process has ended, log_keeper_take() reports it */
    send(k->socket, "n", 1, MSG_DONTWAIT | MSG_NOSIGNAL);
    k->asked = true;
}

static int received_file(struct msghdr *message) {
    int file = -1;
    for (struct cmsghdr *c = CMSG_FIRSTHDR(message); c; c = CMSG_NXTHDR(message, c))
        if (c->cmsg_level == SOL_SOCKET && c->cmsg_type == SCM_RIGHTS) memcpy(&file, CMSG_DATA(c), sizeof file);
    return file;
}

int log_keeper_take(struct log_keeper *k, int wait_ms, struct log_part *part, struct error *error) {
    static struct answer a; /* may be static, because there is only one recorder */
    _Alignas(struct cmsghdr) char control[CMSG_SPACE(sizeof(int))];
    struct iovec data = {.iov_base = &a, .iov_len = sizeof a};
    struct msghdr message = {.msg_iov = &data, .msg_iovlen = 1, .msg_control = control, .msg_controllen = sizeof control};
    struct pollfd p = {.fd = k->socket, .events = POLLIN};
    if (!k->asked) return 0;
    if (wait_ms > 0) poll_any(&p, 1, wait_ms, NULL);
    ssize_t size = recvmsg(k->socket, &message, MSG_DONTWAIT | MSG_CMSG_CLOEXEC);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) return 0;
    k->asked = false;
    k->gone = size != sizeof a;
    if (k->gone) return error_set(error, STATUS_IO, "the process that makes the parts of the log has ended");
    *part = (struct log_part){.file = received_file(&message), .over = a.over};
    memcpy(part->path, a.path, sizeof part->path);
    if (a.error.status) *error = a.error;
    return a.error.status ? STATUS_IO : 1;
}
