/* SAFETY: keeps a second process of this host from commanding the same machine (host_lock.h). All
 * names of one serial line, CAN interface or Modbus address lead to the same lock. */
#ifndef HEXID_MACHINE_LOCK_H
#define HEXID_MACHINE_LOCK_H

#include "status.h"

enum { MACHINE_LOCKS = 8 }; /* each address of a host name gets a lock, up to this number */

struct machine_lock {
    int count, file[MACHINE_LOCKS]; /* descriptors, open while the lock is held */
    struct error doubt;             /* names a stranger who held a lock (host_lock.h) and was
                                     * ignored; its status is STATUS_OK if there was none */
};

/* Takes the locks. url: as in --hal; prefixes ("fault:...;") are ignored, and a simulated machine
 * has no lock. Host names are looked up. Main thread, before the machine is opened. STATUS_UNSAFE:
 * another process has a lock; STATUS_USAGE: the Modbus address is malformed; STATUS_IO: there is no
 * such line or host, or this host cannot make locks. */
int machine_lock(struct machine_lock *l, const char *url, struct error *error);

/* SAFETY: calls host_lock_answer() for each lock, which drops the connections of processes that
 * have asked who holds the lock. To be called regularly while the locks are held. */
void machine_lock_answer(const struct machine_lock *l);

void machine_unlock(struct machine_lock *l);

#endif
