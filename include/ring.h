/* Single-producer single-consumer ring of fixed-size elements, lock-free, no heap after init: from
 * the real-time loop to ordinary threads. push: producer thread only, RT, bounded. pop: consumer
 * thread only. */
#ifndef HEXID_RING_H
#define HEXID_RING_H

#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

struct ring {
    unsigned char *slots;
    size_t element_size;
    uint64_t capacity; /* number of slots; a power of two */
    _Alignas(64) _Atomic uint64_t head; /* number of the next slot to write; only the producer
                                         * stores it */
    _Alignas(64) _Atomic uint64_t tail; /* number of the next slot to read; only the consumer stores
                                         * it */
};

/* Prepares a ring; capacity must be a power of two. Returns 0, or -1 if there is no memory. */
static inline int ring_init(struct ring *r, size_t element_size, uint64_t capacity) {
    memset(r, 0, sizeof *r);
    r->slots = calloc(capacity, element_size);
    r->element_size = element_size;
    r->capacity = capacity;
    return r->slots ? 0 : -1;
}

static inline void ring_free(struct ring *r) { free(r->slots); }

static inline uint64_t ring_count(const struct ring *r) {
    uint64_t tail = atomic_load_explicit(&r->tail, memory_order_acquire);
    return atomic_load_explicit(&r->head, memory_order_acquire) - tail;
}

/* Adds an element. Returns false if the ring is full; the element is then not taken. */
static inline bool ring_push(struct ring *r, const void *element) {
    uint64_t head = atomic_load_explicit(&r->head, memory_order_relaxed);
    if (head - atomic_load_explicit(&r->tail, memory_order_acquire) == r->capacity) return false;
    memcpy(r->slots + (head & (r->capacity - 1)) * r->element_size, element, r->element_size);
    atomic_store_explicit(&r->head, head + 1, memory_order_release);
    return true;
}

/* Takes the oldest element. Returns false if the ring is empty. */
static inline bool ring_pop(struct ring *r, void *element) {
    uint64_t tail = atomic_load_explicit(&r->tail, memory_order_relaxed);
    if (tail == atomic_load_explicit(&r->head, memory_order_acquire)) return false;
    memcpy(element, r->slots + (tail & (r->capacity - 1)) * r->element_size, r->element_size);
    atomic_store_explicit(&r->tail, tail + 1, memory_order_release);
    return true;
}

#endif
