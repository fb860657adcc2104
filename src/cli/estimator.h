/* Method C on a worker thread, which makes the equations of one recording at a time while its
 * caller goes on. The result does not depend on when. All calls from one thread. */
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
    /* Under the mutex. */
    enum { ESTIMATOR_IDLE, ESTIMATOR_BUSY, ESTIMATOR_DONE } state;
    bool ends;
    struct recording recording;   /* the thread's while it is busy */
    struct equations equations;
    struct error error;
};

/* -3: no thread. */
int estimator_start(struct estimator *e, struct error *error);

/* Waits for what is under way and drops it. Also for one that was never started (zeroed). */
void estimator_stop(struct estimator *e);

/* Takes the recording over with its samples, and leaves an empty one. The estimator must be
 * idle. */
void estimator_give(struct estimator *e, struct recording *recording);

/* Would estimator_take() have something at once? */
bool estimator_ready(struct estimator *e);

/* The result: the equations, or error->status and why there are none. False: nothing was given or,
 * without `wait`, it is not ready. */
bool estimator_take(struct estimator *e, bool wait, struct equations *equations, struct error *error);

/* The same in the calling thread: recording_check(), method_c_check(), method_c_equations(). */
int estimator_equations(struct recording *recording, struct equations *equations, struct error *error);

#endif
