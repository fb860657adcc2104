/* Sorting of numbers. Pure. */
#ifndef HEXID_SORT_H
#define HEXID_SORT_H

/* Sorts in place, ascending. No value may be NaN. */
void sort_ascending(int count, double *value);

#endif
