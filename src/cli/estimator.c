#include "estimator.h"

#include "crash.h"
#include "method_c.h"
#include "thread.h"

int estimator_equations(struct recording *raw, struct measured_recording *measured, struct admission *admission,
                        struct equations *equations, struct error *error) {
    *error = (struct error){0};
    recording_settle(raw);
    int status = measured_add(measured, raw, error);
    if (!status) status = admit(raw, measured, admission, error);
    return status ? status : method_c_equations(&measured->recording, equations, error);
}

static void *estimator_thread(void *argument) {
    struct estimator *e = argument;
    crash_stack();
    pthread_mutex_lock(&e->mutex);
    for (;;) {
        while (e->state != ESTIMATOR_BUSY && !e->ends) pthread_cond_wait(&e->changed, &e->mutex);
        if (e->state != ESTIMATOR_BUSY) break;
        pthread_mutex_unlock(&e->mutex); /* while the worker is busy, only it uses the recording */
        struct admission unused = {0};
        e->measured = (struct measured_recording){0};
        estimator_equations(&e->recording, &e->measured, &unused, &e->equations, &e->error);
        measured_free(&e->measured);
        recording_free(&e->recording);
        pthread_mutex_lock(&e->mutex);
        e->state = ESTIMATOR_DONE;
        pthread_cond_broadcast(&e->changed);
    }
    pthread_mutex_unlock(&e->mutex);
    return NULL;
}

int estimator_start(struct estimator *e, struct error *error) {
    pthread_mutex_init(&e->mutex, NULL);
    pthread_cond_init(&e->changed, NULL);
    e->state = ESTIMATOR_IDLE, e->ends = false;
    int status = thread_start(&e->thread, "estimator", THREAD_STACK_IDENTIFY, estimator_thread, e, error);
    e->started = !status;
    return status;
}

void estimator_stop(struct estimator *e) {
    if (!e->started) return;
    pthread_mutex_lock(&e->mutex);
    e->ends = true;
    pthread_cond_broadcast(&e->changed);
    pthread_mutex_unlock(&e->mutex);
    pthread_join(e->thread, NULL);
    pthread_cond_destroy(&e->changed);
    pthread_mutex_destroy(&e->mutex);
    e->started = false;
}

void estimator_give(struct estimator *e, struct recording *recording) {
    pthread_mutex_lock(&e->mutex);
    e->recording = *recording;
    e->state = ESTIMATOR_BUSY;
    pthread_cond_broadcast(&e->changed);
    pthread_mutex_unlock(&e->mutex);
    recording->tests = 0;
}

bool estimator_ready(struct estimator *e) {
    if (!e->started) return false;
    pthread_mutex_lock(&e->mutex);
    bool ready = e->state == ESTIMATOR_DONE;
    pthread_mutex_unlock(&e->mutex);
    return ready;
}

bool estimator_take(struct estimator *e, bool wait, struct equations *equations, struct error *error) {
    pthread_mutex_lock(&e->mutex);
    while (wait && e->state == ESTIMATOR_BUSY) pthread_cond_wait(&e->changed, &e->mutex);
    bool done = e->state == ESTIMATOR_DONE;
    if (done) {
        *equations = e->equations, *error = e->error;
        e->state = ESTIMATOR_IDLE;
    }
    pthread_mutex_unlock(&e->mutex);
    return done;
}
