#include "notify.h"

#include <errno.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <time.h>
#include <unistd.h>

#include "monotonic.h"
#include "units.h"

enum { NONE = -1 };

/* Returns the time within which the manager wants a "WATCHDOG=1"; 0: it wants none, wants it from
 * another process, or the number is invalid. */
static int64_t watchdog_ns(void) {
    const char *time_us = getenv("WATCHDOG_USEC"), *process = getenv("WATCHDOG_PID");
    if (!time_us || (process && strtoll(process, NULL, 10) != getpid())) return 0;
    long long us = strtoll(time_us, NULL, 10);
    return us > 0 && us < INT64_MAX / NS_PER_US ? us * NS_PER_US : 0;
}

/* Connects to the manager's socket. "@NAME" is an abstract name, without a file: its first byte is
 * zero. */
static int connect_to(const char *path) {
    struct sockaddr_un to = {.sun_family = AF_UNIX};
    size_t length = strlen(path);
    if ((path[0] != '/' && path[0] != '@') || length < 2 || length >= sizeof to.sun_path) {
        errno = EINVAL;
        return NONE;
    }
    memcpy(to.sun_path, path, length);
    if (path[0] == '@') to.sun_path[0] = '\0';
    int file = socket(AF_UNIX, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (file < 0 || !connect(file, (struct sockaddr *)&to, (socklen_t)(offsetof(struct sockaddr_un, sun_path) + length))) return file;
    int reason = errno;
    close(file);
    errno = reason;
    return NONE;
}

int notify_open(struct notify *n, struct error *error) {
    const char *path = getenv("NOTIFY_SOCKET");
    *n = (struct notify){.socket = NONE};
    if (!path || !*path) return STATUS_OK;
    n->socket = connect_to(path);
    if (n->socket < 0)
        return error_set(error, STATUS_IO, "NOTIFY_SOCKET=%.120s: the service manager cannot be told: %s", path, strerror(errno));
    n->every_ns = watchdog_ns() / 2;
    return STATUS_OK;
}

void notify_send(const struct notify *n, const char *lines) {
    if (n->socket >= 0) (void)!send(n->socket, lines, strlen(lines), MSG_DONTWAIT | MSG_NOSIGNAL);
}

void notify_alive(struct notify *n) {
    if (n->socket < 0 || n->every_ns == 0) return;
    int64_t now_ns = monotonic_ns();
    if (n->alive_ns && now_ns - n->alive_ns < n->every_ns) return;
    n->alive_ns = now_ns;
    notify_send(n, "WATCHDOG=1");
}

void notify_close(struct notify *n) {
    if (n->socket >= 0) close(n->socket);
    n->socket = NONE;
}
