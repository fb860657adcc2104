/* Runs independent work on several threads. Any thread. */
#ifndef HEXID_PARALLEL_H
#define HEXID_PARALLEL_H

/* Calls one(context, i) for i = 0 .. count - 1 in any order, on at most `threads` threads, the
 * caller's among them; returns when all calls are done. */
void parallel_run(int threads, int count, void (*one)(void *context, int i), void *context);

#endif
