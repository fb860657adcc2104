/* SAFETY: one master for each machine on this host, whichever user starts it and however its
 * address is written. Masters on other hosts are refused by the device.
 *
 * A lock is a Unix-domain socket in the abstract namespace of this network namespace: it needs no
 * directory and no file, works in a container and under the service unit's restrictions, and ends
 * with its process. Any user can bind a name, so a lock counts only if its holder may command the
 * machine: root, this user, whoever may write the device file, or, without such a file, members
 * of group hexid. Anybody else is a stranger: the lock is then taken under another of
 * HOST_LOCK_SLOTS names, and the stranger is reported. A stranger who holds all of them leaves
 * this host without the lock; then only the machine refuses a second master (its claim, or
 * traffic on its bus), as it does for other hosts. */
#ifndef HEXID_HOST_LOCK_H
#define HEXID_HOST_LOCK_H

#include <sys/types.h>

#include "status.h"

enum { HOST_LOCK_SLOTS = 8, HOST_LOCK_NAME_SIZE = 80 };

struct host_lock_key {
    char name[HOST_LOCK_NAME_SIZE]; /* name of the machine, the same for all spellings of its
                                     * address */
    mode_t mode;                    /* mode of the machine's device file; 0: it has none */
    uid_t owner;                    /* owner of the device file */
    gid_t group;                    /* group of the device file */
};

/* Takes the lock. Main thread, before the machine is opened; may look up users. Returns a
 * descriptor to keep open; STATUS_UNSAFE naming process and user of the holder; STATUS_IO if the
 * host has no such sockets. `doubt` names a stranger; its status is STATUS_OK without one. */
int host_lock(const char *url, const struct host_lock_key *key, struct error *doubt, struct error *error);

/* SAFETY: drops the connections by which other processes asked who holds the lock; to be called
 * regularly while the lock is held. If their queue is full (net.core.somaxconn), nobody can
 * identify the holder, and the lock no longer counts. Any thread; does not block. */
void host_lock_answer(int lock);

#endif
