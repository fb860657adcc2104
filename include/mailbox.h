/* Latest-value mailbox for a struct request, from ordinary threads to the loop: one 64-bit atomic,
 * so neither side ever waits. Several writers are allowed; a reader sees the newest request and
 * tells a new one by its id. */
#ifndef HEXID_MAILBOX_H
#define HEXID_MAILBOX_H

#include <stdatomic.h>

#include "types.h"

struct mailbox {
    _Atomic uint64_t word; /* request: its id in the upper half, its command in the lower */
};

/* Posts a request and returns its id. */
static inline uint32_t mailbox_post(struct mailbox *m, enum command command) {
    uint64_t old = atomic_load_explicit(&m->word, memory_order_relaxed), next;
    do next = (((old >> 32) + 1) << 32) | (uint32_t)command;
    while (!atomic_compare_exchange_weak_explicit(&m->word, &old, next, memory_order_release, memory_order_relaxed));
    return (uint32_t)(next >> 32);
}

static inline struct request mailbox_read(const struct mailbox *m) {
    uint64_t word = atomic_load_explicit(&m->word, memory_order_acquire);
    return (struct request){.id = (uint32_t)(word >> 32), .command = (enum command)(word & 0xffffffffu)};
}

#endif
