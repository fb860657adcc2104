/* Passes the newest value from one thread to another. Neither thread ever waits, and no older value
 * follows a newer one. The user has three slots, T slot[LATEST_SLOTS]; this struct records which
 * thread uses which slot. One producer, one consumer; RT, signal-safe. */
#ifndef HEXID_LATEST_H
#define HEXID_LATEST_H

#include <stdatomic.h>
#include <stdbool.h>

enum { LATEST_SLOTS = 3, LATEST_NEW = 4 };

struct latest {
    unsigned back, front;     /* slot of the producer; slot of the consumer */
    _Atomic unsigned between; /* third slot; bit LATEST_NEW is set until the consumer takes it */
};

static inline void latest_init(struct latest *l) {
    l->back = 0, l->front = 1;
    atomic_init(&l->between, 2);
}

/* Called by the producer after it has filled slot[l->back], whose value becomes the newest. A value
 * that the consumer has not taken is dropped. */
static inline void latest_publish(struct latest *l) {
    l->back = atomic_exchange_explicit(&l->between, l->back | LATEST_NEW, memory_order_acq_rel) & ~(unsigned)LATEST_NEW;
}

/* Called by the consumer. Returns true if slot[l->front] now has a newer value. */
static inline bool latest_take(struct latest *l) {
    if (!(atomic_load_explicit(&l->between, memory_order_relaxed) & LATEST_NEW)) return false;
    l->front = atomic_exchange_explicit(&l->between, l->front, memory_order_acq_rel) & ~(unsigned)LATEST_NEW;
    return true;
}

#endif
