/* Latest-value mailbox that passes requests from ordinary threads to the loop; the loop itself
 * posts only requests to park. Id and command share one 64-bit atomic, so that no thread ever
 * waits. Several threads may write; a reader sees the newest request, and recognises a new request
 * by its id. */
#ifndef HEXID_MAILBOX_H
#define HEXID_MAILBOX_H

#include <stdatomic.h>

#include "types.h"

struct mailbox {
    _Atomic uint64_t word; /* the request's id in the upper half, its command in the lower */
};

/* Posts a request and returns its id. Before it posts COMMAND_SET, the caller puts the new gains
 * into a gains_box. */
static inline uint32_t mailbox_post(struct mailbox *m, enum command command) {
    uint64_t old = atomic_load_explicit(&m->word, memory_order_relaxed), next;
    do next = (((old >> 32) + 1) << 32) | (uint32_t)command;
    while (!atomic_compare_exchange_weak_explicit(&m->word, &old, next, memory_order_release, memory_order_relaxed));
    return (uint32_t)(next >> 32);
}

/* Returns the newest request, without gains; id 0 if none was posted. */
static inline struct request mailbox_read(const struct mailbox *m) {
    uint64_t word = atomic_load_explicit(&m->word, memory_order_acquire);
    return (struct request){.id = (uint32_t)(word >> 32), .command = (enum command)(word & 0xffffffffu)};
}

/* Passes gains from one writer thread to other threads. A loop has two such boxes: one for new
 * gains, which go to the loop together with a COMMAND_SET in the mailbox, and one for the loop's
 * present gains. The version is odd during a write and changes with each write, so that a reader
 * detects a mixture of two writes. */
struct gains_box {
    _Atomic uint32_t version;
    _Atomic double value[LOOP_GAINS];
};

/* Writes the gains; only one thread may do so. */
static inline void gains_box_put(struct gains_box *box, const struct gains *gains) {
    atomic_fetch_add_explicit(&box->version, 1, memory_order_acq_rel);
    for (int i = 0; i < LOOP_GAINS; i++) atomic_store_explicit(&box->value[i], gains->value[i], memory_order_release);
    atomic_fetch_add_explicit(&box->version, 1, memory_order_release);
}

/* Reads the gains. Returns false if they were written meanwhile; `gains` may then be a mixture.
 * Never waits. */
static inline bool gains_box_get(const struct gains_box *box, struct gains *gains) {
    uint32_t before = atomic_load_explicit(&box->version, memory_order_acquire);
    for (int i = 0; i < LOOP_GAINS; i++) gains->value[i] = atomic_load_explicit(&box->value[i], memory_order_acquire);
    return !(before & 1) && before == atomic_load_explicit(&box->version, memory_order_acquire);
}

#endif
