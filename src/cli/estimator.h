/* A worker thread for method C, which sets up the equations of one recording at a time while the
 * caller continues. The result does not depend on timing. One thread makes all calls. */
#ifndef HEXID_ESTIMATOR_H
#define HEXID_ESTIMATOR_H

#include <pthread.h>

#include "equations.h"
#include "admit.h"

struct estimator {
    pthread_t thread;
    pthread_mutex_t mutex;
    pthread_cond_t changed;
    bool started;
    /* State of the worker. The mutex protects it. */
    enum { ESTIMATOR_IDLE, ESTIMATOR_BUSY, ESTIMATOR_DONE } state;
    bool ends;
    struct measured_recording measured; /* measurements of `recording`; only the worker uses them */
    struct recording recording;   /* only the worker may use it while the worker is busy */
    struct equations equations;
    struct error error;
};

/* Starts the worker. Returns -3 if no thread can be started. */
int estimator_start(struct estimator *e, struct error *error);

/* Waits until the current work is finished, discards its result and ends the worker. Accepts a
 * zeroed estimator that was never started. */
void estimator_stop(struct estimator *e);

/* Starts the work on a recording: takes over its samples and leaves it empty. The worker must be
 * idle. */
void estimator_give(struct estimator *e, struct recording *recording);

/* Returns true if estimator_take() would return a result at once. */
bool estimator_ready(struct estimator *e);

/* Gets the equations; if there are none, `error` has the reason, otherwise its status is 0. Returns
 * false if no recording was given or, without `wait`, its equations are not ready. */
bool estimator_take(struct estimator *e, bool wait, struct equations *equations, struct error *error);

/* Sets up the equations in the calling thread: settles, measures and admits the raw recording, and
 * makes the equations from `measured`, which must be zeroed before. The caller frees `measured`,
 * even after an error. */
int estimator_equations(struct recording *raw, struct measured_recording *measured, struct admission *admission,
                        struct equations *equations, struct error *error);

#endif
