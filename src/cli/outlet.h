/* A way to a terminal, pipe or file that never holds the writer up: lines go into a pipe, and
 * a thread of its own copies them to where they belong. SAFETY: a terminal that stalls (a
 * hung ssh) or a reader that sleeps must not keep anybody from stopping the machine; what
 * does not fit is dropped. */
#ifndef HEXID_OUTLET_H
#define HEXID_OUTLET_H

#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>

struct outlet {
    FILE *out;               /* write here, then outlet_flush(); any thread */
    int from, to;            /* the pipe's other end; the file it is copied to */
    pthread_t thread;
    _Atomic long copied;     /* how often something was written to `to` */
};

/* Ordinary threads. 0, or -1: no pipe or no thread. */
int outlet_open(struct outlet *o, int to);

/* Hands over what was written since the last flush, whole, or drops it. At most 4096
 * bytes stay whole. */
void outlet_flush(struct outlet *o);

/* Waits until all has been copied, for as long as copying goes on; gives up after a second without
 * progress: false, and the outlet stays in use by its thread until the process ends. */
bool outlet_close(struct outlet *o);

#endif
