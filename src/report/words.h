/* Sentences on a terminal. */
#ifndef HEXID_WORDS_H
#define HEXID_WORDS_H

#include <stdio.h>

enum { WORDS_COLUMNS = 80 };

/* Words after a label, broken between them, further lines indented; what stands in
 * backquotes is not broken. */
void words_print(FILE *out, const char *label, const char *text);

#endif
