/* Sentences on a terminal. */
#ifndef HEXID_WORDS_H
#define HEXID_WORDS_H

#include <stdio.h>

enum { WORDS_COLUMNS = 80 };

/* Prints text after a label, broken between words and indented; backquoted text is not broken. */
void words_print(FILE *out, const char *label, const char *text);

#endif
