/* Prints sentences and rows of tables on a terminal. */
#ifndef HEXID_WORDS_H
#define HEXID_WORDS_H

#include <stdio.h>

enum { WORDS_COLUMNS = 80 };

extern const char *const words_axes[6]; /* x y z φ θ ψ */

/* Prints a label and a text, broken between words at WORDS_COLUMNS; lines after the first are
 * indented. Text in backquotes is not broken. */
void words_print(FILE *out, const char *label, const char *text);

/* Prints like fprintf(), but a "-" in the columns of a number that is not finite. format.h lists
 * the conversions. */
__attribute__((format(printf, 2, 3))) void words_row(FILE *out, const char *format, ...);

#endif
