#include "number_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

const char *number_shortest(double number, char text[NUMBER_SIZE]) {
    if (isnan(number)) return "nan";
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(text, NUMBER_SIZE, "%.*g", digits, number);
        if (strtod(text, NULL) == number) break;
    }
    return text;
}
