/* Writes to a terminal, pipe or file without ever delaying the writer: lines go into a pipe, and a
 * thread copies them to their destination. SAFETY: a stalled terminal (a hung ssh) or a sleeping
 * reader must not keep anybody from stopping the machine; lines that do not fit into the pipe are
 * dropped. */
#ifndef HEXID_OUTLET_H
#define HEXID_OUTLET_H

#include <pthread.h>
#include <stdbool.h>
#include <stdio.h>

struct outlet {
    FILE *out;  /* stream that collects the text until outlet_flush() passes it on; any thread may
                 * write */
    int into;                /* write end of the pipe, to which `out` writes */
    int from, to;            /* read end of the pipe, and destination of the text */
    pthread_t thread;
    _Atomic long copied;     /* number of writes to `to`, which shows progress */
};

/* Opens an outlet; ordinary threads. Returns 0, or -1 without a pipe or a thread. */
int outlet_open(struct outlet *o, int to);

/* Passes on the text since the last flush, or drops it if the pipe is full. Up to 4096 bytes are
 * passed on as a whole. */
void outlet_flush(struct outlet *o);

/* Passes on a text of at most 4096 bytes as a whole, or drops it if the pipe is full. Any thread;
 * no lock. Text of `out` that was not flushed yet comes later. */
void outlet_write(struct outlet *o, const char *text);

/* Waits until everything is copied and returns true. After a second without progress it returns
 * false; the thread then keeps using the outlet until the process ends. */
bool outlet_close(struct outlet *o);

#endif
