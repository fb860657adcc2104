/* Reads an LCM message field by field from untrusted bytes. liblcm is not used, because it
 * allocates strings, and believes lengths that exceed the message. Big-endian, in the order of the
 * .lcm file. A field that runs past the end makes the message bad, and every later field 0 or NULL,
 * so that `good` need be checked only once, after the last field. Ordinary threads, no heap. */
#ifndef HEXID_WIRE_H
#define HEXID_WIRE_H

#include <stdbool.h>
#include <stdint.h>

struct wire {
    const unsigned char *next;
    int left;
    bool good;
};

/* Checks the fingerprint of a message and starts reading after it. */
struct wire wire_open(const void *data, int size, int64_t type);

/* Returns the next `size` bytes; NULL if fewer are left. */
const unsigned char *wire_take(struct wire *w, int size);

/* Reads 1, 4 or 8 bytes; 1 and 4 are not sign-extended: cast the result. */
int64_t wire_int(struct wire *w, int size);
double wire_double(struct wire *w);

/* Skips a boolean; anything but 0 and 1 makes the message bad. */
void wire_boolean(struct wire *w);

/* Returns a zero-terminated string inside the message; NULL when bad. */
const char *wire_string(struct wire *w);

/* Reads the number of elements that follow; 0 when bad. A number larger than the bytes that are
 * left makes the message bad, since each element has at least one byte. */
int wire_count(struct wire *w);

#endif
