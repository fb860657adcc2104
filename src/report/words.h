/* Prints sentences on a terminal. */
#ifndef HEXID_WORDS_H
#define HEXID_WORDS_H

#include <stdio.h>

enum { WORDS_COLUMNS = 80 };

/* Prints a text after a label, broken between words, with its lines indented. Text in backquotes is
 * not broken. */
void words_print(FILE *out, const char *label, const char *text);

#endif
