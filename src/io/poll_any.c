#include "poll_any.h"

#include <errno.h>
#include <stddef.h>

#include "monotonic.h"

enum { REST_MS = 2 };

static struct timespec from_ms(int64_t ms) { return (struct timespec){.tv_sec = ms / MS_PER_S, .tv_nsec = ms % MS_PER_S * NS_PER_MS}; }

/* Polls the descriptors without waiting, in halves if RLIMIT_NOFILE is below their number. */
static int look(struct pollfd *p, nfds_t count) {
    int ready = poll(p, count, 0);
    if (ready >= 0 || errno != EINVAL) return ready;
    if (count == 1) {
        p->revents = p->fd >= 0 ? p->events : 0;
        return p->revents != 0;
    }
    int first = look(p, count / 2), second = first < 0 ? first : look(p + count / 2, count - count / 2);
    return second < 0 ? second : first + second;
}

/* Waits in steps of REST_MS, because under that low limit no single call can wait for all
 * descriptors. */
static int look_again(struct pollfd *p, nfds_t count, int timeout_ms, const sigset_t *mask) {
    const struct timespec rest = from_ms(REST_MS);
    int64_t end_ms = monotonic_ms() + timeout_ms;
    int ready = 0;
    do {
        if (timeout_ms != 0 && ppoll(NULL, 0, &rest, mask) < 0) return -1;
        ready = look(p, count);
    } while (!ready && (timeout_ms < 0 || monotonic_ms() < end_ms));
    return ready;
}

int poll_any(struct pollfd *p, nfds_t count, int timeout_ms, const sigset_t *mask) {
    const struct timespec timeout = from_ms(timeout_ms);
    int ready = ppoll(p, count, timeout_ms < 0 ? NULL : &timeout, mask);
    return ready >= 0 || errno != EINVAL ? ready : look_again(p, count, timeout_ms, mask);
}
