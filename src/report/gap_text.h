/* The result of `hexid gap` for a terminal, in lines of about 80 columns. */
#ifndef HEXID_GAP_TEXT_H
#define HEXID_GAP_TEXT_H

#include <stdio.h>

#include "gap_result.h"

void gap_text_print(FILE *out, const struct gap_result *result);

#endif
