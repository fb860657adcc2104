/* SAFETY: one master for each machine on this host, whatever user starts it and however the machine
 * is spelt. What other hosts do is for the device to refuse.
 *
 * A lock is a Unix-domain socket in the abstract namespace of this network: it needs no directory
 * and no file, works in a container and behind the unit's filter, and is gone with its process. A
 * name can be bound by any user, so a lock counts only if its holder may command the machine: root,
 * this user, who may write the device file, or, where there is none, the members of group hexid.
 * Anybody else is a stranger: the lock is taken under another of HOST_LOCK_SLOTS names beside it,
 * and that is said. A stranger who holds them all leaves this host without the lock; a second
 * master is then refused by the machine (its claim, or what is heard on its bus), as from another
 * host. */
#ifndef HEXID_HOST_LOCK_H
#define HEXID_HOST_LOCK_H

#include <sys/types.h>

#include "status.h"

enum { HOST_LOCK_SLOTS = 8, HOST_LOCK_NAME_SIZE = 80 };

struct host_lock_key {
    char name[HOST_LOCK_NAME_SIZE]; /* one for all spellings of a machine */
    mode_t mode;                    /* of its device file, 0: it has none, */
    uid_t owner;                    /* and whose that is */
    gid_t group;
};

/* Main thread, before the machine is opened; may look up users. A descriptor to keep open,
 * STATUS_UNSAFE naming process and user that hold it, STATUS_IO where there are no such sockets.
 * A stranger is named in doubt, whose status is STATUS_OK without one. */
int host_lock(const char *url, const struct host_lock_key *key, struct error *doubt, struct error *error);

/* SAFETY: now and then as long as it is held: lets go of those who have asked. In a queue that is
 * full (net.core.somaxconn) nobody can see who holds the lock, and it no longer counts. Any thread;
 * does not block. */
void host_lock_answer(int lock);

#endif
