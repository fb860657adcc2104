#include "live_request.h"

#include <arpa/inet.h>
#include <errno.h>
#include <netdb.h>
#include <netinet/in.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/socket.h>
#include <unistd.h>

enum { BACKLOG = 32, SEND_BUFFER = 65536 };

/* ---- addresses ---- */

static int refuse(const char *text, struct error *error) {
    return error_set(error, STATUS_USAGE, "--http %.200s: give an address and a port up to 65535, as 127.0.0.1:8321, [::1]:8321 or 8321",
                     text);
}

static bool parse_port(const char *text, int *port) {
    enum { DIGITS = 5, MOST = 65535 };
    size_t digits = strspn(text, "0123456789");
    *port = digits && digits <= DIGITS && !text[digits] ? atoi(text) : -1;
    return *port >= 0 && *port <= MOST;
}

/* Splits HOST:PORT; an IPv6 host stands in brackets. `port` points into text, or is NULL if
 * there is no port. */
static bool split(const char *text, char host[LIVE_HOST_SIZE], const char **port) {
    bool bracket = *text == '[';
    const char *begin = text + bracket, *end = bracket ? strchr(text, ']') : begin + strcspn(text, ":");
    if (!end || end == begin || end - begin >= LIVE_HOST_SIZE) return false;
    memcpy(host, begin, (size_t)(end - begin));
    host[end - begin] = '\0';
    end += bracket;
    *port = *end == ':' ? end + 1 : NULL;
    return *end == ':' || !*end;
}

int live_address_parse(const char *text, struct live_address *a, struct error *error) {
    const char *port;
    *a = (struct live_address){.host = "127.0.0.1"};
    if (parse_port(text, &a->port)) return STATUS_OK;
    return split(text, a->host, &port) && port && parse_port(port, &a->port) ? STATUS_OK : refuse(text, error);
}

static bool is_loopback(const struct sockaddr *address) {
    if (address->sa_family == AF_INET) {
        struct sockaddr_in in;
        memcpy(&in, address, sizeof in);
        return ntohl(in.sin_addr.s_addr) >> 24 == IN_LOOPBACKNET;
    }
    struct sockaddr_in6 in6;
    memcpy(&in6, address, sizeof in6);
    return IN6_IS_ADDR_LOOPBACK(&in6.sin6_addr);
}

static int port_of(int fd) {
    struct sockaddr_storage own;
    socklen_t length = sizeof own;
    char port[8] = "0";
    if (!getsockname(fd, (struct sockaddr *)&own, &length))
        getnameinfo((struct sockaddr *)&own, length, NULL, 0, port, sizeof port, NI_NUMERICHOST | NI_NUMERICSERV);
    return atoi(port);
}

/* Opens a listening socket at an address. Returns the socket, or -1 with errno. */
static int listen_at(const struct addrinfo *at) {
    int yes = 1, room = SEND_BUFFER, fd = socket(at->ai_family, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    if (fd < 0) return -1;
    /* Connections inherit this small send buffer, so that only little data waits in the kernel for
     * a slow reader. */
    setsockopt(fd, SOL_SOCKET, SO_SNDBUF, &room, sizeof room);
    if (!setsockopt(fd, SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes) && !bind(fd, at->ai_addr, at->ai_addrlen) && !listen(fd, BACKLOG))
        return fd;
    int reason = errno;
    close(fd);
    errno = reason;
    return -1;
}

static const char *remedy(int reason) {
    switch (reason) {
    case EADDRINUSE: return "another program has this port: end it, or choose another";
    case EADDRNOTAVAIL: return "this is no address of this host: `ip address` lists them";
    case EACCES: return "ports below 1024 need rights: choose another";
    default: return "choose another address";
    }
}

int live_listen(const struct live_address *a, struct live_listener *l, struct error *error) {
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM, .ai_flags = AI_NUMERICSERV};
    struct addrinfo *found = NULL;
    char port[8];
    snprintf(port, sizeof port, "%d", a->port);
    int unknown = getaddrinfo(a->host, port, &hints, &found);
    if (unknown) return error_set(error, STATUS_IO, "--http %.200s: no such host: %s", a->host, gai_strerror(unknown));
    l->fd = -1;
    for (const struct addrinfo *at = found; at && l->fd < 0; at = at->ai_next) {
        l->fd = listen_at(at);
        l->loopback = is_loopback(at->ai_addr);
    }
    int reason = errno;
    freeaddrinfo(found);
    if (l->fd < 0) return error_set(error, STATUS_IO, "--http %.200s:%d: %s: %s", a->host, a->port, strerror(reason), remedy(reason));
    bool colons = strchr(a->host, ':') != NULL;
    snprintf(l->url, sizeof l->url, "http://%s%s%s:%d/", colons ? "[" : "", a->host, colons ? "]" : "", port_of(l->fd));
    return STATUS_OK;
}

/* ---- requests ---- */

static bool is_address(const char *host) {
    unsigned char binary[sizeof(struct in6_addr)];
    return inet_pton(AF_INET, host, binary) == 1 || inet_pton(AF_INET6, host, binary) == 1;
}

bool live_host_allowed(const char *host, const char *served, const char *own_name) {
    char name[LIVE_HOST_SIZE];
    const char *port;
    int number;
    if (!host || !split(host, name, &port) || (port && !parse_port(port, &number))) return false;
    return is_address(name) || !strcasecmp(name, "localhost") || !strcasecmp(name, served) || (*own_name && !strcasecmp(name, own_name));
}
