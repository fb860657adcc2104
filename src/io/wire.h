/* The parts of an LCM message, read by hand from bytes that are not trusted: liblcm would allocate
 * its strings, and would take a length that it cannot fill. Big-endian, in the order of the .lcm
 * file. What runs past the end makes the message no good, and everything after that is 0 or NULL:
 * `good` is looked at once, behind the last part. Ordinary threads, no heap. */
#ifndef HEXID_WIRE_H
#define HEXID_WIRE_H

#include <stdbool.h>
#include <stdint.h>

struct wire {
    const unsigned char *next;
    int left;
    bool good;
};

/* A message of this type, behind its fingerprint. */
struct wire wire_open(const void *data, int size, int64_t type);

/* The next bytes, NULL when there are not so many. */
const unsigned char *wire_take(struct wire *w, int size);

/* 1, 4 or 8 bytes; the first is not extended by its sign. */
int64_t wire_int(struct wire *w, int size);
double wire_double(struct wire *w);

/* 0 or 1; anything else is no good. */
void wire_boolean(struct wire *w);

/* Points into the message and ends there with a zero byte. */
const char *wire_string(struct wire *w);

/* Of elements that follow, each of a byte at least. */
int wire_count(struct wire *w);

#endif
