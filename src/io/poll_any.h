/* poll(2) for the whole program, whatever its limit of open files. poll(2) itself fails with EINVAL
 * if RLIMIT_NOFILE, which somebody else may lower at any time (prlimit(1)), is below the number of
 * its entries: a server would serve nobody and spin. Any thread, no heap, no globals. */
#ifndef HEXID_POLL_ANY_H
#define HEXID_POLL_ANY_H

#include <poll.h>
#include <signal.h>

/* Waits for one of these descriptors. Their use must not block (O_NONBLOCK or MSG_DONTWAIT),
 * because an entry may count as ready without being so. timeout_ms: as for poll(2); below 0:
 * without end. mask: signals blocked meanwhile (ppoll(2)); NULL: no change. Returns as poll(2)
 * does. If RLIMIT_NOFILE is too low, the entries are polled in parts, every 2 ms; with a limit of 0
 * nothing can be polled, and every entry counts as ready. */
int poll_any(struct pollfd *p, nfds_t count, int timeout_ms, const sigset_t *mask);

#endif
