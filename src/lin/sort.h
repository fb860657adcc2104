/* Pure. */
#ifndef HEXID_SORT_H
#define HEXID_SORT_H

/* In place, ascending; no NaN among them. */
void sort_ascending(int count, double *value);

#endif
