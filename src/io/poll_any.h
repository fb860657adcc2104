/* poll(2) for the whole program. poll(2) fails as a whole with EINVAL where RLIMIT_NOFILE, which
 * somebody else may lower at any time (prlimit(1)), is below the number of its entries: a server
 * would serve nobody and spin. Any thread, no heap, no globals. */
#ifndef HEXID_POLL_ANY_H
#define HEXID_POLL_ANY_H

#include <poll.h>
#include <signal.h>

/* Waits for one of these descriptors, which must not block when they are used. timeout_ms: as
 * poll(2), below 0 without end. mask: signals blocked meanwhile (ppoll(2)), NULL: no change.
 * Returns as poll(2). Below the limit it looks at parts every 2 ms; with a limit of 0 nothing can
 * be looked at, and every entry counts as ready. */
int poll_any(struct pollfd *p, nfds_t count, int timeout_ms, const sigset_t *mask);

#endif
