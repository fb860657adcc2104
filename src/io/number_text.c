#include "number_text.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

const char *number_shortest(double number, char text[NUMBER_SIZE]) {
    char plain[NUMBER_SIZE];
    if (isnan(number)) return "nan";
    for (int digits = 15; digits <= 17; digits++) {
        snprintf(plain, sizeof plain, "%.*g", digits, number);
        if (strtod(plain, NULL) == number) break;
    }
    return memcpy(text, plain, sizeof plain);
}
