/* SAFETY: which lock of this host (host_lock.h) a machine has: one for all names of the same
 * serial line, CAN interface or Modbus address. */
#ifndef HEXID_MACHINE_LOCK_H
#define HEXID_MACHINE_LOCK_H

#include "status.h"

enum { MACHINE_LOCKS = 8 }; /* addresses of one name */

struct machine_lock {
    int count, file[MACHINE_LOCKS]; /* descriptors, open as long as the lock is held */
    struct error doubt;             /* a stranger's lock that was passed over; STATUS_OK: none */
};

/* Main thread, before the machine is opened. url: as --hal has it; what is put in front of the
 * machine ("fault:...;") does not count, and a simulated machine has no lock. Names of hosts are
 * looked up. STATUS_UNSAFE: another process has it; STATUS_IO: there is no such line. */
int machine_lock(struct machine_lock *l, const char *url, struct error *error);

/* Calls host_lock_answer() for each of them. */
void machine_lock_answer(const struct machine_lock *l);

void machine_unlock(struct machine_lock *l);

#endif
