/* Makes text from elsewhere fit for a terminal: names of files and columns, events of a log, LCM
 * messages. Any thread, no heap. */
#ifndef HEXID_PRINTABLE_H
#define HEXID_PRINTABLE_H

#include <stddef.h>
#include <stdint.h>

/* Length in bytes of the character that begins at p, and its code point; 0: not UTF-8 (RFC 3629:
 * shortest form, no surrogates). Reads no further than a zero byte. */
size_t utf8_decode(const unsigned char *p, uint32_t *point);

/* Copies text with '?' in place of each control character (C0, DEL, C1: what a terminal obeys),
 * each byte that is not UTF-8, and each character that reverses the direction of what follows or
 * breaks the line (U+200E and F, U+2028 to 202E, U+2066 to 2069). Ends with a zero byte, never
 * inside a character; what does not fit is cut off. size: at least 1. Returns the length. */
size_t text_printable(const char *text, char *out, size_t size);

#endif
