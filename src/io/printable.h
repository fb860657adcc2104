/* Makes text from elsewhere safe for a terminal: names of files and columns, events of a log,
 * LCM messages. Any thread, no heap. */
#ifndef HEXID_PRINTABLE_H
#define HEXID_PRINTABLE_H

#include <stddef.h>
#include <stdint.h>

/* Returns the length in bytes of the character at p, and its code point; 0: not UTF-8 (RFC 3629:
 * shortest form, no surrogates). Reads no further than a zero byte. */
size_t utf8_decode(const unsigned char *p, uint32_t *point);

/* Copies text with '?' in place of each control character (C0, DEL and C1, which a terminal
 * obeys), each byte that is not UTF-8, and each character that reverses the writing direction or
 * breaks the line (U+200E and F, U+2028 to 202E, U+2066 to 2069). The copy ends with a zero byte
 * and is truncated between characters. size: at least 1. Returns the length. */
size_t text_printable(const char *text, char *out, size_t size);

#endif
