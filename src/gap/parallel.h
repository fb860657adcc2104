/* Independent work on a few threads at once. Any thread. */
#ifndef HEXID_PARALLEL_H
#define HEXID_PARALLEL_H

/* Calls one(context, i) for every i from 0 to count - 1, in any order, the caller's thread among
 * those that do; returns when all is done. */
void parallel_run(int threads, int count, void (*one)(void *context, int i), void *context);

#endif
