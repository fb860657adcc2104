#include "sort.h"

#include <stdlib.h>

static int ascending(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

void sort_ascending(int count, double *value) { qsort(value, (size_t)count, sizeof *value, ascending); }
