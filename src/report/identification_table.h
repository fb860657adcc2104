/* The result as a table for people, like Tian 2015's Table 3. */
#ifndef HEXID_IDENTIFICATION_TABLE_H
#define HEXID_IDENTIFICATION_TABLE_H

#include <stdio.h>

#include "ident.h"

/* Prints nothing but a line when the methods were not evaluated. */
void identification_table_print(FILE *out, const struct identification *id, bool sinusoids);

#endif
