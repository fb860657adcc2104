#include "machine_lock.h"

#include <arpa/inet.h>
#include <errno.h>
#include <net/if.h>
#include <netdb.h>
#include <stdbool.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include "backends.h"
#include "host_lock.h"
#include "modbus_link.h"

static int add(struct machine_lock *l, const char *url, const struct host_lock_key *key, struct error *error) {
    struct error doubt;
    int file = host_lock(url, key, &doubt, error);
    if (doubt.status) l->doubt = doubt;
    if (file < 0) return file;
    l->file[l->count++] = file;
    return STATUS_OK;
}

/* Locks a serial line by its device number, which symbolic links and other device nodes of the line
 * share. */
static int lock_serial(struct machine_lock *l, const char *url, const struct modbus_address_parts *p, struct error *error) {
    struct host_lock_key key;
    struct stat s;
    if (stat(p->name, &s)) return modbus_line_refused(p, errno, error);
    key = (struct host_lock_key){.mode = s.st_mode, .owner = s.st_uid, .group = s.st_gid};
    if (S_ISCHR(s.st_mode)) snprintf(key.name, sizeof key.name, "tty/%u:%u", major(s.st_rdev), minor(s.st_rdev));
    else snprintf(key.name, sizeof key.name, "file/%lu:%lu", (unsigned long)s.st_dev, (unsigned long)s.st_ino);
    return add(l, url, &key, error);
}

/* Locks a CAN interface by its name in the kernel, which all altnames share, and which stays the
 * same when the interface is created again. */
static int lock_can(struct machine_lock *l, const char *url, const char *interface, struct error *error) {
    struct host_lock_key key = {0};
    char name[IF_NAMESIZE];
    unsigned index = if_nametoindex(interface);
    bool known = index && if_indextoname(index, name);
    snprintf(key.name, sizeof key.name, "can/%.60s", known ? name : interface);
    return add(l, url, &key, error);
}

/* True if an address belongs to this host: a datagram socket that is connected to an own address
 * has that same address as its local one. Nothing is sent. */
static bool is_own(const struct sockaddr *to, socklen_t length) {
    struct sockaddr_storage own = {0};
    socklen_t size = sizeof own;
    int s = socket(to->sa_family, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    bool same = s >= 0 && !connect(s, to, length) && !getsockname(s, (struct sockaddr *)&own, &size);
    if (s >= 0) close(s);
    if (!same) return false;
    if (to->sa_family == AF_INET) return ((struct sockaddr_in *)&own)->sin_addr.s_addr == ((const struct sockaddr_in *)to)->sin_addr.s_addr;
    return !memcmp(&((struct sockaddr_in6 *)&own)->sin6_addr, &((const struct sockaddr_in6 *)to)->sin6_addr, sizeof(struct in6_addr));
}

static bool is_loopback(const struct sockaddr *a) {
    if (a->sa_family == AF_INET) {
        in_addr_t host = ntohl(((const struct sockaddr_in *)a)->sin_addr.s_addr);
        return host >> 24 == IN_LOOPBACKNET || host == INADDR_ANY;
    }
    const struct in6_addr *host = &((const struct sockaddr_in6 *)a)->sin6_addr;
    return IN6_IS_ADDR_LOOPBACK(host) || IN6_IS_ADDR_UNSPECIFIED(host);
}

/* Writes the address that names the lock. All addresses of this host are written alike, and an
 * IPv4 address inside an IPv6 one is written as IPv4. */
static void address_text(const struct addrinfo *a, char text[INET6_ADDRSTRLEN + IF_NAMESIZE + 1]) {
    const struct sockaddr_in6 *six = (const struct sockaddr_in6 *)a->ai_addr;
    struct sockaddr_in four = {.sin_family = AF_INET};
    const struct sockaddr *address = a->ai_addr;
    socklen_t length = a->ai_addrlen;
    if (a->ai_family == AF_INET6 && IN6_IS_ADDR_V4MAPPED(&six->sin6_addr)) {
        memcpy(&four.sin_addr, &six->sin6_addr.s6_addr[12], sizeof four.sin_addr);
        four.sin_port = six->sin6_port;
        address = (struct sockaddr *)&four, length = sizeof four;
    }
    bool own = is_loopback(address) || is_own(address, length);
    if (own || getnameinfo(address, length, text, INET6_ADDRSTRLEN + IF_NAMESIZE + 1, NULL, 0, NI_NUMERICHOST)) strcpy(text, "this host");
}

static int lock_tcp(struct machine_lock *l, const char *url, const struct modbus_address_parts *p, struct error *error) {
    const struct addrinfo hints = {.ai_family = AF_UNSPEC, .ai_socktype = SOCK_STREAM};
    struct host_lock_key key[MACHINE_LOCKS] = {0};
    struct addrinfo *found;
    int unknown = getaddrinfo(p->name, p->port, &hints, &found), keys = 0, status = STATUS_OK;
    if (unknown) return modbus_line_refused(p, unknown == EAI_SYSTEM ? errno : ECONNREFUSED, error);
    for (const struct addrinfo *a = found; a && keys < MACHINE_LOCKS; a = a->ai_next) {
        char text[INET6_ADDRSTRLEN + IF_NAMESIZE + 1];
        bool again = false;
        address_text(a, text);
        snprintf(key[keys].name, sizeof key[keys].name, "tcp/%s/%s", text, p->port);
        for (int i = 0; i < keys; i++) again |= !strcmp(key[i].name, key[keys].name);
        if (!again) keys++;
    }
    freeaddrinfo(found);
    for (int i = 0; i < keys && !status; i++) status = add(l, url, &key[i], error);
    return status;
}

int machine_lock(struct machine_lock *l, const char *url, struct error *error) {
    const char *last = strrchr(url, ';'), *own = last ? last + 1 : url;
    const struct hal_ops *ops = hal_find(own);
    struct modbus_address_parts parts;
    *l = (struct machine_lock){0};
    if (!ops || ops->simulated) return STATUS_OK; /* hal_open() reports unknown schemes */
    const char *address = own + strlen(ops->scheme) + 1;
    int status = ops == &hal_modbus ? modbus_parse(address, &parts, error) : STATUS_OK;
    if (!status && ops != &hal_modbus) status = lock_can(l, own, address, error);
    else if (!status) status = parts.serial ? lock_serial(l, own, &parts, error) : lock_tcp(l, own, &parts, error);
    if (status) machine_unlock(l);
    return status;
}

void machine_lock_answer(const struct machine_lock *l) {
    for (int i = 0; i < l->count; i++) host_lock_answer(l->file[i]);
}

void machine_unlock(struct machine_lock *l) {
    for (int i = 0; i < l->count; i++) close(l->file[i]);
    l->count = 0;
}
