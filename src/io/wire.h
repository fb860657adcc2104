/* Reads an LCM message part by part, from bytes that are not trusted: liblcm would allocate its
 * strings, and would believe a length that the message cannot fill. Big-endian, in the order of the
 * .lcm file. A part that runs past the end makes the message bad, and every part after it is 0 or
 * NULL: `good` is looked at once, after the last part. Ordinary threads, no heap. */
#ifndef HEXID_WIRE_H
#define HEXID_WIRE_H

#include <stdbool.h>
#include <stdint.h>

struct wire {
    const unsigned char *next;
    int left;
    bool good;
};

/* A message of the type with this fingerprint, read from behind the fingerprint on. */
struct wire wire_open(const void *data, int size, int64_t type);

/* The next `size` bytes; NULL when there are not so many. */
const unsigned char *wire_take(struct wire *w, int size);

/* 1, 4 or 8 bytes; 1 and 4 are not sign-extended: cast the result. */
int64_t wire_int(struct wire *w, int size);
double wire_double(struct wire *w);

/* Skips a boolean; anything but 0 and 1 makes the message bad. */
void wire_boolean(struct wire *w);

/* Points into the message and ends there with its zero byte; NULL when bad. */
const char *wire_string(struct wire *w);

/* Number of elements that follow, each of at least one byte; 0 when bad. */
int wire_count(struct wire *w);

#endif
