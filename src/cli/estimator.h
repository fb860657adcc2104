/* Runs method C on a worker thread, which makes the equations of one recording at a time while the
 * caller continues. The result does not depend on timing. One thread makes all calls. */
#ifndef HEXID_ESTIMATOR_H
#define HEXID_ESTIMATOR_H

#include <pthread.h>

#include "equations.h"
#include "recording.h"

struct estimator {
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool started;
    /* State of the worker. The mutex protects it. */
    enum { ESTIMATOR_IDLE, ESTIMATOR_BUSY, ESTIMATOR_DONE } state;
    bool ends;
    struct recording recording;   /* only the worker may use it while the worker is busy */
    struct equations equations;
    struct error error;
};

/* Starts the worker. Returns -3 if no thread can be started. */
int estimator_start(struct estimator *e, struct error *error);

/* Waits for the current work and discards it. Accepts an estimator that was never started
 * (zeroed). */
void estimator_stop(struct estimator *e);

/* Takes over the recording with its samples and leaves an empty one. The estimator must be idle. */
void estimator_give(struct estimator *e, struct recording *recording);

/* Returns true if estimator_take() would return a result at once. */
bool estimator_ready(struct estimator *e);

/* Passes on the equations, or in error->status the reason why there are none. Returns false if no
 * recording was given or, without `wait`, its equations are not ready. */
bool estimator_take(struct estimator *e, bool wait, struct equations *equations, struct error *error);

/* Makes the equations in the calling thread: recording_check(), method_c_equations(). */
int estimator_equations(struct recording *recording, struct equations *equations, struct error *error);

#endif
