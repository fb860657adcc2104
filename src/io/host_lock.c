#include "host_lock.h"

#include "local_socket.h"

#include <errno.h>
#include <grp.h>
#include <pwd.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

static const char operators[] = "hexid"; /* group whose members may command; the service runs in
                                          * it */

struct holder {
    struct ucred who; /* credentials at the time of the holder's listen() */
    gid_t group[64];
    int groups;
};

static socklen_t slot_address(const struct host_lock_key *key, int slot, struct sockaddr_un *address) {
    *address = (struct sockaddr_un){.sun_family = AF_UNIX};
    int length = snprintf(address->sun_path + 1, sizeof address->sun_path - 1, "hexid-machine/%s/%d", key->name, slot);
    return (socklen_t)(offsetof(struct sockaddr_un, sun_path) + 1 + (size_t)length);
}

/* Takes the first free slot. Returns its socket, or -1 with errno: EADDRINUSE if no slot is
 * free. */
static int take_slot(const struct host_lock_key *key, int *slot) {
    for (*slot = 0; *slot < HOST_LOCK_SLOTS; ++*slot) {
        struct sockaddr_un address;
        socklen_t length = slot_address(key, *slot, &address);
        int own = local_socket();
        if (own < 0) return -1;
        if (!bind(own, (struct sockaddr *)&address, length) && !listen(own, SOMAXCONN)) return own;
        int reason = errno;
        close(own);
        errno = reason;
        if (reason != EADDRINUSE) return -1;
    }
    return -1;
}

/* Identifies the holder of the slot; returns false if nobody has it. A holder that cannot be
 * identified gets no group and the user (uid_t)-1. */
static bool ask_slot(const struct host_lock_key *key, int slot, struct holder *h) {
    struct sockaddr_un address;
    socklen_t length = slot_address(key, slot, &address), size = sizeof h->who, bytes = sizeof h->group;
    *h = (struct holder){.who = {.uid = (uid_t)-1, .gid = (gid_t)-1}};
    int s = local_socket();
    if (s < 0) return false;
    bool there = !connect(s, (struct sockaddr *)&address, length);
    if (there && !getsockopt(s, SOL_SOCKET, SO_PEERCRED, &h->who, &size) && !getsockopt(s, SOL_SOCKET, SO_PEERGROUPS, h->group, &bytes))
        h->groups = (int)(bytes / sizeof *h->group);
    there = there || errno == EAGAIN; /* a full queue shows that there is a holder */
    close(s);
    return there;
}

static bool is_in(const struct holder *h, gid_t group) {
    for (int i = 0; i < h->groups; i++)
        if (h->group[i] == group) return true;
    return h->who.gid == group;
}

/* SAFETY: returns true if the holder may command the machine. Anybody else's lock does not
 * count. */
static bool may_command(const struct host_lock_key *key, const struct holder *h) {
    if (h->who.uid == (uid_t)-1) return false;
    if (h->who.uid == 0 || h->who.uid == geteuid()) return true;
    if (key->mode)
        return key->mode & S_IWOTH || (key->mode & S_IWGRP && is_in(h, key->group)) || (key->mode & S_IWUSR && h->who.uid == key->owner);
    const struct group *members = getgrnam(operators);
    return members && is_in(h, members->gr_gid);
}

static void describe(const struct holder *h, char *text, size_t size) {
    const struct passwd *user = h->who.uid == (uid_t)-1 ? NULL : getpwuid(h->who.uid);
    if (h->who.uid == (uid_t)-1) snprintf(text, size, "somebody");
    else if (user) snprintf(text, size, "process %ld of user %s", (long)h->who.pid, user->pw_name);
    else snprintf(text, size, "process %ld of user %ld", (long)h->who.pid, (long)h->who.uid);
}

/* SAFETY: first takes a slot, then checks the other slots, so that of two processes that start at
 * once at least one sees the other. */
int host_lock(const char *url, const struct host_lock_key *key, struct error *doubt, struct error *error) {
    int own_slot, own = take_slot(key, &own_slot), reason = errno;
    char who[100];
    struct holder h;
    *doubt = (struct error){0};
    for (int slot = 0; slot < HOST_LOCK_SLOTS; slot++) {
        if (slot == own_slot || !ask_slot(key, slot, &h)) continue;
        describe(&h, who, sizeof who);
        if (may_command(key, &h)) {
            if (own >= 0) close(own);
            return error_set(error, STATUS_UNSAFE,
                             "--hal %.100s: another hexid on this host drives this machine, %s: end it first, a machine has "
                             "one master",
                             url, who);
        }
        error_set(doubt, STATUS_UNSAFE,
                  "--hal %.100s: %s has the lock of this machine on this host, and may not command it (root, this user, %s): it is not "
                  "waited for; a second master is refused by the machine",
                  url, who, key->mode ? "who may write the device" : "group hexid");
    }
    /* If strangers have all slots, take a socket without a name, which locks nothing. */
    if (own < 0 && reason == EADDRINUSE) own = local_socket();
    if (own >= 0) return own;
    return error_set(error, STATUS_IO, "--hal %.100s: no lock against a second master on this host: %s; it takes a Unix-domain socket", url,
                     strerror(reason));
}

void host_lock_answer(int lock) {
    enum { AT_ONCE = 64 };
    for (int i = 0, asked; i < AT_ONCE && (asked = accept4(lock, NULL, NULL, SOCK_NONBLOCK | SOCK_CLOEXEC)) >= 0; i++) close(asked);
}
